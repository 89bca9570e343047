"""A display's response: encoded value to light, for one channel, and back.

Encoded values run from 0 to 1, whatever number of bits writes them; light is 1 at full.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, in_range
from skinviz.errors import ArgumentError
from skinviz.spectra.colorimetry import decode_srgb, encode_srgb

Array = NDArray[np.float64]

_LOWEST, _HIGHEST = 0.1, 10.0  # exponents of displays, with room on both sides
_DIP = 1e-3  # by which a curve's two pieces may miss each other where they meet
_EXACT_TO = 255  # levels whose steps are exact; more would take a second


class Curve(Protocol):
    """One channel's response, never falling."""

    def decode(self, encoded: Array) -> Array:
        """Return the light of encoded values in [0, 1]."""

    def encode(self, linear: Array) -> Array:
        """Return the encoded values, in [0, 1], that show light best."""

    def steps(self, levels: int) -> Array:
        """Return the least light (levels,) that rounds to the level 1, 2, ..."""


class _Steps:
    """Steps by the curve itself, to its own rounding."""

    def steps(self: Curve, levels: int) -> Array:
        """Return the light half-way between the levels."""
        return np.maximum.accumulate(self.decode(_half_levels(levels)))


@dataclass(frozen=True)
class SrgbCurve:
    """The two pieces of IEC 61966-2-1."""

    def decode(self, encoded: Array) -> Array:
        """Return the light of encoded values."""
        return decode_srgb(encoded)

    def encode(self, linear: Array) -> Array:
        """Return the encoded values of light cut off at 0 and 1."""
        return encode_srgb(linear)

    def steps(self, levels: int) -> Array:
        """Return the least light of each level: to the last digit for 8 bits."""
        if levels > _EXACT_TO:
            return decode_srgb(_half_levels(levels))
        return np.array([_srgb_step(k, levels) for k in range(1, levels + 1)])


def _srgb_step(level: int, levels: int) -> float:
    """Return the smallest float that is not below sRGB's light of level − ½."""
    with localcontext(prec=40):
        value = Decimal(2 * level - 1) / (2 * levels)
        if value <= Decimal("0.04045"):
            exact = value / Decimal("12.92")
        else:
            exact = ((value + Decimal("0.055")) / Decimal("1.055")) ** Decimal("2.4")
        step = float(exact)
        return step if Decimal(step) >= exact else float(np.nextafter(step, 1.0))


