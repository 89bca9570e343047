"""Torrance and Sparrow's reflection from a rough dielectric: the paper's surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import in_range, one_of
from skinviz.surface.evaluation import cosines, specular, unit_vectors
from skinviz.surface.fresnel import as_index, fresnel_reflectance

Array = NDArray[np.float64]

MASKINGS = ("v-cavity", "none")
"""``"v-cavity"``: Torrance–Sparrow's G; ``"none"``: eq. (10) to the letter."""

_LN2 = np.log(2.0)
_SMALLEST_COSINE = 1e-3  # to which a normal that faces away is bent


@dataclass(frozen=True)
class TorranceSparrow:
    """Specular reflection from a rough dielectric, second term of eq. (10).

    Attributes
    ----------
    gamma : float
        Half-width of the facets' distribution: D falls to ½ at this angle between
        the normal and the halfway vector. [rad], 1e-4 to π/2
    n : float
        Refractive index of the skin. [1], 1 to 3
    specular_scale : float
        β as a share of the β at which the surface reflects what Fresnel's law
        says and no more. [1], ≥ 0; 0 switches the specular term off
    masking : {"v-cavity", "none"}
        With the masking and shadowing of facets, or eq. (10) as printed.

    References
    ----------
    .. [1] K. E. Torrance and E. M. Sparrow, J. Opt. Soc. Am. 57:1105 (1967).
    .. [2] Doi, Tanaka & Tominaga, J. Imaging Sci. Technol. 49:574 (2005), eq. (10).
    """

    gamma: float = 0.27
    n: float = 1.4
    specular_scale: float = 1.0
    masking: str = "v-cavity"

    def __post_init__(self) -> None:
        """Refuse what no surface has."""
        in_range(self.gamma, 1e-4, np.pi / 2, "gamma", "rad")
        in_range(self.n, 1.0, 3.0, "refractive index n")
        in_range(self.specular_scale, 0.0, 1e6, "specular_scale")
        one_of(self.masking, MASKINGS, "masking")

    @classmethod
    def from_beta(
        cls, beta: float, gamma: float, n: float = 1.4, masking: str = "v-cavity"
    ) -> TorranceSparrow:
        """Return the surface with the weight β of eq. (10) given itself. [1], ≥ 0"""
        in_range(gamma, 1e-4, np.pi / 2, "gamma", "rad")
        in_range(beta, 0.0, 1e6, "beta")
        return cls(gamma, n, beta / physical_beta(gamma), masking)

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

    @property
    def beta(self) -> float:
        """The weight β of eq. (10). [1]"""
        return self.specular_scale * physical_beta(self.gamma)

    def evaluate(
        self,
        normals: ArrayLike,
        light: ArrayLike,
        view: ArrayLike,
        n: ArrayLike | None = None,
    ) -> Array:
        """Return β D F G/(N·V): specular radiance over that of the lit diffuser.

        Parameters
        ----------
        normals, light, view : (..., 3) array_like
            Unit vectors from the surface: its normal, towards light and viewer;
            broadcast together.
        n : (...) array_like, optional
            Refractive index instead of the surface's own, broadcast with the
            vectors. [1], ≥ 1

        Returns
        -------
        specular : (...) ndarray of float64
            To be multiplied by E(λ), the radiance of the perfect diffuser lit at
            normal incidence. 0 where the light is behind the surface. [1]

        Raises
        ------
        ArgumentError
            If a vector is not of length 1, or an index below 1 or not finite.

        Notes
        -----
        G/(N·V) is one expression, finite unless light and viewer both graze. A
        normal that faces away from the viewer, as interpolated normals do at
        silhouettes, counts as N·V = 0.001.
        """
        index = as_index(self.n if n is None else n)
        return specular(self.lobe, self.constants, index, normals, light, view)

    def parts(
        self,
        normals: ArrayLike,
        light: ArrayLike,
        view: ArrayLike,
        n: ArrayLike | None = None,
    ) -> dict[str, Array]:
        """Return the factors of :meth:`evaluate` without β, for plots.

        ``"distribution"`` is D, ``"attenuation"`` G/(N·V), ``"fresnel"`` F.
        """
        index = as_index(self.n if n is None else n)
        seen = cosines(*unit_vectors(normals, light, view))
        NL, NV, NH, SH, VH = seen
        NV = np.maximum(NV, _SMALLEST_COSINE)
        return {
            "distribution": _gaussian(np.arctan2(SH, NH), self.gamma),
            "attenuation": np.where(NL > 0, self._masked(NH, NV, NL, VH), 0.0),
            "fresnel": fresnel_reflectance(VH, index),
        }

    def _masked(self, NH: Array, NV: Array, NL: Array, VH: Array) -> Array:
        """Return G/(N·V), or 1/(N·V) without masking."""
        if self.masking == "none":
            return 1 / NV
        # Light from exactly behind the viewer's back side has no halfway vector.
        VH = np.maximum(VH, 1e-12)
        return np.minimum(
            np.minimum(1 / NV, 2 * np.maximum(NH, 0) / VH),
            2 * np.maximum(NH, 0) * NL / (VH * NV),
        )


