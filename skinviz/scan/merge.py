"""One closed surface from many aligned patches, and where it has no evidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.scan import topology
from skinviz.scan.meshlab import NO_LIMITS, Filter, Limits, run_filters
from skinviz.scan.topology import Faces, Points

_BOXES = (1.1, 1.6, 2.2)  # sides of the octree in the points' extent, tried in turn

_NEARLY_ALL = 0.99  # of a surface's faces: the rest are crumbs


@dataclass(frozen=True)
class Merged:
    """A merged surface and which of its points measurements support."""

    points: Points
    faces: Faces
    supported: NDArray[np.bool_]


def merge_points(
    points: Points,
    normals: NDArray[np.float64],
    *,
    cell: float,
    support: float,
    limits: Limits = NO_LIMITS,
) -> Merged:
    """Merge oriented points into one closed surface by screened Poisson.

    Parameters
    ----------
    points, normals : (n, 3) ndarray
        All patches' points [mm] and unit normals in one frame.
    cell : float
        Largest cell of the octree where the points are dense enough for it. [mm]
    support : float
        A surface point farther than this from every measured point is
        unsupported. [mm]
    limits : Limits
        What the worker may take.

    Returns
    -------
    merged : Merged
        A closed surface: holes are filled smoothly and marked unsupported.

    References
    ----------
    .. [1] M. Kazhdan and H. Hoppe, ACM Trans. Graph. 32(3):29 (2013).
    """
    from scipy.spatial import cKDTree

    no_faces = np.zeros((0, 3), dtype=np.int64)
    for scale in _BOXES:
        side = scale * float(np.ptp(points, axis=0).max())
        depth = int(np.clip(np.ceil(np.log2(side / cell)), 5, 11))
        poisson = Filter(
            "generate_surface_reconstruction_screened_poisson",
            {"depth": depth, "scale": scale, "preclean": True},
        )
        result = run_filters(
            points, no_faces, [poisson], normals=normals, limits=limits
        )
        # A cap that bulges out of the box is cut off by it: its edge is no wrist.
        if not topology.boundary_edges(result.faces).size:
            break
    distance, _ = cKDTree(points).query(result.points, workers=-1)
    faces = topology.largest_piece(len(result.points), result.faces)
    return Merged(result.points, faces, np.asarray(distance <= support))


def unsupported_regions(merged: Merged) -> list[NDArray[np.int64]]:
    """Return the faces of each connected region without evidence, largest first."""
    bare = np.flatnonzero(~merged.supported[merged.faces].any(axis=1))
    if bare.size == 0:
        return []
    labels = topology.face_components(len(merged.points), merged.faces[bare])
    area = topology.face_areas(merged.points, merged.faces[bare])
    order = np.argsort(-np.bincount(labels, area))
    return [bare[labels == label] for label in order]


def cut_bridges(merged: Merged, largest: float) -> tuple[Merged, int]:
    """Remove regions without evidence that join the surface to itself.

    Two fingers that grew together are joined by a bridge that no point supports:
    it has an outline at either end, and without it the hand is still in one piece.

    Parameters
    ----------
    merged : Merged
        A closed surface.
    largest : float
        Area of the smallest region that may be the wrist's cap, which stays. [mm²]

    Returns
    -------
    merged : Merged
        With two holes in place of each bridge.
    n_bridges : int
        How many were removed.
    """
    n, faces = len(merged.points), merged.faces
    cut = np.zeros(len(faces), dtype=bool)
    n_bridges = 0
    for i, region in enumerate(unsupported_regions(merged)):
        area = topology.face_areas(merged.points, faces[region]).sum()
        if i == 0 and area >= largest:
            continue
        trial = cut.copy()
        trial[region] = True
        two_ends = len(topology.boundary_loops(faces[region])) > 1
        if two_ends and _in_one_piece(n, faces[~trial]):
            cut, n_bridges = trial, n_bridges + 1
    return Merged(merged.points, faces[~cut], merged.supported), n_bridges


def _in_one_piece(n_points: int, faces: Faces) -> bool:
    """Return whether all faces but crumbs hang together."""
    return len(topology.largest_piece(n_points, faces)) > _NEARLY_ALL * len(faces)
