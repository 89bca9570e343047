"""Refusals that scans and meshes meet before any work is done on them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.topology import Faces, Points

if TYPE_CHECKING:
    import pyvista

HAND_LENGTH = (140.0, 230.0)
"""Wrist to fingertip of adults, from the 1st to the 99th percentile. [mm]"""

_FARTHEST = 1e12  # mm; map coordinates on earth are below 1e11

_ACCEPTED = (80.0, 600.0)  # a child's hand; an adult's with the forearm


def require_triangles(mesh: pyvista.PolyData, source: str) -> tuple[Points, Faces]:
    """Return a mesh's arrays, or say what makes it no triangle mesh."""
    if mesh.n_points == 0:
        raise MeshError(f"{source} has no points; check that it is a mesh file")
    if mesh.n_cells == 0 or not mesh.is_all_triangles:
        triangles = mesh.triangulate()
        if triangles.n_cells == 0 or triangles.n_verts:
            raise MeshError(
                f"{source} has {mesh.n_points} points but no faces; a mesh with "
                "faces or a range grid is needed"
            )
        mesh = triangles
    points, faces = topology.arrays(mesh)
    if faces.min() < 0 or faces.max() >= len(points):
        raise MeshError(
            f"{source}: a face names point {faces.max()} of {len(points)}; the file is "
            "broken"
        )
    return require_coordinates(points, source), faces


def require_coordinates(points: Points, source: str) -> Points:
    """Return points (..., 3) or say which is no place that a scanner sees."""
    finite = np.isfinite(points).reshape(-1, 3).all(axis=1)
    bad = np.flatnonzero(~finite)
    if bad.size:
        raise MeshError(
            f"{source}: point {bad[0]} is not finite ({bad.size} in all); remove "
            "such points in the program that wrote the file"
        )
    far = np.flatnonzero((np.abs(points) > _FARTHEST).reshape(-1, 3).any(axis=1))
    if far.size:
        raise MeshError(
            f"{source}: point {far[0]} lies more than {_FARTHEST:g} mm away "
            f"({far.size} in all); the file is broken or its unit is another"
        )
    return points


def to_millimetres(points: Points, scale: float, source: str) -> Points:
    """Return points (..., 3) scaled, or say which is no place that a scanner sees."""
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused
        placed = np.multiply(points, scale, dtype=np.float64)
    return require_coordinates(placed, source)


def require_hand_size(points: Points, source: str) -> None:
    """Refuse what cannot be a hand: most often the unit is wrong."""
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    low, high = _ACCEPTED
    if not low <= size <= high:
        raise MeshError(
            f"{source} is {size:.4g} mm across, and a hand is {HAND_LENGTH[0]:g} to "
            f"{HAND_LENGTH[1]:g} mm long; give the file's true unit (--unit)"
        )