def facet_distribution(normals: Array, half: Array, gamma: float) -> Array:
    """Return Torrance–Sparrow's Gaussian D = exp(−ln 2 (φ/γ)²) of the facet angle φ.

    φ comes from the sine and the cosine together, accurate at small angles.
    """
    sine = np.linalg.norm(np.cross(normals, half), axis=-1)
    return _gaussian(np.arctan2(sine, _dot(normals, half)), gamma)


def _gaussian(angle: Array, gamma: float) -> Array:
    """Return D at angles [rad]."""
    with np.errstate(under="ignore"):
        return np.asarray(np.exp(-_LN2 * np.square(angle / gamma)))


@cache
def physical_beta(gamma: float) -> float:
    """Return β₁ = π/(4 ∫ D cos θ dω), at which facets cover the surface once. [1]

    With masking, the specular albedo is then at most 1 for every F and angle.
    """
    # In units of γ the integrand is smooth whatever γ is; D < 1e-27 beyond 9.5 γ.
    end = min(np.pi / 2 / gamma, 9.5)
    nodes, weights = np.polynomial.legendre.leggauss(80)
    t = (nodes + 1) * end / 2
    integrand = np.exp(-_LN2 * t**2) * np.sin(2 * gamma * t)
    # 2π ∫ D sin θ cos θ dθ = π γ ∫ D sin 2θ dt
    covered = np.pi * gamma * float(weights @ integrand) * end / 2
    return float(np.pi / (4 * covered))


def specular_albedo(
    surface: TorranceSparrow, highest_angle: float = np.deg2rad(80)
) -> float:
    """Return the largest share of light reflected specularly, 0 to ``highest_angle``.

    The hemispherical integral of the BRDF's specular part times the cosine of
    leaving, light at a fixed angle, by quadrature over the hemisphere. [1]
    """
    # Over the facets, where the lobe is smooth however narrow it is: a facet h sends
    # light to 2(l·h)h − l, and dω of leaving is 4 (l·h) dω of the facet.
    end = min(np.pi / 2, 9.5 * surface.gamma)
    nodes, weights = np.polynomial.legendre.leggauss(160)
    tilt = (nodes + 1) * end / 2
    azimuth = (np.arange(240) + 0.5) * 2 * np.pi / 240
    half = np.stack(
        [
            np.outer(np.sin(tilt), np.cos(azimuth)),
            np.outer(np.sin(tilt), np.sin(azimuth)),
            np.outer(np.cos(tilt), np.ones(azimuth.size)),
        ],
        axis=-1,
    )
    area = (weights * end / 2 * np.sin(tilt))[:, None] * (2 * np.pi / azimuth.size)
    normal = np.array([0.0, 0.0, 1.0])
    shares = []
    for angle in np.linspace(0.0, highest_angle, 9):
        light = np.array([np.sin(angle), 0.0, np.cos(angle)])
        facing = _dot(light, half)
        view = 2 * facing[..., None] * half - light
        seen = (facing > 0) & (view[..., 2] > 0)
        # evaluate() is π f cos(incidence): E is the irradiance over π at normal
        # incidence.
        leaving = surface.evaluate(normal, light, view) * view[..., 2]
        flux = np.where(seen, leaving * 4 * facing * area, 0.0).sum()
        shares.append(flux / (np.pi * np.cos(angle)))
    return float(max(shares))


def _dot(a: Array, b: Array) -> Array:
    """Return the scalar product on the last axis."""
    return np.asarray((a * b).sum(axis=-1))