@dataclass(frozen=True)
class PowerCurve(_Steps):
    """(a x + b)^γ + e from x = d on, c x + f below: a gamma, or ICC's parameters.

    Attributes
    ----------
    gamma : float
        0.1 to 10.
    a, b, c, d, e, f : float
        As in ICC.1:2022, table 68, function type 4.

    Raises
    ------
    ArgumentError
        If γ is outside its range, or the curve falls or is far from 0–1.
    """

    gamma: float
    a: float = 1.0
    b: float = 0.0
    c: float = 0.0
    d: float = 0.0
    e: float = 0.0
    f: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no display does."""
        in_range(self.gamma, _LOWEST, _HIGHEST, "a display's gamma")
        for name in "abcdef":
            in_range(getattr(self, name), -1e6, 1e6, f"a curve's {name}")
        _require_rising(self.decode(np.linspace(0, 1, 4097)), _DIP)

    def decode(self, encoded: Array) -> Array:
        """Return the light of encoded values."""
        x = np.asarray(encoded, dtype=np.float64)
        power = np.maximum(self.a * x + self.b, 0.0) ** self.gamma + self.e
        return np.where(x >= self.d, power, self.c * x + self.f)

    def encode(self, linear: Array) -> Array:
        """Return the encoded values; black is 0 also where more is as dark."""
        ends = self.decode(np.array([0.0, min(max(self.d, 0.0), 1.0), 1.0]))
        y = np.clip(np.asarray(linear, dtype=np.float64), ends[0], ends[2])
        root = np.maximum(y - self.e, 0.0) ** (1 / self.gamma)
        power = (root - self.b) / (self.a or 1.0)
        # Light in a gap between the pieces is nearest to where they meet.
        straight = np.minimum((y - self.f) / self.c, self.d) if self.c else self.d
        shown = np.clip(np.where(y >= ends[1], power, straight), 0.0, 1.0)
        return np.where(y > ends[0], shown, 0.0)


@dataclass(frozen=True, eq=False)
class TableCurve(_Steps):
    """Measured points, straight between them.

    Attributes
    ----------
    inputs : (n,) ndarray
        Encoded values from 0 to 1, ascending.
    outputs : (n,) ndarray
        Light at them, never falling.

    Raises
    ------
    ArgumentError
        If the points are fewer than two, do not ascend or are far from 0–1.
    """

    inputs: Array
    outputs: Array

    def __post_init__(self) -> None:
        """Keep copies that nobody can change; refuse what no display does."""
        inputs = as_numbers(self.inputs, "a curve's inputs").copy()
        outputs = as_numbers(self.outputs, "a curve's outputs").copy()
        if inputs.ndim != 1 or inputs.shape != outputs.shape or inputs.size < 2:
            raise ArgumentError(
                "a curve needs at least two points (input, output); got "
                f"{inputs.shape} inputs and {outputs.shape} outputs"
            )
        if not np.isfinite(inputs).all() or (np.diff(inputs) <= 0).any():
            raise ArgumentError("a curve's inputs must be finite and ascend")
        if inputs[0] != 0 or inputs[-1] != 1:
            raise ArgumentError(
                f"a curve's inputs must run from 0 to 1; got {inputs[0]:g} to "
                f"{inputs[-1]:g}"
            )
        _require_rising(outputs, 0.0)
        for field, values in (("inputs", inputs), ("outputs", outputs)):
            values.setflags(write=False)
            object.__setattr__(self, field, values)

    def decode(self, encoded: Array) -> Array:
        """Return the light of encoded values."""
        return _between(encoded, self.inputs, self.outputs)

    def encode(self, linear: Array) -> Array:
        """Return the encoded values; black is 0 also where more is as dark."""
        y = np.asarray(linear, dtype=np.float64)
        shown = _between(y, self.outputs, self.inputs)
        return np.where(y > self.outputs[0], shown, 0.0)


def measured_curve(points: ArrayLike) -> TableCurve:
    """Return the curve of measured points, between its darkest and its brightest.

    Parameters
    ----------
    points : (n, 2) array_like
        Input, from 0 to the largest in any unit (0–255, 0–1), and output, such as
        a luminance in any unit. The first output is the black's and counts as none.

    Raises
    ------
    ArgumentError
        If there are fewer than two points, inputs do not ascend from 0, or an output
        falls.
    """
    table = as_numbers(points, "a measured curve")
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
        raise ArgumentError(
            "a measured curve must have at least two rows (input, output); got shape "
            f"{table.shape}"
        )
    if not np.isfinite(table).all():
        raise ArgumentError("a measured curve must be finite")
    (first, dark), (last, bright) = table[0], table[-1]
    if first != 0 or last <= 0:
        raise ArgumentError(
            f"a measured curve's inputs must ascend from 0; they run from {first:g} to "
            f"{last:g}"
        )
    if bright <= dark:
        raise ArgumentError(
            f"a measured curve must rise; it runs from {dark:g} to {bright:g}"
        )
    # Halved first, so that no difference of huge numbers overflows.
    light = (table[:, 1] / 2 - dark / 2) / (bright / 2 - dark / 2)
    return TableCurve(table[:, 0] / last, light)


def _between(x: ArrayLike, old: Array, values: Array) -> Array:
    """Return values at x by straight lines between old ones, which never fall.

    By the share of each line, not its slope, which may overflow.
    """
    inside = np.clip(np.asarray(x, dtype=np.float64), old[0], old[-1])
    right = np.clip(np.searchsorted(old, inside, side="right"), 1, old.size - 1)
    left = right - 1
    length = old[right] - old[left]
    share = (inside - old[left]) / np.where(length > 0, length, 1.0)
    share = np.where(length > 0, share, 1.0)
    return np.asarray(values[left] * (1 - share) + values[right] * share)


def _half_levels(levels: int) -> Array:
    """Return the encoded values half-way between 0 and 1, 1 and 2, ... of levels."""
    return np.asarray((np.arange(1, levels + 1) - 0.5) / levels)


def _require_rising(light: Array, dip: float) -> None:
    """Refuse a curve that falls by more than a dip, or is not about 0–1."""
    if not np.isfinite(light).all():
        raise ArgumentError("a display's curve must be finite")
    fall = np.flatnonzero(np.diff(light) < -dip)
    if fall.size:
        i = int(fall[0])
        raise ArgumentError(
            f"a display's curve must not fall; it goes from {light[i]:g} to "
            f"{light[i + 1]:g} between points {i} and {i + 1}"
        )
    if not (-0.01 <= light[0] <= 0.5 <= light[-1] <= 2.0):
        raise ArgumentError(
            f"a display's curve runs from {light[0]:g} to {light[-1]:g}; expected "
            "about 0 to 1"
        )
