"""Where the nodes of a reflectance table lie: few of them, by the model's own bends.

Along one parameter light first falls fast, then ever more slowly. In
u = ln(1 + rate · x), x from 0 to 1 over the box, it is nearly as smooth as it gets if
the rate fits; how well it fits is measured on lines through the box.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.table_kernels import TAPS

Array = NDArray[np.float64]
Channels = Callable[[Array], Array]
"""From parameters (m, p) to what the table holds (m, c)."""

_ORDER = TAPS  # the error falls as 1/cells to this power
_FEWEST = TAPS - 1  # cells that a cubic needs
_SWEEPS = (  # cells, and powers of ten of the rate, tried in turn
    (4, np.arange(-1.0, 6.0)),
    (16, np.arange(-1.0, 19.0)),
    (64, np.arange(-1.0, 19.0)),
)
_ENOUGH = 3.0  # times the cells that were tried: so far the error's law is trusted
_MOST_TRIED = 64
_LINES = np.array([0.0, 1e-4, 1e-2, 0.2, 1.0])  # where all other parameters are


@dataclass(frozen=True)
class Axis:
    """Nodes of one parameter, evenly spaced in ln(1 + rate · x).

    Attributes
    ----------
    column : int
        Which parameter.
    low, high : float
        Its range, where x is 0 and 1.
    rate : float
        How much finer the nodes lie at the low end than at the high one, less 1. [1]
    cells : int
        Steps between nodes, one fewer than nodes.
    """

    column: int
    low: float
    high: float
    rate: float
    cells: int

    def places(self, steps: Array) -> Array:
        """Return the parameter at steps from 0 to ``cells``, whole ones at nodes."""
        x = np.expm1(np.log1p(self.rate) * steps / self.cells) / self.rate
        return np.clip(self.low + (self.high - self.low) * x, self.low, self.high)

    @property
    def nodes(self) -> Array:
        """The parameter at the nodes (cells + 1,)."""
        return self.places(np.arange(self.cells + 1.0))


@dataclass(frozen=True)
class _Trial:
    """Rates to be tried for one parameter, each with that many cells."""

    column: int
    rates: Array
    cells: int


def fitting_axes(
    columns: Sequence[int], channels: Channels, low: Array, high: Array, share: Array
) -> tuple[Axis, ...]:
    """Return axes of as few nodes as keep errors (c,) on the lines that are tried."""
    found: dict[int, tuple[float, float, int]] = {}
    left = list(columns)
    for cells, powers in _SWEEPS:
        trials = [_Trial(k, 10.0**powers, cells) for k in left]
        for k, (rate, need) in zip(
            left, _judged(trials, channels, low, high, share), strict=True
        ):
            tried = int(np.clip(np.ceil(need), _FEWEST, _MOST_TRIED))
            found[k] = (rate, need, tried)
        left = [k for k in left if found[k][1] > _ENOUGH * cells]
        if not left:
            break
    near = 10.0 ** np.array([-0.5, 0.0, 0.5])
    trials = [_Trial(k, found[k][0] * near, found[k][2]) for k in columns]
    judged = _judged(trials, channels, low, high, share)
    return tuple(
        Axis(k, float(low[k]), float(high[k]), rate, math.ceil(max(need, _FEWEST)))
        for k, (rate, need) in zip(columns, judged, strict=True)
    )


def grown(axes: tuple[Axis, ...], factor: float) -> tuple[int, ...]:
    """Return the cells of axes made finer by a factor, by one cell at least."""
    return tuple(
        max(axis.cells + 1, int(np.ceil(axis.cells * factor))) for axis in axes
    )


def at_most(cells: tuple[int, ...], most: int) -> tuple[int, ...]:
    """Return cells, all fewer by one factor if their nodes were more than ``most``."""
    kept = np.array(cells)
    while np.prod(kept + 1.0) > most:
        reducible = kept > _FEWEST
        excess = (np.prod(kept + 1.0) / most) ** (1 / max(reducible.sum(), 1))
        fewer = np.minimum(np.floor((kept + 1) / excess) - 1, kept - 1)
        kept = np.where(reducible, np.maximum(fewer, _FEWEST), kept).astype(int)
    return tuple(int(n) for n in kept)


def refinement(error: Array, tolerance: Array) -> float:
    """Return how many times as many cells turn errors (c,) into tolerances."""
    return float((error / tolerance).max() ** (1 / _ORDER))


def _judged(
    trials: Sequence[_Trial], channels: Channels, low: Array, high: Array, share: Array
) -> list[tuple[float, float]]:
    """Return each trial's best rate, and how many cells that one needs."""
    values = [_lines(trial, low, high) for trial in trials]
    ends = np.cumsum([len(own) for own in values])[:-1]
    if not values:
        return []
    # All in one call: each takes a while to begin.
    found = np.split(channels(np.concatenate(values)), ends)
    return [_best(*both, share) for both in zip(trials, found, strict=True)]


def _lines(trial: _Trial, low: Array, high: Array) -> Array:
    """Return nodes and mid-cells (n, p) of each rate on each line."""
    k, cells = trial.column, trial.cells
    steps = np.arange(2 * cells + 1) / 2
    own = [Axis(k, low[k], high[k], rate, cells).places(steps) for rate in trial.rates]
    lines = low + (high - low) * _LINES[:, None]
    values = np.tile(lines, (trial.rates.size, steps.size, 1, 1))
    values[..., k] = np.array(own)[:, :, None]
    return values.reshape(-1, low.size)


def _best(trial: _Trial, found: Array, share: Array) -> tuple[float, float]:
    """Return the rate that needs the fewest cells, and how many it needs."""
    rates, cells = trial.rates, trial.cells
    found = found.reshape(rates.size, 2 * cells + 1, _LINES.size, -1)
    between = np.einsum("sn,rnlc->rslc", _midway(cells), found[:, ::2])
    error = np.abs(between - found[:, 1::2]).max(axis=(1, 2))
    worst = (error / share).max(axis=1)
    # Of rates that are as good, such as all that see no more than a step, the highest.
    last = rates.size - 1 - int(worst[::-1].argmin())
    return float(rates[last]), float(cells * worst[last] ** (1 / _ORDER))


def _midway(cells: int) -> Array:
    """Return the cubic's weights (cells, cells + 1) of the nodes in mid-cell."""
    weights = np.zeros((cells, cells + 1))
    for cell in range(cells):
        first = min(max(cell - 1, 0), cells - _FEWEST)
        t = cell + 0.5 - first
        a, b, c = t - 1, t - 2, t - 3
        own = (-a * b * c / 6, t * b * c / 2, -t * a * c / 2, t * a * b / 6)
        weights[cell, first : first + TAPS] = own
    return weights
