"""Cook and Torrance's reflection: Beckmann's facets on a rough dielectric."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range, one_of
from skinviz.surface import masking
from skinviz.surface.dispersion import Dispersion, require_refraction
from skinviz.surface.surface import Surface, told_index

Array = NDArray[np.float64]

MASKINGS = ("v-cavity", "smith", "none")
"""``"smith"``: the G of Mitsuba and most renderers; ``"none"``: nothing hidden."""

_STEEPEST = 8.0  # tan θ/m beyond which D < 1e-27
_LEAST = 1e-30  # cosine of facets that stand on edge


@dataclass(frozen=True)
class CookTorrance(Surface):
    """Specular reflection from facets whose slopes are Gaussian [1]_ [2]_.

    D = exp(−tan²θ/m²)/(π m² cos⁴θ) of the angle θ between the normal and the halfway
    vector: ∫ D cos θ dω = 1. The BRDF is D F G/(4 N·L N·V) times ``specular_scale``.

    Attributes
    ----------
    roughness : float
        Beckmann's m, √2 times the facets' rms slope. [1], 1e-4 to π/2
    n : float or Dispersion
        Refractive index of the skin. [1], 1 to 3
    specular_scale : float
        Share of what facets that cover the surface once reflect. [1], ≥ 0
    masking : {"v-cavity", "smith", "none"}
        Which facets hide others: Torrance and Sparrow's grooves, which Cook and
        Torrance use; Smith's G₁ G₁ in Walter's approximation, as Mitsuba's
        ``roughconductor`` and ``roughdielectric``; or nothing hidden.

    References
    ----------
    .. [1] R. L. Cook and K. E. Torrance, ACM Trans. Graphics 1:7 (1982).
    .. [2] P. Beckmann and A. Spizzichino, The Scattering of Electromagnetic Waves
       from Rough Surfaces, Pergamon (1963).
    """

    name: ClassVar[str] = "cook-torrance"

    roughness: float = 0.3
    n: float | Dispersion = 1.4
    specular_scale: float = 1.0
    masking: str = "v-cavity"

    def __post_init__(self) -> None:
        """Refuse what no surface has."""
        in_range(self.roughness, 1e-4, np.pi / 2, "roughness")
        require_refraction(self.n)
        in_range(self.specular_scale, 0.0, 1e6, "specular_scale")
        one_of(self.masking, MASKINGS, "masking")

    @property
    def physical_beta(self) -> float:
        """π/4, because ∫ D cos θ dω is 1. [1]"""
        return float(np.pi / 4)

    @property
    def beta(self) -> float:
        """The weight of D F G/(N·V). [1]"""
        return self.specular_scale * self.physical_beta

    @property
    def description(self) -> str:
        """The model and its parameters, in a line of words."""
        return (
            f"Cook-Torrance, Beckmann slope {self.roughness:g}, {told_index(self.n)}, "
            f"{self.specular_scale:.3g} of the physical, masking {self.masking}"
        )

    @property
    def lobe(self) -> Any:
        """The compiled lobe; see ``surface.kernels.LOBE``."""
        from skinviz.surface import kernels

        return kernels.cook_torrance

    @property
    def constants(self) -> Array:
        """What the lobe is given."""
        m = self.roughness
        height = self.beta / (np.pi * m * m)
        return np.array([height, 1 / m, float(MASKINGS.index(self.masking))])

    def factors(self, cosines: Array) -> tuple[Array, Array]:
        """Return D and G/(N·V)."""
        D = facet_distribution(cosines[3], cosines[2], self.roughness)
        if self.masking == "smith":
            return D, masking.smith(cosines, self.roughness)
        hidden = masking.unmasked if self.masking == "none" else masking.v_cavity
        return D, hidden(cosines)

    def reach(self, incidence: float) -> float:
        """Return how far facets are tilted that still matter. [rad]"""
        del incidence  # facets lie as they lie
        return float(np.arctan(_STEEPEST * self.roughness))


def facet_distribution(sine: Array, cosine: Array, roughness: float) -> Array:
    """Return Beckmann's D of facets by their angle's sine and cosine. [sr⁻¹]"""
    c = np.maximum(cosine, _LEAST)
    slope = sine / (roughness * c)
    with np.errstate(under="ignore"):
        D = np.exp(-slope * slope) / (np.pi * roughness**2 * c**4)
    return np.where(cosine > 0, D, 0.0)
