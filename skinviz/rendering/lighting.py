"""The two factors of a scene's radiance: what depends on place, and on wavelength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.rendering import kernels
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.sight import Sight
from skinviz.scene.lights import Light
from skinviz.scene.scene import Scene
from skinviz.spectra.colorimetry import colour_matching_functions, xyz_weights
from skinviz.spectra.wavelengths import band_widths
from skinviz.surface.dispersion import dispersion_basis

Array = NDArray[np.float64]

_ALL = np.zeros((0, 0), dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Lighting:
    """What each light gives a point, as scalars without wavelength.

    Attributes
    ----------
    lights : (n_lights, 4) ndarray
        Homogeneous, in the geometry's coordinates.
    reaches : (n_lights,) ndarray
        Squared distance at which a near light's irradiance is its strength.
    eye : (4,) ndarray
        Homogeneous, in the geometry's coordinates.
    lobe, constants : compiled function, (c,) ndarray
        Of the surface; see ``surface.kernels``.
    indices : (k,) ndarray
        Refractive indices at which Fresnel's law is computed.
    """

    lights: Array
    reaches: Array
    eye: Array
    lobe: Any
    constants: Array
    indices: Array

    @property
    def rows(self) -> int:
        """How many scalars a point has."""
        return len(self.lights) * (1 + self.indices.size)

    def expand(
        self,
        geometry: Geometry,
        part: slice,
        *,
        visible: NDArray[np.uint8] | None,
        fields: Array,
        spectra: NDArray[np.float32],
        out: NDArray[np.float32],
    ) -> Array:
        """Write some vertices' radiance (n, bands); return the scalars' peaks (k,)."""
        visible = _ALL if visible is None else np.ascontiguousarray(visible[:, part])
        peaks = np.zeros(len(spectra))
        kernels.expand_vertices(
            *(*geometry.components, part.start, self.lights, self.reaches, self.eye),
            *(self.lobe, self.constants, self.indices, visible),
            *(np.ascontiguousarray(fields[part]), spectra, out[part], peaks),
        )
        return peaks

    def scalars(
        self,
        points: Array,
        normals: Array,
        out: Array,
        start: int = 0,
        visible: NDArray[np.uint8] | None = None,
    ) -> None:
        """Write max(N·L, 0) of each light, then its specular scalars, (rows, n).

        ``points`` and ``normals`` (3, at least start + n) are read from ``start``;
        ``visible`` (n_lights, n) says which lights are seen: all, if it is None.
        """
        visible = _ALL if visible is None else visible
        kernels.scalars(
            *(points, normals, start, self.lights, self.reaches, self.eye),
            *(self.lobe, self.constants, self.indices, visible, out),
        )


@dataclass(frozen=True, eq=False)
class Spectra:
    """What the scalars of a point are multiplied by.

    Attributes
    ----------
    light : (n_lights, bands) ndarray
        α E, to be multiplied by what leaves the skin from inside.
    shine : (n_lights · k, bands) ndarray
        E times the weights of each refractive index.
    body : (bands,) ndarray or None
        What leaves the skin from inside, where it is uniform; else None. [1]
    colour : (bands, 3) ndarray
        By which radiance becomes XYZ.
    """

    light: Array
    shine: Array
    body: Array | None
    colour: Array

    def products(self, fields: Array) -> Array:
        """Return what all scalars of uniform skin go with (rows + e, bands).

        ``fields`` (e, bands) are of light that other parts throw on the point.
        """
        body = 1.0 if self.body is None else self.body  # else multiplied in later
        return np.concatenate([self.light * body, self.shine, fields * body])


def lighting_of(scene: Scene, sight: Sight) -> Lighting:
    """Return a scene's lights and surface, as they are seen.

    Raises
    ------
    ArgumentError
        If a light stands at the mesh's centroid, where its strength is defined.
    """
    geometry = sight.geometry
    lights = np.array([geometry.within(light.homogeneous) for light in scene.lights])
    to_centroid = lights[:, :3] - geometry.centroid
    reaches = np.square(to_centroid).sum(axis=1)
    near = lights[:, 3] != 0
    lost = np.flatnonzero(near & (reaches < 1e-12))
    if lost.size:
        raise ArgumentError(
            f"light {lost[0] + 1} stands at the mesh's centroid, where its strength "
            "is defined; move it out of the mesh"
        )
    surface = scene.surface
    indices, _ = dispersion_basis(refractive_index(scene))
    return Lighting(
        lights=lights,
        reaches=reaches,
        eye=sight.eye,
        lobe=surface.lobe,
        constants=surface.constants,
        indices=indices,
    )


def spectra_of(scene: Scene, body: Array | None) -> Spectra:
    """Return the spectra by which a scene's scalars are multiplied.

    ``body`` is that of :func:`uniform_body`, which lights do not change.
    """
    powers = light_spectra(scene)
    _, weights = dispersion_basis(refractive_index(scene))
    return Spectra(
        light=scene.diffuse_scale * powers,
        shine=(powers[:, None] * weights).reshape(-1, scene.wavelengths.size),
        body=body,
        colour=xyz_of_radiance(scene),
    )


def uniform_body(scene: Scene) -> Array | None:
    """Return what leaves uniform skin from inside (bands,), None of mapped skin."""
    values = scene.skin.values
    if values.ndim > 1:
        return None
    return scene.skin.model.diffuse(values, scene.wavelengths)


def light_spectra(scene: Scene) -> Array:
    """Return E(λ) of each light (lights, n): radiance of the lit perfect diffuser.

    Scaled so that Σ E ȳ Δλ of the first light is the exposure.
    """
    cmfs = colour_matching_functions(scene.wavelengths, scene.observer)
    seen = cmfs[:, 1] * band_widths(scene.wavelengths)

    def unit_luminance(light: Light) -> Array:
        spd = light.spectrum.spd(scene.wavelengths)
        xyz_weights(scene.wavelengths, spd, scene.observer)  # refuses unseen light
        return np.asarray(spd / (spd @ seen))

    first = scene.lights[0].strength
    return np.array(
        [
            scene.exposure * (light.strength / first) * unit_luminance(light)
            for light in scene.lights
        ]
    )


def xyz_of_radiance(scene: Scene) -> Array:
    """Return the weights (bands, 3) by which radiance becomes XYZ."""
    cmfs = colour_matching_functions(scene.wavelengths, scene.observer)
    return np.asarray(cmfs * band_widths(scene.wavelengths)[:, None])


def refractive_index(scene: Scene) -> Array:
    """Return the skin's refractive index at each band (bands,)."""
    n, bands = scene.surface.n, scene.wavelengths
    return np.full(bands.size, n) if isinstance(n, float | int) else n.index(bands)
