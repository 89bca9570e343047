"""Eq. (10) at every vertex: spectral radiance and its colour.

Radiance is a sum of products of a scalar that depends on geometry alone and a
spectrum that depends on skin and light alone, so colours need no spectra per vertex:
each product's XYZ is the scalar times the XYZ of its spectrum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import even_size, in_slices
from skinviz._validate import in_range
from skinviz.errors import ArgumentError, MeshError
from skinviz.rendering import trace
from skinviz.rendering.colour import display_matrix
from skinviz.rendering.expansion import as_single, expand_mapped, require_single
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.lighting import light_spectra
from skinviz.rendering.plan import Plan
from skinviz.rendering.stage import Stage, stage_of
from skinviz.scan.formats.surface import UNIT_FIELD
from skinviz.scene.scene import Scene
from skinviz.spectra.display import DisplayCounts

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
Single = NDArray[np.float32]

_SLICE = 2**16  # vertices that a thread shades in one go


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


def shade(
    scene: Scene, plan: Plan | None = None, *, geometry: Geometry | None = None
) -> pyvista.PolyData:
    """Compute spectral radiance and colour at every vertex.

    Parameters
    ----------
    scene : Scene
        What is lit and seen.
    plan : Plan, optional
        Whether with cast shadows (by default) or without, and how finely light
        between parts is gathered. Its samples do not matter here.
    geometry : Geometry, optional
        Of the scene's mesh, where it is at hand.

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
    camera cannot see.
    """
    stage = stage_of(scene, plan, geometry)
    radiance = vertex_radiance(stage)
    rgb, counts = vertex_rgb(stage)
    mesh = scene.mesh.copy(deep=False)
    mesh.point_data["pigments"] = np.broadcast_to(
        scene.skin.values, (mesh.n_points, scene.skin.values.shape[-1])
    )
    mesh.point_data["radiance"] = radiance
    mesh.point_data["rgb"] = rgb
    mesh.field_data["wavelengths"] = scene.wavelengths
    mesh.field_data["facing"] = [counts.total]
    mesh.field_data["over_exposed"] = [counts.over_exposed]
    mesh.field_data["out_of_gamut"] = [counts.out_of_gamut]
    mesh.field_data[UNIT_FIELD] = ["mm"]
    return mesh


def vertex_radiance(stage: Stage, out: Single | None = None) -> Single:
    """Return the spectral radiance of every vertex (n, bands).

    Parameters
    ----------
    stage : Stage
        From :func:`stage_of`.
    out : (n, bands) ndarray of float32, optional
        Where to write it.
    """
    spectra = stage.spectra
    if out is None:
        out = np.zeros((len(stage.geometry.points), len(spectra.colour)), np.float32)
    matrix = as_single(spectra.products(stage.fields.spectra))

    if spectra.body is None:
        _each_slice(
            stage,
            lambda part, visible: _expand_mapped(
                stage, part, _scalars(stage, part, visible), out[part]
            ),
        )
        return out

    def use(part: slice, visible: NDArray[np.uint8] | None) -> None:
        peaks = stage.lighting.expand(
            stage.geometry,
            part,
            visible=visible,
            fields=stage.fields.values,
            spectra=matrix,
            out=out,
        )
        require_single(peaks[:, None], matrix)

    _each_slice(stage, use)
    return out


def vertex_xyz(stage: Stage) -> Array:
    """Return XYZ of every vertex (n, 3); no spectra are formed of uniform skin."""
    spectra = stage.spectra
    xyz = np.zeros((len(stage.geometry.points), 3))
    matrix = spectra.products(stage.fields.spectra) @ spectra.colour

    def use(part: slice, visible: NDArray[np.uint8] | None) -> None:
        scalars = _scalars(stage, part, visible)
        if spectra.body is not None:
            xyz[part] = scalars.T @ matrix
            return
        radiance = np.zeros((scalars.shape[1], len(spectra.colour)))
        _expand_mapped(stage, part, scalars, radiance)
        xyz[part] = radiance @ spectra.colour

    _each_slice(stage, use)
    return xyz


def vertex_rgb(stage: Stage) -> tuple[NDArray[np.uint8], DisplayCounts]:
    """Return what the scene's display shows of every vertex (n, 3), and the counts.

    Counted are the vertices that face the viewer: the others have no true specular
    term and are not seen. This is the quick way to colours, for a light that moves
    (:meth:`Stage.relit`): nothing is computed by wavelength or kept by vertex.
    """
    spectra, scene, display = stage.spectra, stage.scene, stage.scene.display
    if spectra.body is None:
        linear = vertex_xyz(stage) @ display_matrix(scene).T
        return display.encode8(linear, stage.sight.facing)
    rgb = np.zeros((len(stage.geometry.points), 3), np.uint8)
    matrix = spectra.products(stage.fields.spectra) @ spectra.colour
    matrix = matrix @ display_matrix(scene).T
    seen, told = stage.sight.facing, []

    def use(part: slice, visible: NDArray[np.uint8] | None) -> None:
        scalars = _scalars(stage, part, visible)
        rgb[part], counts = display.encode8(scalars.T @ matrix, seen[part])
        told.append(counts)

    _each_slice(stage, use)
    return rgb, sum(told, DisplayCounts(0, 0, 0))


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
        In the units of :func:`shade`, which it adds up to.

    Raises
    ------
    ArgumentError
        If the mesh has no such vertex.
    """
    in_range(vertex, 0, scene.mesh.n_points - 1, "vertex")
    if vertex != int(vertex):
        raise ArgumentError(f"vertex must be a whole number; got {vertex}")
    stage, vertex = stage_of(scene), int(vertex)
    scalars = _scalars(stage, slice(vertex, vertex + 1), _visible(stage))[:, 0]
    spectra, n_lights = stage.spectra, len(stage.lighting.lights)
    values = scene.skin.values
    own = values if values.ndim == 1 else values[vertex]
    body = scene.skin.model.diffuse(own, scene.wavelengths)
    rows = stage.lighting.rows
    lit = scalars[:n_lights] @ spectra.light + scalars[rows:] @ stage.fields.spectra
    return VertexSpectrum(
        scene.wavelengths,
        np.maximum(lit, 0) * body,
        scalars[n_lights:rows] @ spectra.shine,
        light_spectra(scene)[0],
    )


