"""Eq. (10) at every vertex: spectral radiance and its colour.

Radiance is a sum of products of a scalar that depends on geometry alone and a
spectrum that depends on skin and light alone, so colours need no spectra per vertex:
each product's XYZ is the scalar times the XYZ of its spectrum.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.errors import ArgumentError, MeshError
from skinviz.rendering.colour import display_matrix
from skinviz.rendering.expansion import as_single, expand_mapped, require_single
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.lighting import body_at
from skinviz.rendering.plan import Plan
from skinviz.rendering.spectral import light_spectra
from skinviz.rendering.stage import Lit, Stage, stage_of
from skinviz.rendering.tints import vertex_pigments
from skinviz.rendering.vertices import (
    Visible,
    each_slice,
    seen_lights,
    vertex_scalars,
    vertex_xyz,
)
from skinviz.scan.formats.surface import UNIT_FIELD
from skinviz.scene.scene import Scene
from skinviz.spectra.display import DisplayCounts

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
Single = NDArray[np.float32]


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
        The reference by default. Its samples do not matter here.
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
    stage = stage_of(scene, plan, geometry, whole=True)
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
    lit = stage.bands
    _require_normals(stage)
    if out is None:
        shape = (len(stage.geometry.points), len(lit.spectra.colour))
        out = np.zeros(shape, np.float32)
    matrix = as_single(lit.spectra.products(lit.fields.spectra))
    values = vertex_pigments(stage.scene)

    def use_mapped(part: slice, visible: Visible) -> None:
        scalars = vertex_scalars(stage, lit, part, visible)
        body = body_at(stage.scene, values[part], lit.spectra.wavelengths)
        rows = np.arange(len(body))
        expand_mapped(lit, scalars, body, rows=rows, samples=1, out=out[part])

    def use(part: slice, visible: Visible) -> None:
        peaks = lit.lighting.expand(
            stage.geometry,
            part,
            visible=visible,
            fields=lit.fields.values,
            spectra=matrix,
            out=out,
        )
        require_single(peaks[:, None], matrix)

    each_slice(stage, lit, use_mapped if lit.spectra.body is None else use)
    return out


def vertex_rgb(stage: Stage) -> tuple[NDArray[np.uint8], DisplayCounts]:
    """Return what the scene's display shows of every vertex (n, 3), and the counts.

    Counted are the vertices that face the viewer: the others have no true specular
    term and are not seen. This is the quick way to colours, for a light that moves
    (:meth:`Stage.relit`): nothing is computed by wavelength or kept by vertex.
    """
    lit, display = stage.colours, stage.scene.display
    _require_normals(stage)
    if lit.spectra.body is None:
        linear = vertex_xyz(stage) @ display_matrix(stage.scene).T
        return display.encode8(linear, stage.sight.facing)
    rgb = np.zeros((len(stage.geometry.points), 3), np.uint8)
    matrix = lit.matrix @ display_matrix(stage.scene).T
    seen, told = stage.sight.facing, []

    def use(part: slice, visible: Visible) -> None:
        scalars = vertex_scalars(stage, lit, part, visible)
        rgb[part], counts = display.encode8(scalars.T @ matrix, seen[part])
        told.append(counts)

    each_slice(stage, lit, use)
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
    vertex = int(vertex)
    stage = stage_of(scene, whole=True)
    lit = stage.bands
    part = slice(vertex, vertex + 1)
    scalars = vertex_scalars(stage, lit, part, seen_lights(stage, lit))[:, 0]
    return parted(scene, lit, scalars, vertex_pigments(scene)[vertex])


def parted(scene: Scene, lit: Lit, scalars: Array, pigments: Array) -> VertexSpectrum:
    """Return the radiance of one point in its parts.

    Parameters
    ----------
    scene : Scene
        What is lit and seen.
    lit : Lit
        Its light at its own wavelengths.
    scalars : (rows + e,) ndarray
        Of the point.
    pigments : (p,) ndarray
        There.
    """
    n_lights = len(lit.spectra.light)
    diffuse = (
        scalars[:n_lights] @ lit.spectra.light
        + scalars[lit.rows :] @ lit.fields.spectra
    )
    return VertexSpectrum(
        scene.wavelengths,
        np.maximum(diffuse, 0) * body_at(scene, pigments, scene.wavelengths),
        scalars[n_lights : lit.rows] @ lit.spectra.shine,
        light_spectra(scene)[0],
    )


def vertex_gloss(scene: Scene) -> Array:
    """Return each vertex's specular light of the light that gives it most (n,).

    In units of the perfect diffuser that faces this light. [1]
    """
    stage = stage_of(scene)
    lit = stage.bands
    n_lights, gloss = len(lit.spectra.light), np.zeros(len(stage.geometry.points))
    _require_normals(stage)

    def use(part: slice, visible: Visible) -> None:
        scalars = vertex_scalars(stage, lit, part, visible)
        gloss[part] = scalars[n_lights : lit.rows].max(axis=0)

    each_slice(stage, lit, use)
    return gloss


def _require_normals(stage: Stage) -> None:
    """Refuse a mesh with vertices that have no normal."""
    lost = stage.geometry.lost
    if lost.size:
        raise MeshError(
            f"vertex {lost[0]} belongs to no triangle with an area ({lost.size} such "
            "vertices); clean the mesh first: skinviz clean"
        )
