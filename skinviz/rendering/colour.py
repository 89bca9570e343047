"""From XYZ to what a display shows, with what it cannot show counted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.spectra.colorimetry import (
    decode_srgb,
    encode_srgb,
    xyz_to_linear_srgb,
)

# Half an 8-bit step beyond the ends: what rounds to them is shown as it is.
_ABOVE = float(decode_srgb(1 + 0.5 / 255))
_BELOW = float(decode_srgb(-0.5 / 255))


@dataclass(frozen=True)
class DisplayCounts:
    """How many colours a display could not show.

    Attributes
    ----------
    total : int
        Colours looked at.
    over_exposed : int
        Those with a channel that rounds to more than full.
    out_of_gamut : int
        Those with a channel that rounds to less than none.
    """

    total: int
    over_exposed: int
    out_of_gamut: int


def to_srgb8(
    xyz: NDArray[np.float64], behind: NDArray[np.float64] | float = 0.0
) -> tuple[NDArray[np.uint8], DisplayCounts]:
    """Return 8-bit sRGB of XYZ (..., 3) with Y = 1 for white, and the counts.

    ``behind`` is linear light of what is not the mesh, added but not counted.
    Channels below 0 or above 1 are cut off, as a display does, and counted.
    """
    linear = xyz_to_linear_srgb(xyz)
    counts = DisplayCounts(
        total=int(linear[..., 0].size),
        over_exposed=int((linear > _ABOVE).any(axis=-1).sum()),
        out_of_gamut=int((linear < _BELOW).any(axis=-1).sum()),
    )
    return np.round(255 * encode_srgb(linear + behind)).astype(np.uint8), counts
