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

_TYPICAL = 220.0  # mm across, corner to corner of the box around a hand
_MISREAD = {
    1000.0: ("metres", "millimetres"),
    25.4: ("inches", "millimetres"),
    100.0: ("metres", "centimetres"),
    10.0: ("centimetres", "millimetres"),
    2.54: ("inches", "centimetres"),
    0.1: ("millimetres", "centimetres"),
    1 / 25.4: ("millimetres", "inches"),
    0.01: ("centimetres", "metres"),
    1e-3: ("millimetres", "metres"),
    1e-6: ("micrometres", "metres"),
    1e6: ("metres", "micrometres"),
}
"""Factor by which lengths came out too small, and the units that were mistaken."""

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
    return require_finite(points, source), faces


def require_finite(points: Points, source: str) -> Points:
    """Return points (..., 3) or say which is no place at all."""
    finite = np.isfinite(points).reshape(-1, 3).all(axis=1)
    bad = np.flatnonzero(~finite)
    if bad.size:
        raise MeshError(
            f"{source}: point {bad[0]} is not finite ({bad.size} in all); remove "
            "such points in the program that wrote the file"
        )
    return points


def require_coordinates(points: Points, source: str) -> Points:
    """Return points (..., 3) or say which is no place that a scanner sees."""
    require_finite(points, source)
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
    told = wrong_size(points)
    if told is not None:
        raise MeshError(f"{source} {told}; give the file's true unit (--unit)")


def wrong_size(points: Points) -> str | None:
    """Return why points cannot be a hand's, and what the unit may be; else None."""
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    low, high = _ACCEPTED
    if low <= size <= high:
        return None
    told = (
        f"is {size:.4g} mm across, and a hand is {HAND_LENGTH[0]:g} to "
        f"{HAND_LENGTH[1]:g} mm long"
    )
    near = [ratio for ratio in _MISREAD if low <= size * ratio <= high]
    if not near:
        return told
    likely = min(near, key=lambda ratio: abs(np.log(size * ratio / _TYPICAL)))
    true, taken = _MISREAD[likely]
    return f"{told}: it looks as if {true} were read as {taken}"
