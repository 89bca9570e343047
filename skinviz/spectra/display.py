"""Displays: which values of red, green and blue show a colour.

A display is three primaries and a curve for each channel. What does not belong here:
the adaptation of white, which is a matrix before the display's own
(:mod:`skinviz.spectra.adaptation`).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._files import existing_file
from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.colorimetry import SRGB_FROM_XYZ
from skinviz.spectra.curves import Curve, PowerCurve, SrgbCurve, measured_curve
from skinviz.spectra.encoding import DisplayCounts, Encoder, encoder
from skinviz.spectra.icc import LARGEST_PROFILE, parse_profile

__all__ = [
    "SRGB",
    "Display",
    "DisplayCounts",
    "measured_display",
    "read_icc",
]

Array = NDArray[np.float64]

_MOST_ALIKE = 1e-4  # volume that three primaries of length 1 must span


@dataclass(frozen=True, eq=False)
class Display:
    """What light a display makes of encoded values.

    Attributes
    ----------
    name : str
        As messages and files have it.
    matrix : (3, 3) ndarray
        Takes XYZ, Y = 1 for the display's white, to linear red, green and blue.
    curves : tuple of 3 Curve
        Of red, green and blue.
    icc : bytes or None
        The ICC profile that describes it, to be put into pictures.

    Raises
    ------
    ArgumentError
        If the matrix is not (3, 3), finite and invertible, or there are not three
        curves.
    """

    name: str
    matrix: Array
    curves: tuple[Curve, Curve, Curve]
    icc: bytes | None = None

    def __post_init__(self) -> None:
        """Keep a copy of the matrix that nobody can change."""
        matrix = as_numbers(self.matrix, "a display's matrix").copy()
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
            raise ArgumentError("a display's matrix must be (3, 3) and finite")
        _require_independent(matrix)
        matrix.setflags(write=False)
        if len(self.curves) != 3:
            raise ArgumentError(f"a display has 3 curves; got {len(self.curves)}")
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "curves", tuple(self.curves))

    @cached_property
    def white(self) -> Array:
        """XYZ (3,) of full red, green and blue together."""
        return np.asarray(np.linalg.inv(self.matrix) @ np.ones(3))

    def linear(self, xyz: ArrayLike) -> Array:
        """Return linear colours (..., 3) of XYZ (..., 3), Y = 1 for white; not cut."""
        values = as_numbers(xyz, "XYZ")
        _require_three(values)
        return np.asarray(values @ self.matrix.T)

    def encode(self, linear: ArrayLike) -> Array:
        """Return the encoded values (..., 3) in [0, 1] of linear colours (..., 3)."""
        values = as_numbers(linear, "linear colours")
        return _by_channel([curve.encode for curve in self.curves], values)

    def decode(self, encoded: ArrayLike) -> Array:
        """Return the linear colours (..., 3) of encoded values (..., 3) in [0, 1]."""
        values = as_numbers(encoded, "encoded colours")
        return _by_channel([curve.decode for curve in self.curves], values)

    def encode8(
        self, linear: NDArray[Any], counted: NDArray[np.bool_] | None = None
    ) -> tuple[NDArray[np.uint8], DisplayCounts]:
        """Return 8-bit values of linear colours, and what could not be shown.

        Parameters
        ----------
        linear : (..., 3) ndarray of float32 or float64
            1 for full. What is less than 0 or more is cut off, as a display does.
        counted : (...) ndarray of bool, optional
            The colours that are looked at for the counts; all by default.

        Returns
        -------
        levels : (..., 3) ndarray of uint8
            The curve's values rounded, halves upwards; for sRGB to the last digit.
        counts : DisplayCounts
            A channel that rounds to more than 255 is over-exposed, one that rounds to
            less than 0 out of gamut.

        Raises
        ------
        ArgumentError
            If a colour is NaN, or the shape another. Infinity is over-exposed.
        """
        return self._encoder8.levels(linear, counted)

    def encode16(
        self, linear: NDArray[Any], counted: NDArray[np.bool_] | None = None
    ) -> tuple[NDArray[np.uint16], DisplayCounts]:
        """Return 16-bit values of linear colours, and what could not be shown.

        As :meth:`encode8`, whose counts these are too: what a picture cannot show
        does not depend on the file that it is written to.
        """
        return self._encoder16.levels(linear, counted)

    def profile(self) -> bytes | None:
        """Return the ICC profile to put into pictures, sRGB's own for sRGB."""
        ours = all(isinstance(curve, SrgbCurve) for curve in self.curves)
        if self.icc is None and ours and np.array_equal(self.matrix, SRGB_FROM_XYZ):
            return _srgb_profile()
        return self.icc

    @cached_property
    def _encoder8(self) -> Encoder:
        """The tables for 8 bits."""
        return encoder(self.curves, 255)

    @cached_property
    def _encoder16(self) -> Encoder:
        """The tables for 16 bits."""
        return encoder(self.curves, 65535)


