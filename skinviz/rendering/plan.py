"""How a picture is computed: the choices that trade speed for accuracy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

_GRID = 4
# Cells of the 4 × 4 grid, column and row. The first 2, 4, 8 and 16 are centred, and
# from 4 on there are as many in every row and column. Of the eight that go on from
# these four, these follow edges best.
_CELLS = (
    *((1, 1), (2, 2)),
    *((0, 3), (3, 0)),
    *((0, 1), (3, 2), (1, 0), (2, 3)),
    *((1, 3), (3, 1), (0, 2), (2, 0), (0, 0), (3, 3), (1, 2), (2, 1)),
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
        """Refuse other numbers of samples, and what is no number of rays."""
        samples = in_range(self.samples, SAMPLES[0], SAMPLES[-1], "samples")
        if samples not in SAMPLES:
            raise ArgumentError(
                f"samples must be one of {', '.join(map(str, SAMPLES))}; got "
                f"{self.samples!r}"
            )
        rays = in_range(self.bounce_rays, 16, 65536, "bounce_rays")
        if rays != int(rays):
            raise ArgumentError(
                f"bounce_rays must be a whole number; got {self.bounce_rays!r}"
            )
        if not isinstance(self.shadows, bool | np.bool):
            raise ArgumentError(f"shadows must be True or False; got {self.shadows!r}")
        # As Python's own, which go into files.
        object.__setattr__(self, "samples", int(samples))
        object.__setattr__(self, "bounce_rays", int(rays))
        object.__setattr__(self, "shadows", bool(self.shadows))

    @property
    def cells(self) -> Array:
        """Where in a pixel its samples are (samples, 2), from its top left. [pixels]"""
        return (np.array(_CELLS[: self.samples]) + 0.5) / _GRID
