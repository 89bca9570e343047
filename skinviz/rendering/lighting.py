"""The two factors of a scene's radiance: what depends on place, and on wavelength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.rendering import kernels
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.plan import Plan
from skinviz.rendering.sight import Sight
from skinviz.scene.scene import Scene
from skinviz.spectra.rules import SpectralRule
from skinviz.surface.dispersion import dispersion_basis

Array = NDArray[np.float64]

_ALL = np.zeros((0, 0), dtype=np.uint8)
_MIDDLE = 555.0  # nm, where eyes see best: the one index that stands for all


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
    """What the scalars of a point are multiplied by, at some wavelengths.

    Attributes
    ----------
    wavelengths : (J,) ndarray
        Not necessarily ascending. [nm]
    light : (n_lights, J) ndarray
        α E, to be multiplied by what leaves the skin from inside.
    shine : (n_lights · k, J) ndarray
        E times the weights of each refractive index.
    body : (J,) ndarray or None
        What leaves the skin from inside, where all points share it; else None. [1]
    colour : (J, 3) ndarray
        By which radiance becomes XYZ.
    """

    wavelengths: Array
    light: Array
    shine: Array
    body: Array | None
    colour: Array

    def products(self, fields: Array) -> Array:
        """Return what all scalars of uniform skin go with (rows + e, J).

        ``fields`` (e, J) are of light that other parts throw on the point.
        """
        body = 1.0 if self.body is None else self.body  # else multiplied in later
        return np.concatenate([self.light * body, self.shine, fields * body])


def lighting_of(scene: Scene, sight: Sight, indices: Array) -> Lighting:
    """Return a scene's lights and surface, as they are seen.

    ``indices`` (k,) are those at which Fresnel's law is to be computed.

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
    return Lighting(
        lights=lights,
        reaches=reaches,
        eye=sight.eye,
        lobe=surface.lobe,
        constants=surface.constants,
        indices=indices,
    )


def spectra_of(scene: Scene, rule: SpectralRule, plan: Plan) -> tuple[Spectra, Array]:
    """Return the spectra by which a scene's scalars are multiplied.

    With them come the refractive indices (k,) that their specular part is made for.
    """
    powers = light_scale(scene)[:, None] * rule.light
    indices, weights = fresnel_basis(scene, rule.wavelengths, plan.specular)
    uniform = scene.skin.values.ndim == 1 and plan.basis == "shared"
    spectra = Spectra(
        wavelengths=rule.wavelengths,
        light=scene.diffuse_scale * powers,
        shine=(powers[:, None] * weights).reshape(-1, rule.wavelengths.size),
        body=body_at(scene, scene.skin.values, rule.wavelengths) if uniform else None,
        colour=rule.colour,
    )
    return spectra, indices


def light_scale(scene: Scene) -> Array:
    """Return what each light's Y of the perfect diffuser is (lights,)."""
    first = scene.lights[0].strength
    return np.array(
        [scene.exposure * (light.strength / first) for light in scene.lights]
    )


def body_at(scene: Scene, values: Array, wavelengths: Array) -> Array:
    """Return what leaves skin of some parameters (..., p) from inside (..., J). [1]"""
    model = scene.skin.model
    if (np.diff(wavelengths) > 0).all():
        return model.diffuse(values, wavelengths)
    ascending, places = np.unique(wavelengths, return_inverse=True)
    return model.diffuse(values, ascending)[..., places]


def fresnel_basis(
    scene: Scene, wavelengths: Array, specular: str
) -> tuple[Array, Array]:
    """Return indices (k,) of refraction and their weights (k, J) at wavelengths.

    As many as ``specular`` says: none, one, or what the dispersion needs.
    """
    if specular == "none":
        return np.zeros(0), np.zeros((0, wavelengths.size))
    n = scene.surface.n
    if isinstance(n, float | int):
        return np.array([float(n)]), np.ones((1, wavelengths.size))
    if specular == "constant":
        return n.index([_MIDDLE]), np.ones((1, wavelengths.size))
    return dispersion_basis(n.index(wavelengths))
