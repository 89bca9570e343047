"""A mesh made ready for shading and for rays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.rendering.outlines import edges_of
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

# Of its longest edge, below which a triangle's area is the rounding of coordinates.
_ROUNDING = 8 * np.finfo(np.float64).eps


@dataclass(frozen=True, eq=False, repr=False)
class Geometry:
    """Triangles with smooth normals, in coordinates that float32 rays can bear.

    A point p of the mesh is at (p − centre)/scale, within −1 to 1 on each axis, so
    that neither the mesh's size nor its place shows in the rays' rounding.

    Attributes
    ----------
    points : (n, 3) ndarray
        Vertices, in these coordinates; those without a triangle are at another's. [1]
    faces : (m, 3) ndarray of int32
        Corners of the triangles.
    normals : (n, 3) ndarray
        Unit normals of the vertices, area-weighted; zero where there is none.
    centre : (3,) ndarray
        Middle of the mesh's box. [mm]
    scale : float
        Half the box's longest side. [mm]
    centroid : (3,) ndarray
        Mean of the surface, in these coordinates.
    """

    points: Array
    faces: NDArray[np.int32]
    normals: Array
    centre: Array
    scale: float
    centroid: Array

    def __repr__(self) -> str:
        """Say how large it is."""
        return f"Geometry({len(self.points)} vertices, {len(self.faces)} triangles)"

    @cached_property
    def embree(self) -> Any:
        """Embree's tree of the triangles, built when a first ray needs it."""
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        scene = EmbreeScene(robust=True)
        TriangleMesh(scene, self.points.astype(np.float32), self.faces)
        return scene

    @cached_property
    def lost(self) -> NDArray[np.int64]:
        """The vertices that belong to no triangle with an area: without a normal."""
        return np.flatnonzero(~self.normals.any(axis=1))

    @cached_property
    def in_mm(self) -> Array:
        """The vertices (n, 3) in the mesh's own coordinates. [mm]"""
        return self.centre + self.scale * self.points

    @cached_property
    def edges(self) -> NDArray[np.int32]:
        """The edges (k, 4): two vertices, and the triangles on both sides or -1."""
        return edges_of(self.faces, len(self.points))

    @cached_property
    def components(self) -> tuple[Array, Array]:
        """Points and normals as (3, n), for loops that read them a component a row."""
        return np.ascontiguousarray(self.points.T), np.ascontiguousarray(self.normals.T)

    def within(self, homogeneous: Array) -> Array:
        """Return a point (4,) of the mesh's space [mm], or at infinity, in these."""
        x = np.array(homogeneous, dtype=np.float64)
        x[:3] = (x[:3] - x[3] * self.centre) / (self.scale if x[3] else 1.0)
        return x

    def winding(self, point: Array) -> float:
        """Return how often the surface goes round a point: 1 inside, 0 outside.

        References
        ----------
        .. [1] A. Van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30:125 (1983).
        """
        a, b, c = (self.points[self.faces[:, k]] - point for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        spread = (
            la * lb * lc
            + np.einsum("ij,ij->i", a, b) * lc
            + np.einsum("ij,ij->i", b, c) * la
            + np.einsum("ij,ij->i", c, a) * lb
        )
        return float(np.arctan2(volume, spread).sum() / (2 * np.pi))


def geometry_of(mesh: pyvista.PolyData) -> Geometry:
    """Prepare a mesh of triangles.

    Parameters
    ----------
    mesh : pyvista.PolyData
        [mm]

    Returns
    -------
    geometry : Geometry
        To be passed to several calls that show one mesh.

    Raises
    ------
    MeshError
        If the mesh is empty, has vertices that are not finite, or no area.
    """
    points, faces = require_triangles(mesh, "the scene's mesh")
    points = _without_strays(points, faces)
    low, high = points.min(axis=0), points.max(axis=0)
    centre, scale = low / 2 + high / 2, float((high - low).max() / 2)
    if not 0 < scale < np.inf:
        raise MeshError(
            "the scene's mesh has no extent; check its unit and its vertices"
        )
    inside = (points - centre) / scale
    area = topology.face_areas(inside, faces)
    flat = area <= _ROUNDING * _longest_edges(inside, faces)
    area[flat] = 0.0
    if area.sum() == 0:
        raise MeshError("no triangle of the scene's mesh has an area; clean it first")
    return Geometry(
        points=inside,
        faces=np.ascontiguousarray(faces, dtype=np.int32),
        normals=topology.vertex_normals(inside, faces[~flat]),
        centre=centre,
        scale=scale,
        centroid=np.average(inside[faces].mean(axis=1), axis=0, weights=area),
    )


def _longest_edges(points: Array, faces: NDArray[np.int64]) -> Array:
    """Return the length of each triangle's longest edge (m,)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    edges = np.stack([b - a, c - b, a - c])
    return np.asarray(np.linalg.norm(edges, axis=2).max(axis=0))


def _without_strays(points: Array, faces: NDArray[np.int64]) -> Array:
    """Return the points, with those that no triangle has put where one is.

    They are not seen, and may be anywhere: no camera is aimed at them.
    """
    stray = np.ones(len(points), dtype=bool)
    stray[faces] = False
    if stray.any():
        points = np.where(stray[:, None], points[faces[0, 0]], points)
    return points
