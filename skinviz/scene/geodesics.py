"""Distances along a surface, and what is near what on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

_SMALLEST = 1e-12  # of a box's area: below it, a triangle is a line to the solver


@dataclass(frozen=True, eq=False, repr=False)
class Surface:
    """Triangles on which distances are asked for, one piece or several.

    Attributes
    ----------
    points : (n, 3) ndarray
        [mm]
    faces : (m, 3) ndarray of int64
        Corners of the triangles that have an area.
    """

    points: Array
    faces: Whole

    @cached_property
    def pieces(self) -> Whole:
        """Which connected piece each vertex (n,) is on; alone where it has no face."""
        edges = self.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
        return topology.components(len(self.points), edges)

    @cached_property
    def normals(self) -> Array:
        """Unit normals of the vertices (n, 3)."""
        return topology.vertex_normals(self.points, self.faces)

    @cached_property
    def laplacian(self) -> Any:
        """The cotangent Laplacian (n, n), sparse, positive semidefinite. [1]"""
        from potpourri3d import cotan_laplacian

        return cotan_laplacian(self.points, self.faces, denom_eps=1e-10)

    @cached_property
    def areas(self) -> Array:
        """A third of the area of the triangles round each vertex (n,). [mm²]"""
        from potpourri3d import vertex_areas

        return np.asarray(vertex_areas(self.points, self.faces), dtype=np.float64)

    def nearest_of(self, which: Whole, places: Array) -> tuple[Array, Whole]:
        """Return how far the next of some vertices is from places (k, 3), and which.

        As the crow flies. [mm]
        """
        from scipy.spatial import KDTree

        distance, at = KDTree(self.points[which]).query(places)
        return np.asarray(distance), np.asarray(which[at])

    def distances(self, sources: Sequence[int] | Whole) -> Array:
        """Return the distance along the surface from each source vertex (k, n). [mm]

        By the heat method [1]_. It is infinite on pieces that the source is not on.

        References
        ----------
        .. [1] K. Crane, C. Weischedel and M. Wardetzky, ACM Trans. Graph. 32:152
           (2013); N. Sharp and K. Crane, Computer Graphics Forum 39:69 (2020).
        """
        found = np.full((len(sources), len(self.points)), np.inf)
        for row, source in zip(found, sources, strict=True):
            row[:] = self.distance_to([int(source)])
            row[source] = 0.0
        return found

    def distance_to(self, sources: Sequence[int] | Whole) -> Array:
        """Return the distance (n,) to the nearest of some vertices. [mm]"""
        found = np.full(len(self.points), np.inf)
        sources = np.asarray(sources, dtype=np.int64)
        for piece in np.unique(self.pieces[sources]):
            own = sources[self.pieces[sources] == piece]
            solver, used, place = self._piece(int(piece))
            if solver is None:  # a vertex without a face
                found[own] = 0.0
                continue
            distance = solver.compute_distance_multisource(place[own].tolist())
            if not np.isfinite(distance).all():
                raise MeshError(
                    "distances along the mesh cannot be told, its triangles are too "
                    "thin; clean it first: skinviz clean"
                )
            found[used] = np.maximum(distance, 0.0)
        return found

    def _piece(self, piece: int) -> tuple[Any, Whole, Whole]:
        """Return a piece's solver, its vertices (k,), and the places of all (n,)."""
        if piece not in self._solvers:
            from potpourri3d import MeshHeatMethodDistanceSolver

            own = self.faces[self.pieces[self.faces[:, 0]] == piece]
            used = np.unique(own)
            place = np.full(len(self.points), -1)
            place[used] = np.arange(used.size)
            solver = None
            if used.size:
                solver = MeshHeatMethodDistanceSolver(self.points[used], place[own])
            self._solvers[piece] = (solver, used, place)
        return self._solvers[piece]

    @cached_property
    def _solvers(self) -> dict[int, tuple[Any, Whole, Whole]]:
        """Solvers made so far, by pieces."""
        return {}


def surface_of(mesh: pyvista.PolyData) -> Surface:
    """Return a mesh's surface, without the triangles that have no area.

    Raises
    ------
    MeshError
        If it has no triangle.
    """
    points, faces = require_triangles(mesh, "the mesh")
    area = topology.face_areas(points, faces)
    box = float(np.square(np.ptp(points, axis=0)).sum())
    return Surface(points, faces[area > _SMALLEST * box])
