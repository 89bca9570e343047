"""Phong's reflection about the mirror direction, for comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.surface.dispersion import Dispersion, require_refraction
from skinviz.surface.surface import Surface, told_index

Array = NDArray[np.float64]

_NOTHING = 62.0  # −ln of a share of 1e-27


@dataclass(frozen=True)
class Phong(Surface):
    """Specular reflection cos^p α about the mirror direction [1]_, normalised [2]_.

    The BRDF is F cos^p α (p + 2)/(2π) times ``specular_scale``, α the angle between
    the viewer and the mirror image of the light: symmetric in both, so reciprocal, and
    with F = 1 its albedo is 1 at normal incidence and less elsewhere. As a term of
    eq. (10): D = cos^p α, N·L in place of G/(N·V), β = (p + 2)/2. F is that of the
    angle between the viewer and the halfway vector, as in the other models.

    Attributes
    ----------
    exponent : float
        p. About ln 2/(2 γ²) for a lobe as wide as facets of half-width γ make at
        normal incidence. [1], 0 to 1e9
    n : float or Dispersion
        Refractive index of the skin. [1], 1 to 3
    specular_scale : float
        Share of the normalised lobe. [1], ≥ 0

    References
    ----------
    .. [1] B. T. Phong, Comm. ACM 18:311 (1975).
    .. [2] E. P. Lafortune and Y. D. Willems, Using the modified Phong reflectance
       model for physically based rendering, K. U. Leuven CW 197 (1994).
    """

    name: ClassVar[str] = "phong"

    exponent: float = 5.0
    n: float | Dispersion = 1.4
    specular_scale: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what no surface has."""
        in_range(self.exponent, 0.0, 1e9, "exponent")
        require_refraction(self.n)
        in_range(self.specular_scale, 0.0, 1e6, "specular_scale")

    @property
    def physical_beta(self) -> float:
        """(p + 2)/2, at which the lobe reflects all light along the normal. [1]"""
        return (self.exponent + 2) / 2

    @property
    def beta(self) -> float:
        """The weight of cos^p α F N·L. [1]"""
        return self.specular_scale * self.physical_beta

    @property
    def description(self) -> str:
        """The model and its parameters, in a line of words."""
        return (
            f"Phong, exponent {self.exponent:g}, {told_index(self.n)}, "
            f"{self.specular_scale:.3g} of the normalised"
        )

    @property
    def lobe(self) -> Any:
        """The compiled lobe; see ``surface.kernels.LOBE``."""
        from skinviz.surface import kernels

        return kernels.phong

    @property
    def constants(self) -> Array:
        """What the lobe is given."""
        return np.array([self.beta, self.exponent])

    def factors(self, cosines: Array) -> tuple[Array, Array]:
        """Return cos^p α and, in place of G/(N·V), N·L."""
        NL, NV, _, SH, VH = cosines
        # 1 − cos α = 2 |(N·L) N − (V·H) H|², a sum of squares: nothing cancels.
        drop = np.square(NL - NV) / 2 + 2 * np.square(VH * SH)
        with np.errstate(under="ignore"):
            D = np.exp(self.exponent * np.log1p(-np.minimum(drop, 1 - 2.0**-53)))
        return np.where(drop < 1, D, 0.0), np.maximum(NL, 0.0)

    def reach(self, incidence: float) -> float:
        """Return how far facets are tilted that still matter. [rad]

        Farther the more the light grazes: a facet tilted by φ across the plane of
        incidence turns light by sin(α/2) = sin φ cos(incidence).
        """
        drop = -np.expm1(-_NOTHING / max(self.exponent, 1e-3))
        sine = np.sqrt(drop / 2) / max(np.cos(incidence), 1e-12)
        return float(np.arcsin(min(sine, 1.0)))
