"""What the writers of pictures are given: colour, spectra, and how they were made."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError

Advance = Callable[[int], object]
"""Told how many more rows are done."""


class SpectralPicture(Protocol):
    """A picture with a spectrum at every pixel, row 0 at the top.

    ``size`` is (width, height). Where colours or spectra take long or much memory,
    they may be computed when they are asked for.
    """

    @property
    def size(self) -> tuple[int, int]:
        """Width and height. [pixels]"""

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """Colour as the display of ``icc`` shows it, (height, width, 3)."""

    @property
    def rgb16(self) -> NDArray[np.uint16]:
        """The same in 16 bits."""

    @property
    def xyz(self) -> NDArray[np.float32]:
        """Tristimulus values, Y = 1 for display white, (height, width, 3)."""

    @property
    def wavelengths(self) -> NDArray[np.float64]:
        """Those of the bands, ascending. [nm]"""

    @property
    def icc(self) -> bytes | None:
        """The ICC profile that ``rgb`` is meant for; None for sRGB."""

    @property
    def metadata(self) -> dict[str, Any]:
        """How the picture was made, in what JSON can hold.

        ``title`` and the radiance of ``units``, if there, are put where formats have
        a place for them; all of it goes into one text.
        """

    def rows(self, advance: Advance | None = None) -> Iterator[NDArray[np.float32]]:
        """Yield radiance from the top, (some rows, width, bands)."""


def radiance_rows(
    picture: SpectralPicture, file: Path, advance: Advance | None
) -> Iterator[NDArray[np.float32]]:
    """Yield a picture's radiance, found whole and finite.

    Raises
    ------
    ArgumentError
        If a value is not finite, or the rows are not those of the picture's size.
    """
    width, height = picture.size
    expected = (width, len(picture.wavelengths))
    done = 0
    for block in picture.rows(advance):
        if block.dtype != np.float32 or block.shape[1:] != expected:
            raise ArgumentError(
                f"{file}: rows of radiance are {block.dtype} of shape {block.shape}; "
                f"expected float32 (rows, {width}, {expected[1]})"
            )
        # Not isfinite of all: the extremes need no memory, and NaN is both of them.
        if not np.isfinite([block.min(initial=0), block.max(initial=0)]).all():
            raise ArgumentError(
                f"{file}: the radiance is not finite in rows {done} to "
                f"{done + len(block) - 1}"
            )
        done += len(block)
        if done > height:
            break
        yield block
    if done != height:
        raise ArgumentError(f"{file}: {done} rows of radiance came for {height}")
