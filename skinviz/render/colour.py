"""From XYZ to what a display shows, with what it cannot show counted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.spectra.colorimetry import encode_srgb, xyz_to_linear_srgb

_ROUNDING = 1e-9  # white itself comes out of the matrix a little off 1


@dataclass(frozen=True)
class DisplayCounts:
    """How many colours a display could not show.

    Attributes
    ----------
    total : int
        Colours looked at.
    over_exposed : int
        Those with a channel above 1.
    out_of_gamut : int
        Those with a channel below 0.
    """

    total: int
    over_exposed: int
    out_of_gamut: int


def to_srgb8(xyz: NDArray[np.float64]) -> tuple[NDArray[np.uint8], DisplayCounts]:
    """Return 8-bit sRGB of XYZ (..., 3) with Y = 1 for white, and the counts.

    Channels below 0 or above 1 are cut off, as a display does, and counted.
    """
    linear = xyz_to_linear_srgb(xyz)
    counts = DisplayCounts(
        total=int(linear[..., 0].size),
        over_exposed=int((linear > 1 + _ROUNDING).any(axis=-1).sum()),
        out_of_gamut=int((linear < -_ROUNDING).any(axis=-1).sum()),
    )
    return np.round(255 * encode_srgb(linear)).astype(np.uint8), counts
