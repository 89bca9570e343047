"""How a picture is computed: the choices that trade speed for accuracy, as data."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range, one_of
from skinviz.errors import ArgumentError
from skinviz.rendering.finding import Finding, told_table

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

MOST_SAMPLES = SAMPLES[-1]

SPECTRA = ("6 nodes", "10 nodes", "16 nodes", "16", "31", "scene", "1 nm")
"""Where colours are summed over wavelengths, from cheap to exact."""

REFLECTANCES = ("vertices", "table", "model")
"""Where the reflectance of mapped skin comes from, from cheap to exact."""

SPECULARS = ("none", "constant", "dispersion")
"""What is kept of the surface's reflection, from cheap to exact."""

PLACES = ("vertices", "points")
"""Where light is computed, from cheap to exact."""

BASES = ("shared", "points")
"""Whether all points share a few spectra, or each has its own."""

ARITHMETICS = ("single", "double")
"""Numbers of tables and of their sums, from cheap to exact."""


@dataclass(frozen=True)
class Plan:
    """What is computed for a picture, and how finely. ``Plan()`` is the reference.

    Attributes
    ----------
    samples : {16, 8, 4, 2, 1}
        Rays a pixel: places of one fixed 4 × 4 grid, or a subset of them.
    shadows : bool
        Whether lights are tested for what stands between them and what is seen.
    bounce_rays : int
        Directions in which a vertex looks for light from other parts, where the
        scene declares interreflection. 0 (none) or 16 to 65,536
    refine : float or None
        Contrast to a neighbour above which a pixel gets all 16 samples, about in
        units of ΔE; so does every pixel that an outline crosses. None: all pixels
        have as many.
    spectrum : str
        Where colours are summed over wavelengths: one of ``SPECTRA``. Spectra are
        always those of the scene's own wavelengths.
    reflectance : {"vertices", "table", "model"}
        Mapped skin: interpolated from vertices, or from a table of the model, or the
        model at each point.
    specular : {"none", "constant", "dispersion"}
        The surface's reflection: left out, with one refractive index, or with that
        of each wavelength.
    shading : {"vertices", "points"}
        Whether light is computed at vertices and interpolated, or at each point.
    basis : {"shared", "points"}
        Whether uniform skin's spectra are shared by all points, or computed at each:
        the plain way, with which the other is compared.
    arithmetic : {"single", "double"}
        Numbers in which mapped skin's colours are tabled and interpolated.
    tolerance : float or None
        What :func:`skinviz.plan` was asked to keep. [ΔE00]
    findings : tuple of Finding
        What it found, knob by knob.
    """

    samples: int = MOST_SAMPLES
    shadows: bool = True
    bounce_rays: int = 256
    refine: float | None = None
    spectrum: str = "1 nm"
    reflectance: str = "model"
    specular: str = "dispersion"
    shading: str = "points"
    basis: str = "shared"
    arithmetic: str = "double"
    tolerance: float | None = None
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what is no level of a knob."""
        samples = in_range(self.samples, SAMPLES[0], SAMPLES[-1], "samples")
        if samples not in SAMPLES:
            raise ArgumentError(
                f"samples must be one of {', '.join(map(str, SAMPLES))}; got "
                f"{self.samples!r}"
            )
        rays = in_range(self.bounce_rays, 0, 65536, "bounce_rays")
        if rays != int(rays) or 0 < rays < 16:
            raise ArgumentError(
                "bounce_rays must be 0 or a whole number from 16 to 65,536; got "
                f"{self.bounce_rays!r}"
            )
        if not isinstance(self.shadows, bool | np.bool):
            raise ArgumentError(f"shadows must be True or False; got {self.shadows!r}")
        if self.refine is not None:
            refine = in_range(self.refine, 0.0, 1e6, "refine")
            object.__setattr__(self, "refine", refine)
        one_of(self.spectrum, SPECTRA, "spectrum")
        one_of(self.reflectance, REFLECTANCES, "reflectance")
        one_of(self.specular, SPECULARS, "specular")
        one_of(self.shading, PLACES, "shading")
        one_of(self.basis, BASES, "basis")
        one_of(self.arithmetic, ARITHMETICS, "arithmetic")
        # As Python's own, which go into files.
        object.__setattr__(self, "samples", int(samples))
        object.__setattr__(self, "bounce_rays", int(rays))
        object.__setattr__(self, "shadows", bool(self.shadows))

    @property
    def cells(self) -> Array:
        """Where in a pixel its samples are (samples, 2), from its top left. [pixels]"""
        return cells(self.samples)

    def replace(self, **changes: Any) -> Plan:
        """Return the plan with some attributes changed."""
        return dataclasses.replace(self, **changes)

    def explain(self) -> str:
        """Return what was chosen, knob by knob, as a table.

        What is left out of the reference by each choice, what that changes in the
        picture (a 99.9 % bound on the 99th percentile of ΔE00, by the pilot), and
        what it saves.
        """
        return told_table(self.tolerance, self.findings)


def cells(samples: int) -> Array:
    """Return the places of a pixel's first samples (samples, 2). [pixels]"""
    return (np.array(_CELLS[:samples]) + 0.5) / _GRID
