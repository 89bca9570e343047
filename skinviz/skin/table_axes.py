"""Where the nodes of a reflectance table lie: few of them, by the model's own bends.

Along one parameter light first falls fast, then ever more slowly. In
u = ln(1 + rate · x), x from 0 to 1 over the box, it is nearly as smooth as it gets if
the rate fits; how well it fits is measured on lines through the box.
"""

from __future__ import annotations

from collections.abc import Callable
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


def fitting_axis(
    column: int, channels: Channels, low: Array, high: Array, tolerance: Array
) -> Axis:
    """Return the axis of fewest nodes that keeps (c,) tolerances on its own lines."""
    best, need = 1.0, np.inf
    for cells, powers in _SWEEPS:
        rates = 10.0**powers
        best, need = _best(column, channels, (low, high), rates, cells, tolerance)
        if need <= _ENOUGH * cells:
            break
    tried = int(np.clip(np.ceil(need), _FEWEST, _MOST_TRIED))
    near = best * 10.0 ** np.array([-0.5, 0.0, 0.5])
    best, need = _best(column, channels, (low, high), near, tried, tolerance)
    cells = int(np.ceil(max(need, _FEWEST)))
    return Axis(column, float(low[column]), float(high[column]), best, cells)


def grown(axes: tuple[Axis, ...], factor: float) -> tuple[int, ...]:
    """Return the cells of axes made finer by a factor, by one cell at least."""
    return tuple(max(axis.cells + 1, int(np.ceil(axis.cells * factor))) for axis in axes)


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


def _best(
    column: int,
    channels: Channels,
    box: tuple[Array, Array],
    rates: Array,
    cells: int,
    tolerance: Array,
) -> tuple[float, float]:
    """Return the rate that needs the fewest cells, and how many it needs."""
    low, high = box
    steps = np.arange(2 * cells + 1) / 2
    own = [
        Axis(column, low[column], high[column], rate, cells).places(steps)
        for rate in rates
    ]
    lines = low + (high - low) * _LINES[:, None]
    values = np.tile(lines, (rates.size, steps.size, 1, 1))  # rate, step, line, p
    values[..., column] = np.array(own)[:, :, None]
    found = channels(values.reshape(-1, low.size))
    found = found.reshape(rates.size, steps.size, _LINES.size, -1)
    between = np.einsum("sn,rnlc->rslc", _midway(cells), found[:, ::2])
    error = np.abs(between - found[:, 1::2]).max(axis=(1, 2))
    worst = (error / tolerance).max(axis=1)
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
