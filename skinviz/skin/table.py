"""A table of a model's light over a box of its parameters, for pigment maps.

Where parameters vary from point to point, a model costs microseconds a point; a table
costs a few dozen nanoseconds, once its nodes are computed. What it holds may be the
model's reflectances or sums of them, such as tristimulus values.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from skinviz._threads import even_size, in_slices
from skinviz._validate import as_numbers, as_spectra
from skinviz.errors import ArgumentError
from skinviz.skin.model import SkinModel
from skinviz.skin.table_axes import (
    Axis,
    at_most,
    fitting_axes,
    grown,
    refinement,
)
from skinviz.skin.table_kernels import TAPS, interpolate

Array = NDArray[np.float64]

SAFETY = 1.5
"""Factor from the largest error that was found between nodes to the one stated."""

_CHECKS = 2048  # places between nodes where the error is measured, at least
_SHARE = 4  # cells for each further one
_END_CELL = 0.38  # from an axis' end to where the cubic is furthest off there
_ROUNDS = 5  # times that a table is made finer
_CHUNK = 8192  # points that a thread looks up in one go
_SLACK = 8 * np.finfo(np.float64).eps  # of a bound: what rounding may add to it
_LEAST_SPAN = 1e-200  # of a range that takes an axis


@dataclass(frozen=True, eq=False)
class ReflectanceTable:
    """Channels of a model's light over a box, and how far they may be off.

    Attributes
    ----------
    low, high : (p,) ndarray of float64
        The box of the model's parameters.
    axes : tuple of Axis
        Those parameters that vary in it, in the model's order.
    entries : (nodes of the first axis, ..., c) ndarray of float32 or float64
        The channels at the nodes.
    error : (c,) ndarray of float64
        Largest absolute error of each channel: that found in the cells at all corners
        of the box and at centres of cells, edges and faces (2048 and one for each
        four cells, drawn from a fixed seed), times :data:`SAFETY`, plus rounding.
    """

    low: Array
    high: Array
    axes: tuple[Axis, ...]
    entries: NDArray[Any]
    error: Array

    @property
    def size(self) -> int:
        """How many nodes it has."""
        return self.entries[..., 0].size

    def at(self, values: ArrayLike, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Return the channels at parameters within the box.

        Parameters
        ----------
        values : (m, p) array_like
            In the order of the model's ``parameters``.
        out : (m, c) ndarray, optional
            Where to write, C-contiguous, of the table's own dtype.

        Returns
        -------
        channels : (m, c) ndarray of the table's dtype

        Raises
        ------
        ArgumentError
            If a value is not finite or outside the box by more than rounding, or
            a shape or dtype does not fit.
        """
        given = as_numbers(values, "values")
        if given.ndim != 2 or given.shape[1] != self.low.size:
            raise ArgumentError(
                f"values must be (m, {self.low.size}), a parameter a column; got "
                f"shape {given.shape}"
            )
        given = np.require(given, requirements=["C", "W"])
        channels = self._room(given.shape[0], out)
        axes, strides = self._layout()
        slack = _SLACK * np.maximum(np.abs(self.low), np.abs(self.high))
        bounds = np.stack([self.low - slack, self.high + slack])
        flat = self.entries.reshape(-1)
        if not self.axes:  # four nodes are read, though three weigh nothing
            flat = np.tile(flat, TAPS)
        outside: list[int] = []

        def fill(rows: slice) -> None:
            found = channels[rows]
            outside.append(interpolate(given[rows], bounds, axes, strides, flat, found))

        # A few are not worth the start of threads.
        size = even_size(len(given), _CHUNK) if len(given) > _CHUNK else _CHUNK
        in_slices(fill, len(given), size)
        if sum(outside):
            self._refuse(given, bounds)
        return channels

    def _room(self, m: int, out: NDArray[Any] | None) -> NDArray[Any]:
        """Return where to write, after a look at what was given."""
        shape = (m, self.error.size)
        if out is None:
            return np.zeros(shape, self.entries.dtype)
        fits = isinstance(out, np.ndarray) and out.shape == shape
        usable = fits and out.flags.c_contiguous and out.flags.writeable
        if not usable or out.dtype != self.entries.dtype:
            raise ArgumentError(
                f"out must be a writeable C-contiguous {self.entries.dtype} array of "
                f"shape {shape}"
            )
        return out

    def _layout(self) -> tuple[Array, NDArray[np.int64]]:
        """Return rows of axes and strides for compiled code, which wants two axes."""
        idle = 2 - len(self.axes)
        # An idle axis has its one value at a node, and no stride.
        rows = [[0.0, 1.0, 1.0, 0.0, float(TAPS), 0.0]] * idle
        for a in self.axes:
            scale = a.cells / np.log1p(a.rate)
            rows.append([a.low, a.high, a.rate, scale, a.cells, a.column])
        counts = [axis.cells + 1 for axis in self.axes][1:]
        strides = self.error.size * np.cumprod([1, *counts[::-1]])[::-1]
        if not self.axes:
            strides = strides[:0]
        both = np.concatenate([np.zeros(max(idle, 0)), strides]).astype(np.int64)
        return np.array(rows, dtype=np.float64), both

    def _refuse(self, values: Array, bounds: Array) -> None:
        """Say which value lies outside the box."""
        wrong = ~((values >= bounds[0]) & (values <= bounds[1]))
        i, k = (int(n) for n in np.argwhere(wrong)[0])
        raise ArgumentError(
            f"values must lie in the table's box: parameter {k} from {self.low[k]:g} "
            f"to {self.high[k]:g}; row {i} has {values[i, k]:g}"
        )


