"""How a picture is computed: the choices that trade speed for accuracy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

_GRID = 4
# Cells of the 4 × 4 grid, column and row, so that the first 1, 2, 4, 8 and 16 are
# spread over the pixel: the diagonal's middle, a rotated square, a chequerboard.
_CELLS = (
    *((1, 1), (2, 2)),
    *((0, 3), (3, 0)),
    *((1, 3), (3, 1), (0, 2), (2, 0)),
    *((0, 1), (1, 0), (2, 3), (3, 2), (0, 0), (3, 3), (1, 2), (2, 1)),
)
SAMPLES = (1, 2, 4, 8, 16)
"""Samples that a pixel may have."""


@dataclass(frozen=True)
class Plan:
    """What is computed for a picture, and how finely.

    Attributes
    ----------
    samples : {16, 8, 4, 2, 1}
        Rays a pixel: places of one fixed 4 × 4 grid, or a subset of them.
    shadows : bool
        Whether lights are tested for what stands between.
    bounce_rays : int
        Directions in which a vertex looks for light from other parts, where the
        scene declares interreflection. 16 to 65,536
    """

    samples: int = 16
    shadows: bool = True
    bounce_rays: int = 256

    def __post_init__(self) -> None:
        """Refuse other numbers of samples."""
        if self.samples not in SAMPLES or isinstance(self.samples, bool):
            raise ArgumentError(
                f"samples must be one of {', '.join(map(str, SAMPLES))}; got "
                f"{self.samples!r}"
            )
        in_range(self.bounce_rays, 16, 65536, "bounce_rays")

    @property
    def cells(self) -> Array:
        """Where in a pixel its samples are (samples, 2), from its top left. [pixels]"""
        return (np.array(_CELLS[: self.samples]) + 0.5) / _GRID
