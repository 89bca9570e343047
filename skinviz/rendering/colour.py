"""From XYZ to what a display shows, with what it cannot show counted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.spectra.display import SRGB, DisplayCounts

__all__ = ["DisplayCounts", "to_srgb8"]


def to_srgb8(xyz: NDArray[np.float64]) -> tuple[NDArray[np.uint8], DisplayCounts]:
    """Return 8-bit sRGB of XYZ (..., 3) with Y = 1 for white, and the counts.

    Channels below 0 or above 1 are cut off, as a display does, and counted.
    """
    return SRGB.encode8(SRGB.linear(xyz))
