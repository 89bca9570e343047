"""How much light a surface reflects: integrals over its facets and the hemisphere."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from skinviz.surface.surface import Surface

Array = NDArray[np.float64]

_RADIAL, _AZIMUTHS = 160, 240


def physical_beta(distribution: Callable[[Array], Array], reach: float) -> float:
    """Return β₁ = π/(4 ∫ D cos θ dω), at which facets cover the surface once. [1]

    Parameters
    ----------
    distribution : callable
        D of the facets' angle from the normal (n,). [rad]
    reach : float
        Angle beyond which D is nothing. [rad]
    """
    nodes, weights = _rule(80)
    angles = nodes * reach
    # 2π ∫ D sin θ cos θ dθ
    covered = (
        np.pi * reach * float(weights @ (distribution(angles) * np.sin(2 * angles)))
    )
    return float(np.pi / (4 * covered))


def specular_albedo(
    surface: Surface,
    highest_angle: float = np.deg2rad(80),
    *,
    n: float | None = None,
) -> float:
    """Return the largest share of light reflected specularly, 0 to ``highest_angle``.

    The hemispherical integral of the BRDF's specular part times the cosine of
    leaving, light at a fixed angle, by quadrature over the hemisphere. [1]

    Parameters
    ----------
    surface : Surface
        Any model.
    highest_angle : float
        The light's angles are nine from 0 to this. [rad], below π/2
    n : float, optional
        Refractive index instead of the surface's own. [1]
    """
    angles = np.linspace(0.0, highest_angle, 9)
    return max(_albedo(surface, angle, n) for angle in angles)


def _albedo(surface: Surface, angle: float, n: float | None) -> float:
    """Return the share reflected from light at an angle of incidence [rad].

    Over the facets, where the lobe is smooth however narrow it is: a facet h sends
    light to 2(l·h)h − l, and dω of leaving is 4 (l·h) dω of the facet.
    """
    nodes, weights = _rule(_RADIAL)
    reach = surface.reach(angle)
    tilt = nodes * reach
    half = _directions(tilt)
    area = (weights * reach * np.sin(tilt))[:, None] * (2 * np.pi / _AZIMUTHS)
    light = np.array([np.sin(angle), 0.0, np.cos(angle)])
    facing = half @ light
    view = 2 * facing[..., None] * half - light
    seen = (facing > 0) & (view[..., 2] > 0)
    # evaluate() is π f cos(incidence): E is the irradiance over π at normal incidence.
    value = surface.evaluate(np.array([0.0, 0.0, 1.0]), light, view, n)
    flux = np.where(seen, value * view[..., 2] * 4 * facing * area, 0.0).sum()
    return float(flux / (np.pi * np.cos(angle)))


def _directions(tilt: Array) -> Array:
    """Return unit vectors (t, azimuths, 3) tilted from the z axis."""
    azimuth = (np.arange(_AZIMUTHS) + 0.5) * 2 * np.pi / _AZIMUTHS
    sine, up = np.sin(tilt), np.cos(tilt)
    return np.stack(
        [
            np.outer(sine, np.cos(azimuth)),
            np.outer(sine, np.sin(azimuth)),
            np.outer(up, np.ones(_AZIMUTHS)),
        ],
        axis=-1,
    )


@cache
def _rule(n: int) -> tuple[Array, Array]:
    """Return Gauss and Legendre's nodes and weights on 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return (nodes + 1) / 2, weights / 2
