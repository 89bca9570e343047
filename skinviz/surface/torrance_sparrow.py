"""Torrance and Sparrow's reflection from a rough dielectric: the paper's surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range, one_of
from skinviz.surface import energy, masking
from skinviz.surface.dispersion import Dispersion, require_refraction
from skinviz.surface.surface import Surface, told_index

Array = NDArray[np.float64]

MASKINGS = ("v-cavity", "none")
"""``"v-cavity"``: Torrance–Sparrow's G; ``"none"``: eq. (10) to the letter."""

_LN2 = np.log(2.0)
_HALF_WIDTHS = 9.5  # beyond which D < 1e-27


@dataclass(frozen=True)
class TorranceSparrow(Surface):
    """Specular reflection from a rough dielectric, second term of eq. (10).

    D = exp(−ln 2 (φ/γ)²) of the angle φ between the normal and the halfway vector.

    Attributes
    ----------
    gamma : float
        Half-width of the facets' distribution: D falls to ½ at this angle between
        the normal and the halfway vector. [rad], 1e-4 to π/2
    n : float or Dispersion
        Refractive index of the skin. [1], 1 to 3
    specular_scale : float
        β as a share of the β at which the surface reflects what Fresnel's law
        says and no more. [1], ≥ 0; 0 switches the specular term off
    masking : {"v-cavity", "none"}
        With the masking and shadowing of facets, or eq. (10) as printed.

    Notes
    -----
    G/(N·V) is one expression, finite unless light and viewer both graze.

    References
    ----------
    .. [1] K. E. Torrance and E. M. Sparrow, J. Opt. Soc. Am. 57:1105 (1967).
    .. [2] Doi, Tanaka & Tominaga, J. Imaging Sci. Technol. 49:574 (2005), eq. (10).
    """

    name: ClassVar[str] = "torrance-sparrow"

    gamma: float = 0.27
    n: float | Dispersion = 1.4
    specular_scale: float = 1.0
    masking: str = "v-cavity"

    def __post_init__(self) -> None:
        """Refuse what no surface has."""
        in_range(self.gamma, 1e-4, np.pi / 2, "gamma", "rad")
        require_refraction(self.n)
        in_range(self.specular_scale, 0.0, 1e6, "specular_scale")
        one_of(self.masking, MASKINGS, "masking")

    @classmethod
    def from_beta(
        cls,
        beta: float,
        gamma: float = 0.27,
        n: float | Dispersion = 1.4,
        masking: str = "v-cavity",
    ) -> TorranceSparrow:
        """Return the surface with the weight β of eq. (10) given itself. [1], ≥ 0"""
        in_range(gamma, 1e-4, np.pi / 2, "gamma", "rad")
        in_range(beta, 0.0, 1e6, "beta")
        return cls(gamma, n, beta / physical_beta(gamma), masking)

    @property
    def physical_beta(self) -> float:
        """β₁ = π/(4 ∫ D cos θ dω), at which facets cover the surface once. [1]"""
        return physical_beta(self.gamma)

    @property
    def beta(self) -> float:
        """The weight β of eq. (10). [1]"""
        return self.specular_scale * self.physical_beta

    @property
    def description(self) -> str:
        """The model and its parameters, in a line of words."""
        return (
            f"Torrance-Sparrow, gamma {self.gamma:g} rad, {told_index(self.n)}, beta "
            f"{self.beta:.4g} ({self.specular_scale:.3g} of the physical), masking "
            f"{self.masking}"
        )

    @property
    def lobe(self) -> Any:
        """The compiled lobe; see ``surface.kernels.LOBE``."""
        from skinviz.surface import kernels

        return kernels.torrance_sparrow

    @property
    def constants(self) -> Array:
        """What the lobe is given."""
        steepness = np.sqrt(_LN2) / self.gamma
        return np.array([self.beta, steepness, float(self.masking != "none")])

    def factors(self, cosines: Array) -> tuple[Array, Array]:
        """Return D and G/(N·V); the angle is accurate also where it is small."""
        D = facet_distribution(np.arctan2(cosines[3], cosines[2]), self.gamma)
        hidden = masking.unmasked if self.masking == "none" else masking.v_cavity
        return D, hidden(cosines)

    def reach(self, incidence: float) -> float:
        """Return how far facets are tilted that still matter. [rad]"""
        del incidence  # facets lie as they lie
        return _reach(self.gamma)


def facet_distribution(angle: Array, gamma: float) -> Array:
    """Return Torrance–Sparrow's Gaussian D at angles from the normal [rad]."""
    with np.errstate(under="ignore"):
        return np.asarray(np.exp(-_LN2 * np.square(angle / gamma)))


@cache
def physical_beta(gamma: float) -> float:
    """Return β₁ of a half-width γ [rad]; see :attr:`Surface.physical_beta`. [1]"""
    return energy.physical_beta(lambda t: facet_distribution(t, gamma), _reach(gamma))


def _reach(gamma: float) -> float:
    """Return the angle beyond which D is nothing. [rad]"""
    return float(min(_HALF_WIDTHS * gamma, np.pi / 2))