def reflectance_table(
    model: SkinModel,
    low: ArrayLike,
    high: ArrayLike,
    wavelengths: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    tolerance: ArrayLike,
    most: int = 2**18,
    dtype: DTypeLike = np.float64,
) -> ReflectanceTable:
    """Return a table of ``model.diffuse``, or of sums of it, over a box.

    Nodes lie finer where a parameter bends the light more, as few as the tolerance
    lets be. The error falls with the fourth power of their number along each axis.

    Parameters
    ----------
    model : SkinModel
        Whose light is wanted.
    low, high : (p,) array_like
        The box of its parameters; one whose bounds are equal takes no axis.
    wavelengths : (J,) array_like
        Where the model is evaluated, in any order, also repeatedly. [nm]
    weights : (J, c) array_like, optional
        The channels are ``model.diffuse(values, wavelengths) @ weights``; without
        them they are the J reflectances.
    tolerance : float or (c,) array_like
        Largest absolute error of each channel, > 0.
    most : int
        Bound on the nodes. If it does not suffice for the tolerance, ``error`` of
        the table says how far it got.
    dtype : {float64, float32}
        Of the entries and of what is looked up.

    Returns
    -------
    table : ReflectanceTable
        See there.

    Raises
    ------
    ArgumentError
        If the box lies outside the model's bounds or a corner is not below the
        other, an argument is not as described, or ``most`` is too few for a cubic.

    Notes
    -----
    At 1.5e-4 of white over usual skin a straight line needs 44 × 31 × 31 nodes, a
    quadratic spline 13 × 10 × 11, this cubic 9 × 9 × 9. Over an endless dermis light
    falls as a root where blood begins, which no cubic follows: nodes run out sooner.
    """
    box = _box(model, low, high)
    channels, width = _channels(model, wavelengths, weights)
    wanted = _tolerances(tolerance, width)
    kind = np.dtype(dtype)
    if kind not in (np.float32, np.float64):
        raise ArgumentError(f"dtype must be float64 or float32; got {kind}")
    active = np.flatnonzero(box[1] - box[0] > _LEAST_SPAN)
    if most < TAPS**active.size:
        raise ArgumentError(
            f"most must be at least {TAPS**active.size} nodes, {TAPS} for each "
            f"parameter that varies; got {most}"
        )
    share = wanted / max(active.size, 1)
    axes = fitting_axes(active.tolist(), channels, *box, share)
    return _refined(axes, channels, box, wanted, most, kind)


def _refined(
    axes: tuple[Axis, ...],
    channels: Callable[[Array], Array],
    box: tuple[Array, Array],
    tolerance: Array,
    most: int,
    dtype: np.dtype[Any],
) -> ReflectanceTable:
    """Return the first table, ever finer, that keeps the tolerance, or the best."""
    best: ReflectanceTable | None = None
    cells = tuple(axis.cells for axis in axes)
    for _ in range(_ROUNDS):
        kept = at_most(cells, most)
        axes = tuple(replace(a, cells=n) for a, n in zip(axes, kept, strict=True))
        table = _filled(axes, channels, box, dtype)
        finer = refinement(table.error, tolerance)
        if best is None or finer < refinement(best.error, tolerance):
            best = table
        if finer <= 1 or kept != cells or not axes:
            break
        cells = grown(axes, finer)
    return best  # type: ignore[return-value]  # there is at least one round