def measured_display(
    primaries: ArrayLike,
    curves: Any = 2.2,
    *,
    black: ArrayLike | None = None,
    name: str = "measured display",
) -> Display:
    """Return a display from measurements of its primaries and its curves.

    Parameters
    ----------
    primaries : (3, 3) array_like
        XYZ of full red, of full green and of full blue, each alone, in any unit.
    curves : float, "sRGB", (n, 2) array_like or Curve, or three of these
        For all channels, or for red, green and blue. A number is a gamma. A table
        has points (input, output): input from 0 to the largest (255 or 1), output a
        luminance in any unit, of which the first is the black's and counts as none.
    black : (3,) array_like, optional
        XYZ of the display at black, in the primaries' unit, which is in each of them
        too and is taken off. Colours are not corrected for it: they are shown on top
        of it.
    name : str
        As messages and files have it.

    Returns
    -------
    display : Display
        Its white, Y = 1, is all primaries together.

    Raises
    ------
    ArgumentError
        If a primary is negative, they do not span colours, or a curve falls.
    """
    xyz = as_numbers(primaries, "primaries")
    if xyz.shape != (3, 3) or not np.isfinite(xyz).all():
        raise ArgumentError(
            "primaries must be the XYZ of red, green and blue, (3, 3) and finite; got "
            f"shape {xyz.shape}"
        )
    dark = np.zeros(3) if black is None else as_numbers(black, "black")
    if dark.shape != (3,) or not np.isfinite(dark).all():
        raise ArgumentError(f"black must be one XYZ (3,), finite; got {dark.shape}")
    light = xyz - dark
    if min(xyz.min(), dark.min(), light.min()) < 0:
        raise ArgumentError("primaries and black must be ≥ 0, and black the darkest")
    if light[:, 1].sum() <= 0:
        raise ArgumentError("primaries have no luminance; the second of each is Y")
    matrix = light.T / light[:, 1].sum()
    _require_independent(matrix)
    return Display(name, np.linalg.inv(matrix), _three_curves(curves))


def read_icc(path: str | os.PathLike[str]) -> Display:
    """Read a display from an ICC profile with primaries and curves.

    Parameters
    ----------
    path : str or path-like
        An ``.icc`` or ``.icm`` file. Of a profile that has look-up tables besides,
        the primaries and curves are used.

    Returns
    -------
    display : Display
        With the XYZ that the display really shows, Y = 1 for its white: what the
        profile did to take the white to D50 (its ``chad``) is undone.

    Raises
    ------
    DataError
        If the file is missing, broken, not of an RGB display, or has look-up tables
        alone.
    """
    file = existing_file(path, DataError)
    if file.stat().st_size > LARGEST_PROFILE:
        raise DataError(
            f"{file}: an ICC profile has at most {LARGEST_PROFILE // 2**20} MiB"
        )
    try:
        content = file.read_bytes()
    except OSError as error:
        raise DataError(f"{file}: cannot be read: {error.strerror}") from error
    parsed = parse_profile(content, str(file))
    try:
        _require_independent(parsed.primaries)
        matrix = np.asarray(np.linalg.inv(parsed.primaries))
        return Display(parsed.name or file.stem, matrix, parsed.curves, content)
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error


def _require_independent(matrix: Array) -> None:
    """Refuse primaries of which one is (almost) a mixture of the others."""
    lengths = np.linalg.norm(matrix, axis=0)
    if not (lengths > 0).all() or abs(np.linalg.det(matrix / lengths)) < _MOST_ALIKE:
        raise ArgumentError(
            "a display's primaries must be three different colours; one is (almost) a "
            "mixture of the others"
        )


def _three_curves(given: Any) -> tuple[Curve, Curve, Curve]:
    """Return the curves of red, green and blue from what stands for them."""
    if _depth(given) == 0 or 1 in map(_depth, given):
        red = _curve(given)
        return red, red, red
    if len(given) == 3:
        red, green, blue = (_curve(one) for one in given)
        return red, green, blue
    raise ArgumentError(
        "curves must be a gamma, 'sRGB' or a table (n, 2), or three of these; got "
        f"{str(given)[:60]}"
    )


def _depth(given: Any) -> int:
    """Return how deep lists are nested: 0 a gamma or name, 1 a point, 2 a table."""
    if isinstance(given, list | tuple) or (
        isinstance(given, np.ndarray) and given.ndim
    ):
        return 1 + max(map(_depth, given), default=0)
    return 0


def _curve(given: Any) -> Curve:
    """Return one channel's curve."""
    if hasattr(given, "steps"):
        return given  # type: ignore[no-any-return]
    if isinstance(given, str):
        if given.casefold() == "srgb":
            return SrgbCurve()
        raise ArgumentError(f"unknown curve {given!r}; expected a gamma or 'sRGB'")
    return PowerCurve(given) if _depth(given) == 0 else measured_curve(given)


def _by_channel(laws: Sequence[Callable[[Array], Array]], values: Array) -> Array:
    """Return each channel's law of its own values, on the last axis (3)."""
    _require_three(values)
    return np.stack([law(values[..., i]) for i, law in enumerate(laws)], axis=-1)


def _require_three(values: Array) -> None:
    """Refuse what has not three numbers on its last axis."""
    if values.ndim == 0 or values.shape[-1] != 3:
        raise ArgumentError(f"colours must be (..., 3); got shape {values.shape}")


@cache
def _srgb_profile() -> bytes:
    """Return sRGB's ICC profile, without the date on which it was made."""
    from PIL import ImageCms

    made = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    epoch = bytes.fromhex("07d0 0001 0001 0000 0000 0000")
    return made[:24] + epoch + made[36:]


SRGB = Display("sRGB", SRGB_FROM_XYZ, (SrgbCurve(), SrgbCurve(), SrgbCurve()))
"""IEC 61966-2-1, with its four-digit matrix and its curve of two pieces."""
