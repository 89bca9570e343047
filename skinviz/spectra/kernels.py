"""Light to the levels of a display, compiled.

A level is the number of steps that a value reaches. The square root of the value
names a bin, of which it is known how many steps lie below it; as a rule at most one
lies in it, so that one comparison is left.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from skinviz._compile import compiled, inlined

_ROWS = 128  # colours treated at once, whose bins stay in the nearest memory


@compiled()
def encode(
    linear: Any,
    first: Any,
    steps: Any,
    scale: float,
    top: float,
    deepest: int,
    limits: Any,
    counted: Any,
    levels: Any,
) -> tuple[int, int, int]:
    """Write the levels (n, 3) of colours; return how many exceed limits or are NaN.

    ``first`` (c, bins) is the level at the beginning of each bin, ``steps``
    (c, levels + 1) the steps and a NaN behind them, c = 1 or 3; ``top`` the highest
    step, ``deepest`` how many steps lie in one bin at most; ``limits`` (2, 3) what is
    too much and too little; ``counted`` (n,) or (0,) which colours are counted.
    """
    bins = np.zeros(3 * _ROWS, np.uint32)
    own = 1 if first.shape[0] > 1 else 0
    over, under, undefined = 0, 0, 0
    for begin in range(0, linear.shape[0], _ROWS):
        end = min(begin + _ROWS, linear.shape[0])
        values = linear[begin:end].reshape(3 * (end - begin))
        shown = levels[begin:end].reshape(3 * (end - begin))
        outside = _find_bins(values, scale, top, limits, bins)
        for channel in range(3):
            _look_up(
                values, bins, first[own * channel], steps[own * channel], channel, shown
            )
            if deepest > 1:
                _climb(values, steps[own * channel], channel, shown)
        if outside:
            seen = counted[begin:end]
            more, less, nan = _count(values, limits, seen)
            over, under, undefined = over + more, under + less, undefined + nan
    return over, under, undefined


@inlined
def _find_bins(values: Any, scale: float, top: float, limits: Any, bins: Any) -> Any:
    """Write the bin of each value; return how many values are NaN or may not fit."""
    none, full = limits[1].max(), limits[0].min()
    outside = 0
    for j in range(values.size):
        value: Any = np.float64(values[j])
        outside += not ((value <= full) & (value >= none))
        value = value if value > 0.0 else 0.0
        value = value if value < top else top
        bins[j] = np.uint32(np.int32(math.sqrt(value) * scale))
    return outside


@inlined
def _look_up(
    values: Any, bins: Any, first: Any, steps: Any, channel: int, shown: Any
) -> None:
    """Write one channel's levels, by one comparison each."""
    # Indices without a sign need not be looked at for being negative.
    own: Any = np.uint64(channel)
    for j in range(own, np.uint64(values.size), np.uint64(3)):
        level = np.uint32(first[bins[j]])
        shown[j] = level + (values[j] >= steps[level])


@inlined
def _climb(values: Any, steps: Any, channel: int, shown: Any) -> None:
    """Go on with the comparisons, where more steps than one lie in a bin."""
    for j in range(channel, values.size, 3):
        level = shown[j]
        while values[j] >= steps[level]:
            level += 1
        shown[j] = level


@inlined
def _count(values: Any, limits: Any, seen: Any) -> tuple[int, int, int]:
    """Return how many colours have a channel above, below and NaN."""
    over, under, undefined = 0, 0, 0
    for i in range(values.size // 3):
        r, g, b = values[3 * i], values[3 * i + 1], values[3 * i + 2]
        undefined += math.isnan(r) | math.isnan(g) | math.isnan(b)
        if seen.size == 0 or seen[i]:
            over += (r > limits[0, 0]) | (g > limits[0, 1]) | (b > limits[0, 2])
            under += (r < limits[1, 0]) | (g < limits[1, 1]) | (b < limits[1, 2])
    return over, under, undefined
