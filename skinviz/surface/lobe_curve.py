"""The curve that a lobe's fit draws through readings in the plane of incidence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers
from skinviz.surface.fresnel import fresnel_reflectance
from skinviz.surface.torrance_sparrow import TorranceSparrow

Array = NDArray[np.float64]

PARAMETERS = ("beta", "gamma", "n")
"""What may be free, in this order: β [1], γ [rad] and the refractive index n [1]."""

BOUNDS = {"beta": (0.0, 2e5), "gamma": (1e-4, np.pi / 2), "n": (1.0, 3.0)}
"""Within which each is sought."""

_LN2 = np.log(2.0)


def in_plane(
    surface: Any, illumination: ArrayLike, viewing: ArrayLike = np.pi / 3
) -> Array:
    """Return a surface's specular part with light and viewer on opposite sides.

    Parameters
    ----------
    surface : TorranceSparrow or another surface
        Its ``evaluate`` is asked.
    illumination, viewing : array_like
        Angles from the normal, broadcast together. [rad]

    Returns
    -------
    specular : ndarray
        In units of the perfect diffuser that faces the light. [1]
    """
    light, view = as_numbers(illumination, "illumination"), as_numbers(viewing, "view")
    light, view = np.broadcast_arrays(light, view)
    across = np.zeros(light.shape)
    towards_light = np.stack([-np.sin(light), across, np.cos(light)], axis=-1)
    towards_viewer = np.stack([np.sin(view), across, np.cos(view)], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    return np.asarray(surface.evaluate(up, towards_light, towards_viewer))


@dataclass(frozen=True, eq=False)
class LobeCurve:
    """The fit's function β · S · D(φ; γ) · F(μ; n) at the readings (m,).

    ``names`` says what is free and in what order it is given, ``fixed`` the rest;
    ``turn`` is φ [rad], ``cosine`` is μ = V·H and ``spread`` is S, which depends on no
    parameter.
    """

    names: tuple[str, ...]
    fixed: dict[str, float]
    turn: Array
    cosine: Array
    spread: Array

    @property
    def bounds(self) -> Array:
        """Lower and upper bounds (2, p) of what is free."""
        return np.array([BOUNDS[name] for name in self.names]).T

    def every(self, values: Array) -> tuple[Array, Array, Array]:
        """Return β, γ and n (...) of values (..., p), free or fixed."""
        beta, gamma, n = (
            values[..., self.names.index(name)]
            if name in self.names
            else np.full(values.shape[:-1], self.fixed[name])
            for name in PARAMETERS
        )
        return beta, gamma, n

    def __call__(self, values: Array) -> Array:
        """Return the specular part (..., m) of values (..., p)."""
        beta, gamma, n = (x[..., None] for x in self.every(values))
        F = fresnel_reflectance(self.cosine, n)
        with np.errstate(under="ignore"):
            return np.asarray(beta * self.spread * self._facets(gamma) * F)

    def slopes(self, values: Array) -> Array:
        """Return the derivatives (m, p) of the curve by what is free."""
        beta, gamma, n = self.every(values)
        F, F_slope = fresnel_reflectance(self.cosine, n), _fresnel_slope(self.cosine, n)
        with np.errstate(under="ignore"):
            lit = self.spread * self._facets(gamma)
            columns = {
                "beta": lit * F,
                "gamma": beta * lit * F * 2 * _LN2 * np.square(self.turn) / gamma**3,
                "n": beta * lit * F_slope,
            }
        return np.stack([columns[name] for name in self.names], axis=1)

    def _facets(self, gamma: Array) -> Array:
        """Return D."""
        return np.asarray(np.exp(-_LN2 * np.square(self.turn / gamma)))


def masked_spread(light: Array, view: Array, masking: str) -> Array:
    """Return G/(N·V), which depends on no parameter, through the surface itself."""
    widest, n = np.pi / 2, 3.0
    wide = TorranceSparrow(widest, n, 1.0, masking)
    turn, cosine = np.abs(light - view) / 2, np.cos((light + view) / 2)
    D = np.exp(-_LN2 * np.square(turn / widest))
    known = wide.beta * D * fresnel_reflectance(cosine, n)
    return np.asarray(in_plane(wide, light, view) / known)


def _fresnel_slope(cosine: Array, n: Array) -> Array:
    """Return ∂F/∂n of Fresnel's reflectance; 0 at grazing, where F is 1 for every n."""
    mu = np.minimum(cosine, 1.0)
    excess = (n - 1) * (n + 1)
    g = np.sqrt(excess + mu * mu)
    total = g + mu
    gap = excess / total
    A, B = gap / total, (mu * total - 1) / (mu * gap + 1)
    A_slope = 2 * mu / total**2
    B_slope = 2 * mu * (1 - mu * mu) / (mu * gap + 1) ** 2
    return np.asarray(A * ((1 + B * B) * A_slope + A * B * B_slope) * n / g)
