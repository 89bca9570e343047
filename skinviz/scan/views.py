"""From one range view to a trustworthy patch of triangles, noise smoothed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.grid import (
    rays_towards,
    relative_noise,
    smoothing_rounds,
    triangulate,
)
from skinviz.scan.partners import Patch
from skinviz.scan.scan import RangeView
from skinviz.scan.smoothing import smoothed
from skinviz.scan.topology import Faces, Points

# Beyond it, noise along the ray moves a point along the surface, which on a curved
# one is no longer noise about zero.
_STEADY = np.cos(np.deg2rad(60))


@dataclass(frozen=True)
class PatchCounts:
    """What was found and dropped in making one view's patch."""

    returns: int
    bridges: int
    island_faces: int
    rim_faces: int
    faces: int


def drop_islands(n_points: int, faces: Faces, min_faces: int) -> Faces:
    """Drop connected pieces of fewer than ``min_faces`` triangles."""
    if len(faces) == 0:
        return faces
    labels = topology.face_components(n_points, faces)
    return faces[np.bincount(labels)[labels] >= min_faces]


def erode_rim(faces: Faces, rings: int) -> Faces:
    """Drop the triangles that touch the boundary, as often as told."""
    for _ in range(rings):
        rim = np.unique(topology.boundary_edges(faces))
        faces = faces[~np.isin(faces, rim).any(axis=1)]
    return faces


def view_surface(
    view: RangeView,
    *,
    max_incidence: float = np.deg2rad(75),
    max_stretch: float = np.inf,
    min_island: int = 200,
    rim_rings: int = 1,
) -> tuple[Points, Faces, PatchCounts]:
    """Turn a range view into triangles without bridges, islands or rim.

    Parameters
    ----------
    view : RangeView
        The grid.
    max_incidence : float
        Angle beyond which a triangle counts as a bridge. [rad]
    max_stretch : float
        Triangles with a longer edge, in median steps of the grid, are bridges too.
    min_island : int
        Pieces of fewer triangles are outliers.
    rim_rings : int
        Rings of triangles taken off the boundary, where spikes live.

    Returns
    -------
    points, faces : (n, 3), (m, 3) ndarray
        Returns in the sensor's frame, noise and all, and their triangles.
    counts : PatchCounts
        What was dropped.

    Raises
    ------
    MeshError
        If nothing is left.
    """
    points, all_faces, bridges = triangulate(
        view.points, max_incidence, view.eye, max_stretch
    )
    kept = drop_islands(len(points), all_faces, min_island)
    inner = drop_islands(len(points), erode_rim(kept, rim_rings), min_island)
    if len(inner) == 0:
        raise MeshError(
            f"view {view.name!r} has no surface left: {len(points)} returns gave "
            f"{len(all_faces)} triangles, none in a piece of {min_island} or more; "
            "check that it is a range grid of the object, or leave it out"
        )
    counts = PatchCounts(
        returns=int(view.valid.sum()),
        bridges=bridges,
        island_faces=len(all_faces) - len(kept),
        rim_faces=len(kept) - len(inner),
        faces=len(inner),
    )
    return *topology.compact(points, inner), counts


def make_patch(view: RangeView, points: Points, faces: Faces) -> Patch:
    """Return a view's surface as samples for alignment and merging.

    Its points are smoothed as far as the noise of the view asks for, and never
    across a bridge; those on the rim and seen at more than 60° are no partners.
    """
    rounds = smoothing_rounds(relative_noise(view.points, view.eye))
    smooth = smoothed(points, faces, rounds)
    normals = topology.vertex_normals(smooth, faces)
    rays = rays_towards(smooth, view.eye)
    steady = np.einsum("ij,ij->i", normals, rays) > _STEADY
    steady[np.unique(topology.boundary_edges(faces))] = False
    return Patch(view.name, smooth, normals, steady)
