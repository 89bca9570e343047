"""Over which wavelengths a scene's light is summed, for colours and for spectra."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.rendering.lighting import body_at, light_scale
from skinviz.scene.scene import Scene
from skinviz.spectra.illuminants import Illuminant
from skinviz.spectra.rules import (
    SpectralRule,
    band_rule,
    exact_rule,
    quadrature_rule,
)
from skinviz.surface.dispersion import Dispersion

Array = NDArray[np.float64]

SEEN = (380.0, 780.0)
"""What colours are summed over, as far as the scene's data reach. [nm]"""

_PAPER = (400.0, 700.0)
_TRAINING = 64  # spectra of mapped skin that nodes are chosen for


def spectra_rule(scene: Scene) -> SpectralRule:
    """Return the rule of the scene's own wavelengths, on which spectra are told."""
    lamps = [light.spectrum for light in scene.lights]
    rule = band_rule(lamps, scene.wavelengths, scene.observer)
    lit = np.searchsorted(scene.wavelengths, rule.wavelengths)  # others are dark
    light = np.zeros((len(lamps), scene.wavelengths.size))
    colour = np.zeros((scene.wavelengths.size, 3))
    light[:, lit], colour[lit] = rule.light, rule.colour
    return SpectralRule(scene.wavelengths, light, colour)


def colour_rule(scene: Scene, spectrum: str) -> SpectralRule:
    """Return the rule by which a scene's colours are summed.

    Parameters
    ----------
    scene : Scene
        What is lit.
    spectrum : str
        One of ``plan.SPECTRA``.

    Raises
    ------
    ArgumentError
        If the lamps, the skin's coefficients and the surface's refractive index have
        no wavelengths in common, or the eye sees none of the light.
    """
    if spectrum == "scene":
        return spectra_rule(scene)
    lamps = [light.spectrum for light in scene.lights]
    limits = wavelength_limits(scene)
    if spectrum in ("16", "31"):
        bands = _even_bands(lamps, limits, int(spectrum))
        return band_rule(lamps, bands, scene.observer)
    exact = exact_rule(lamps, scene.observer, limits)
    if spectrum == "1 nm":
        return exact
    n_nodes = int(spectrum.split(maxsplit=1)[0])
    return quadrature_rule(exact, _training(scene, exact.wavelengths), n_nodes)


def _even_bands(lamps: list[Illuminant], limits: tuple[float, float], n: int) -> Array:
    """Return n wavelengths over the paper's range, as far as all data reach."""
    tables = [lamp.wavelengths for lamp in lamps if lamp.wavelengths.size > 1]
    low = max(_PAPER[0], limits[0], *(float(table[0]) for table in tables))
    high = min(_PAPER[1], limits[1], *(float(table[-1]) for table in tables))
    if low >= high:
        raise ArgumentError("the lamps' tables share no wavelengths that skin has")
    return np.linspace(low, high, n)


def light_spectra(scene: Scene) -> Array:
    """Return E(λ) of each light (lights, n): radiance of the lit perfect diffuser.

    On the scene's wavelengths, scaled so that Σ E ȳ Δλ of light 1 is the exposure.
    """
    return light_scale(scene)[:, None] * spectra_rule(scene).light


def white_xyz(scene: Scene) -> Array:
    """Return XYZ (3,) of the perfect diffuser that faces light 1; Y is the exposure."""
    rule = colour_rule(scene, "1 nm")
    return np.asarray(scene.exposure * (rule.light[0] @ rule.colour))


def wavelength_limits(scene: Scene) -> tuple[float, float]:
    """Return between which wavelengths a scene's skin and surface are known. [nm]"""
    low, high = scene.skin.model.limits
    n = scene.surface.n
    if isinstance(n, Dispersion):
        low, high = max(low, n.shortest), min(high, n.longest)
    low, high = max(low, SEEN[0]), min(high, SEEN[1])
    if low > high:
        raise ArgumentError(
            "the skin's coefficients and the surface's refractive index share no "
            f"wavelength from {SEEN[0]:g} to {SEEN[1]:g} nm"
        )
    return low, high


def _training(scene: Scene, wavelengths: Array) -> Array:
    """Return some of the scene's reflectances (m, J), that nodes are chosen for."""
    values = np.atleast_2d(scene.skin.values)
    some = values[np.linspace(0, len(values) - 1, _TRAINING).astype(int)]
    return body_at(scene, np.unique(some, axis=0), wavelengths)
