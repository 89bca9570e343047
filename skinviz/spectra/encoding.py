"""Levels of a display from light: the tables of a display, and the counts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.spectra.curves import Curve

Array = NDArray[np.float64]

_BINS = {255: 2**10, 65535: 2**18}
_JUDGED_AT = 255  # levels: what is beyond the ends must not depend on the file
_ROUNDING = 1e-6  # light by which arithmetic alone may miss 0 or full


@dataclass(frozen=True)
class DisplayCounts:
    """How many colours a display could not show; counts of parts can be added.

    Attributes
    ----------
    total : int
        Colours looked at.
    over_exposed : int
        Those with a channel that rounds to more than full, in 8 bits.
    out_of_gamut : int
        Those with a channel that rounds to less than none.
    """

    total: int = 0
    over_exposed: int = 0
    out_of_gamut: int = 0

    def __add__(self, other: DisplayCounts) -> DisplayCounts:
        """Return the counts of both."""
        return DisplayCounts(
            self.total + other.total,
            self.over_exposed + other.over_exposed,
            self.out_of_gamut + other.out_of_gamut,
        )


@dataclass(frozen=True, eq=False)
class Encoder:
    """What the compiled loop needs to know of a display, as it says itself."""

    first: NDArray[Any]
    steps: Array
    scale: float
    top: float
    deepest: int
    limits: Array

    def levels(
        self, linear: NDArray[Any], counted: NDArray[np.bool_] | None
    ) -> tuple[NDArray[Any], DisplayCounts]:
        """Return the levels (..., 3) of linear colours, and what did not fit."""
        from skinviz.spectra.kernels import encode

        colours = _as_colours(linear)
        chosen = _as_mask(counted, colours.shape[:-1])
        # Writeable, or the loop would be compiled once more.
        flat = np.require(colours.reshape(-1, 3), requirements=["C", "W"])
        levels = np.zeros(flat.shape, dtype=self.first.dtype)
        over, under, undefined = encode(
            flat,
            self.first,
            self.steps,
            self.scale,
            self.top,
            self.deepest,
            self.limits,
            chosen,
            levels,
        )
        if undefined:
            index = np.argwhere(np.isnan(colours).any(axis=-1))[0].tolist()
            raise ArgumentError(
                f"linear colours must not be NaN; {undefined} are, the first at "
                f"{index}; look for NaN in spectra or geometry"
            )
        total = int(chosen.sum()) if counted is not None else len(flat)
        return levels.reshape(colours.shape), DisplayCounts(total, over, under)


def encoder(curves: Sequence[Curve], levels: int) -> Encoder:
    """Return the tables by which light becomes one of 0 ... levels."""
    own = curves[:1] if all(curve == curves[0] for curve in curves) else curves
    steps = np.array([_steps(curve, levels) for curve in own])
    top = float(steps[:, -1].max())
    scale = _BINS[levels] / math.sqrt(top)
    # The same arithmetic as in the loop, so that a step and a value never disagree.
    at = (np.sqrt(np.maximum(steps, 0.0)) * scale).astype(np.int64)
    bins = np.arange(at.max() + 1)
    return Encoder(
        first=np.array([np.searchsorted(row, bins) for row in at]).astype(
            np.min_scalar_type(levels)
        ),
        steps=np.pad(steps, ((0, 0), (0, 1)), constant_values=np.nan),
        scale=scale,
        top=top,
        deepest=max(int(np.bincount(row).max()) for row in at),
        limits=np.array([_limits(curve) for curve in curves]).T.copy(),
    )


def _steps(curve: Curve, levels: int) -> Array:
    """Return a curve's steps; black is level 0 also where more is as dark."""
    black = float(curve.decode(np.zeros(1))[0])
    least = max(float(np.spacing(abs(black))), float(np.finfo(np.float64).tiny))
    return np.maximum(curve.steps(levels), black + least)


def _limits(curve: Curve) -> tuple[float, float]:
    """Return the light that rounds to more than full, and to less than none.

    The curve is continued beyond its ends as it comes to them.
    """
    half = 0.5 / _JUDGED_AT
    none, low, high, full = curve.decode(np.array([0.0, half, 1 - half, 1.0]))
    return full + max(full - high, _ROUNDING), none - max(low - none, _ROUNDING)


def _as_colours(linear: NDArray[Any]) -> NDArray[Any]:
    """Return colours (..., 3) as float32 or float64."""
    colours = np.asarray(linear)
    if colours.ndim == 0 or colours.shape[-1] != 3 or colours.dtype.kind not in "fiu":
        raise ArgumentError(
            "linear colours must be real numbers (..., 3); got "
            f"{colours.dtype} {colours.shape}"
        )
    kept = np.float32 if colours.dtype == np.float32 else np.float64
    return colours.astype(kept, copy=False)


def _as_mask(
    counted: NDArray[np.bool_] | None, shape: tuple[int, ...]
) -> NDArray[np.bool_]:
    """Return which colours are counted as (n,), or (0,) for all."""
    if counted is None:
        return np.zeros(0, dtype=bool)
    chosen = np.asarray(counted)
    if chosen.dtype != np.bool_ or chosen.shape != shape:
        raise ArgumentError(
            f"counted must be bool {shape}; got {chosen.dtype} {chosen.shape}"
        )
    return np.ascontiguousarray(chosen.reshape(-1))