def vertex_gloss(scene: Scene) -> Array:
    """Return each vertex's specular light of the light that gives it most (n,).

    In units of the perfect diffuser that faces this light. [1]
    """
    stage = stage_of(scene)
    n_lights, rows = len(stage.lighting.lights), stage.lighting.rows
    gloss = np.zeros(len(stage.geometry.points))

    def use(part: slice, visible: NDArray[np.uint8] | None) -> None:
        scalars = _scalars(stage, part, visible)
        gloss[part] = scalars[n_lights:rows].max(axis=0)

    _each_slice(stage, use)
    return gloss


def _each_slice(
    stage: Stage, use: Callable[[slice, NDArray[np.uint8] | None], None]
) -> None:
    """Call ``use`` on slices of the vertices, with the lights that each one sees."""
    lost = stage.geometry.lost
    if lost.size:
        raise MeshError(
            f"vertex {lost[0]} belongs to no triangle with an area ({lost.size} such "
            "vertices); clean the mesh first: skinviz clean"
        )
    visible = _visible(stage)
    n = len(stage.geometry.points)
    in_slices(lambda part: use(part, visible), n, even_size(n, _SLICE))


def _visible(stage: Stage) -> NDArray[np.uint8] | None:
    """Return which lights the vertices see; None: all."""
    if not stage.plan.shadows:
        return None
    return trace.vertex_visibility(stage.geometry, stage.lighting)


def _scalars(stage: Stage, part: slice, visible: NDArray[np.uint8] | None) -> Array:
    """Return the scalars (rows + e, m) of some vertices."""
    lighting, fields = stage.lighting, stage.fields
    out = np.zeros((lighting.rows + len(fields.spectra), part.stop - part.start))
    seen = None if visible is None else np.ascontiguousarray(visible[:, part])
    points, normals = stage.geometry.components
    lighting.scalars(points, normals, out, part.start, seen)
    out[lighting.rows :] = fields.values[part].T
    return out


def _expand_mapped(
    stage: Stage, part: slice, scalars: Array, out: NDArray[np.floating]
) -> None:
    """Write the radiance of vertices that each have their own pigments."""
    scene = stage.scene
    body = scene.skin.model.diffuse(scene.skin.values[part], scene.wavelengths)
    rows = np.arange(len(body))
    expand_mapped(stage, scalars, body, rows=rows, samples=1, out=out)
