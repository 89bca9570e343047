"""Eq. (10) at every vertex: spectral radiance and its colour.

Radiance is a sum of products of a scalar that depends on geometry alone and a
spectrum that depends on skin and light alone:

    Y(λ) = Σ_lights [ α (N·L) · R(λ) E(λ)  +  β D F G/(N·V) · E(λ) ]

so colours need no spectra per vertex: each product's XYZ is the scalar times the
XYZ of its spectrum. R is what leaves the skin from inside it (``model.diffuse``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.errors import ArgumentError, MeshError
from skinviz.rendering.colour import to_srgb8
from skinviz.scan import topology
from skinviz.scan.formats.surface import UNIT_FIELD
from skinviz.scene.scene import DirectionalLight, Scene
from skinviz.spectra.colorimetry import colour_matching_functions, xyz_weights
from skinviz.spectra.illuminants import illuminant_spd
from skinviz.spectra.wavelengths import band_widths

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]


@dataclass(frozen=True)
class VertexSpectrum:
    """Radiance towards the camera at one vertex, in its two parts.

    Attributes
    ----------
    wavelengths : (n,) ndarray
        [nm]
    diffuse, specular : (n,) ndarray
        Radiance, in units in which the perfect diffuser under light 1 has Y = 1.
    white : (n,) ndarray
        Radiance of that diffuser, in the same units.
    """

    wavelengths: Array
    diffuse: Array
    specular: Array
    white: Array


def shade(scene: Scene) -> pyvista.PolyData:
    """Compute spectral radiance and colour at every vertex.

    Parameters
    ----------
    scene : Scene
        What is lit and seen.

    Returns
    -------
    mesh : pyvista.PolyData
        A copy of the scene's mesh with point data ``pigments`` (n, p),
        ``radiance`` (n, bands) float32 and ``rgb`` (n, 3) uint8, and field data
        ``wavelengths`` [nm], and counts of vertices: ``facing`` the camera, and
        ``over_exposed`` and ``out_of_gamut`` among them.

    Raises
    ------
    MeshError
        If a vertex belongs to no triangle with an area, so that it has no normal.
    ArgumentError
        If the radiance is too large for float32.

    Notes
    -----
    Radiance is in units in which the perfect diffuser facing light 1, lit by it
    alone, has Y = 1 × exposure. Every vertex is computed, also those that the
    camera cannot see. There are no cast shadows and no interreflection.
    """
    diffuse, specular = geometry_terms(scene)
    body = scene.skin.model.diffuse(scene.skin.values, scene.wavelengths)
    powers = light_spectra(scene)
    weights = _xyz_of_radiance(scene)
    mesh = scene.mesh.copy(deep=False)
    mesh.point_data["pigments"] = np.broadcast_to(
        scene.skin.values, (mesh.n_points, scene.skin.values.shape[-1])
    )
    mesh.point_data["radiance"] = _radiance(diffuse, specular, body, powers)
    xyz = np.zeros((mesh.n_points, 3))
    for scalar, gloss, power in zip(diffuse, specular, powers, strict=True):
        xyz += scalar[:, None] * ((body * power) @ weights)
        xyz += gloss[:, None] * (power @ weights)
    rgb, _ = to_srgb8(xyz)
    # A vertex that faces away has no true specular term and is not seen.
    facing = _normals(scene) @ scene.camera.direction > 0
    _, counts = to_srgb8(xyz[facing])
    mesh.point_data["rgb"] = rgb
    mesh.field_data["wavelengths"] = scene.wavelengths
    mesh.field_data["facing"] = [counts.total]
    mesh.field_data["over_exposed"] = [counts.over_exposed]
    mesh.field_data["out_of_gamut"] = [counts.out_of_gamut]
    mesh.field_data[UNIT_FIELD] = ["mm"]
    return mesh


def geometry_terms(scene: Scene) -> tuple[Array, Array]:
    """Return α (N·L) and β D F G/(N·V) for each light, both (lights, n_vertices)."""
    normals = _normals(scene)
    view = scene.camera.direction
    diffuse = [
        scene.diffuse_scale * np.maximum(normals @ light.direction, 0.0)
        for light in scene.lights
    ]
    specular = [
        scene.surface.evaluate(normals, light.direction, view) for light in scene.lights
    ]
    return np.array(diffuse), np.array(specular)


def _normals(scene: Scene) -> Array:
    """Return the unit normal of every vertex (n, 3)."""
    normals = topology.vertex_normals(*topology.arrays(scene.mesh))
    lost = np.flatnonzero(~normals.any(axis=1))
    if lost.size:
        raise MeshError(
            f"vertex {lost[0]} belongs to no triangle with an area ({lost.size} such "
            "vertices); clean the mesh first: skinviz clean"
        )
    return normals


def light_spectra(scene: Scene) -> Array:
    """Return E(λ) of each light (lights, n): radiance of the lit perfect diffuser.

    Scaled so that Σ E ȳ Δλ of the first light is the exposure.
    """
    cmfs = colour_matching_functions(scene.wavelengths, scene.observer)
    seen = cmfs[:, 1] * band_widths(scene.wavelengths)

    def unit_luminance(light: DirectionalLight) -> Array:
        spd = illuminant_spd(light.illuminant, scene.wavelengths)
        xyz_weights(scene.wavelengths, spd, scene.observer)  # refuses unseen light
        return np.asarray(spd / (spd @ seen))

    first = scene.lights[0].strength
    return np.array(
        [
            scene.exposure * (light.strength / first) * unit_luminance(light)
            for light in scene.lights
        ]
    )


def vertex_spectrum(scene: Scene, vertex: int) -> VertexSpectrum:
    """Return the radiance of one vertex, split into diffuse and specular.

    Parameters
    ----------
    scene : Scene
        What is lit and seen.
    vertex : int
        Index into the mesh's points.

    Returns
    -------
    spectrum : VertexSpectrum
        In the units of :func:`shade`.

    Raises
    ------
    ArgumentError
        If the mesh has no such vertex.
    """
    in_range(vertex, 0, scene.mesh.n_points - 1, "vertex")
    if vertex != int(vertex):
        raise ArgumentError(f"vertex must be a whole number; got {vertex}")
    vertex = int(vertex)
    diffuse, specular = geometry_terms(scene)
    values = scene.skin.values
    own = values if values.ndim == 1 else values[vertex]
    body = scene.skin.model.diffuse(own, scene.wavelengths)
    powers = light_spectra(scene)
    return VertexSpectrum(
        scene.wavelengths,
        (diffuse[:, vertex] @ powers) * body,
        specular[:, vertex] @ powers,
        powers[0],
    )


def _radiance(
    diffuse: Array, specular: Array, body: Array, powers: Array
) -> NDArray[np.float32]:
    """Return the radiance of every vertex and band (n, bands)."""
    peak = max(diffuse.max(), specular.max()) * powers.sum(axis=0).max()
    if peak > np.finfo(np.float32).max:
        raise ArgumentError(
            f"radiance reaches {peak:.3g}, more than float32 holds; lower the exposure "
            "or the lights' strength"
        )
    # One product with few inner terms: bands are formed once, in float32.
    scalars = np.concatenate([diffuse, specular]).T.astype(np.float32)
    if body.ndim == 1:
        spectra = np.concatenate([powers * body, powers]).astype(np.float32)
        return np.asarray(scalars @ spectra)
    lit = (diffuse.T @ powers) * body
    return np.asarray(lit + specular.T @ powers, dtype=np.float32)


def _xyz_of_radiance(scene: Scene) -> Array:
    """Return the weights (n, 3) by which radiance becomes XYZ."""
    cmfs = colour_matching_functions(scene.wavelengths, scene.observer)
    return np.asarray(cmfs * band_widths(scene.wavelengths)[:, None])