def _filled(
    axes: tuple[Axis, ...],
    channels: Callable[[Array], Array],
    box: tuple[Array, Array],
    dtype: np.dtype[Any],
) -> ReflectanceTable:
    """Return a table on given axes, with its error."""
    values = np.tile(box[0], (*(axis.cells + 1 for axis in axes), 1))
    for k, axis in enumerate(axes):
        along = [1] * len(axes)
        along[k] = -1
        values[..., axis.column] = axis.nodes.reshape(along)
    nodes, places = values.reshape(-1, box[0].size), _between(axes, box[0])
    # Both in one call: each takes a while to begin.
    exact, expected = np.split(channels(np.concatenate([nodes, places])), [len(nodes)])
    largest = np.abs(exact).max(axis=0)
    if not (largest <= np.finfo(dtype).max / SAFETY).all():
        raise ArgumentError(f"the channels overflow {dtype}; scale the weights down")
    entries = exact.astype(dtype).reshape(*values.shape[:-1], -1)
    table = ReflectanceTable(*box, axes, entries, np.zeros(largest.size))
    apart = np.abs(table.at(places) - expected).max(axis=0)
    rounding = 8 * np.finfo(dtype).eps * largest
    return replace(table, error=SAFETY * apart + rounding)


def _between(axes: tuple[Axis, ...], low: Array) -> Array:
    """Return places (n, p) between nodes: in the box's corners, at random in cells.

    Half of the random ones are centres of cells, half of edges and faces; on each axis
    every second is in the first cell, where light falls fastest.
    """
    rng = np.random.default_rng(0)
    n = (_CHECKS + math.prod(axis.cells for axis in axes) // _SHARE) if axes else 0
    corners = np.indices((4,) * len(axes)).reshape(len(axes), 4 ** len(axes))
    values = np.tile(low, (n + corners.shape[1], 1))
    for axis, corner in zip(axes, corners, strict=True):
        inside = rng.integers(0, 2, n) / 2
        inside[: n // 2] = 0.5
        first = rng.integers(0, 2, n) == 0
        steps = np.where(first, inside, rng.integers(0, axis.cells, n) + inside)
        ends = np.array([0, _END_CELL, axis.cells - _END_CELL, axis.cells])
        values[:, axis.column] = axis.places(np.concatenate([steps, ends[corner]]))
    return values


def _box(model: SkinModel, low: ArrayLike, high: ArrayLike) -> tuple[Array, Array]:
    """Return both corners of the box, within the model's bounds."""
    corners = np.array(model.checked(low)), np.array(model.checked(high))
    if corners[0].ndim != 1 or corners[1].ndim != 1:
        raise ArgumentError("low and high must be one set of parameters each")
    if (corners[0] > corners[1]).any():
        k = int(np.argmax(corners[0] > corners[1]))
        raise ArgumentError(
            f"low must not be above high; {model.parameters[k].name} is from "
            f"{corners[0][k]:g} to {corners[1][k]:g}"
        )
    return corners


def _channels(
    model: SkinModel, wavelengths: ArrayLike, weights: ArrayLike | None
) -> tuple[Callable[[Array], Array], int]:
    """Return the function from parameters (m, p) to channels (m, c), and c."""
    given = as_numbers(wavelengths, "wavelengths")
    if given.ndim != 1 or given.size == 0:
        raise ArgumentError(
            f"wavelengths must be a 1-D array of at least one value; got shape "
            f"{given.shape}"
        )
    bands, place = np.unique(given, return_inverse=True)
    factors = np.eye(given.size)
    if weights is not None:
        factors = as_numbers(weights, "weights")
        if factors.ndim != 2 or factors.shape[0] != given.size or not factors.size:
            raise ArgumentError(
                f"weights must be ({given.size}, channels), a wavelength a row; got "
                f"shape {factors.shape}"
            )
        factors = as_spectra(factors.T, given.size, "weights").T
    gathered = np.zeros((bands.size, factors.shape[1]))
    np.add.at(gathered, place, factors)

    def channels(values: Array) -> Array:
        return np.asarray(model.diffuse(values, bands) @ gathered)

    return channels, factors.shape[1]


def _tolerances(tolerance: ArrayLike, width: int) -> Array:
    """Return a tolerance a channel (c,)."""
    given = as_numbers(tolerance, "tolerance")
    if given.ndim > 1 or (given.ndim == 1 and given.size != width):
        raise ArgumentError(
            f"tolerance must be one number or {width}, one a channel; got shape "
            f"{given.shape}"
        )
    if not ((given > 0) & np.isfinite(given)).all():
        raise ArgumentError(f"tolerance must be > 0 and finite; got {given}")
    return np.broadcast_to(given, (width,))
