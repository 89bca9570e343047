"""Closing holes of a hand, but neither its wrist nor the gap between two fingers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.scan import topology
from skinviz.scan.meshlab import Filter, Limits, run_filters
from skinviz.scan.topology import FaceMask, Faces, Points
from skinviz.scan.workpiece import Counts, Surface
from skinviz.scan.wrist import wrist_loop

_FACING = 0.5  # cosine: two sides of a gap look at each other within 60 degrees
_WAY_AROUND = 4.0  # times the gap: so far it is on the surface between two fingers
_TOUCHING = 2.0  # mm: what is as near is no gap between fingers
_MOST_TRIED = 24  # edges of a fill


def close_holes(
    surface: Surface, limits: Limits, *, max_width: float, cap_wrist: float = False
) -> tuple[Surface, Counts]:
    """Close holes; the widest opening, the wrist, only where that is asked for.

    A hole stays open if it is wider than ``max_width``, or if what closes it would
    join two fingers: its ends are far from each other along the surface, and look at
    each other across a gap or are farther than any way around a hole that is closed.
    """
    points, faces = surface.points, surface.faces
    loops = topology.boundary_loops(faces)
    wrist = wrist_loop(points, faces)
    chosen = [
        bool(cap_wrist)
        if _same(loop, wrist)
        else topology.widest(points[loop]) <= max_width
        for loop in loops
    ]
    welds = 0
    if any(chosen):
        surface, welds = _closed(surface, loops, chosen, 2 * max_width, limits)
    left = topology.boundary_loops(surface.faces)
    holes = len(loops) - (0 if cap_wrist or wrist is None else 1)
    counts: Counts = {
        "holes": holes,
        "faces_added": len(surface.faces) - len(faces),
        "welds_refused": welds,
        "holes_left": max(len(left) - (0 if cap_wrist else 1), 0),
    }
    return surface, counts


def _same(loop: NDArray[np.int64], other: NDArray[np.int64] | None) -> bool:
    """Return whether two loops are one: they share a point."""
    return other is not None and bool(loop[0] in other)


def _closed(
    surface: Surface,
    loops: list[NDArray[np.int64]],
    chosen: list[bool],
    far: float,
    limits: Limits,
) -> tuple[Surface, int]:
    """Return the surface with the chosen holes closed, and how many were welds."""
    points, faces = surface.points, surface.faces
    rim, kept = np.zeros(len(points), dtype=bool), np.zeros(len(points), dtype=bool)
    for loop, close in zip(loops, chosen, strict=True):
        (rim if close else kept)[loop] = True
    # A hole is closed if a face beside it is marked; one beside two holes is not.
    beside = rim[faces].any(axis=1) & ~kept[faces].any(axis=1)
    result = run_filters(
        points,
        faces,
        [
            Filter("compute_selection_by_condition_per_face", {"condselect": "fq > 0"}),
            Filter(
                "meshing_close_holes",
                {
                    "maxholesize": max(map(len, loops)) + 1,
                    "selected": True,
                    "selfintersection": False,
                },
            ),
        ],
        face_scalars=np.asarray(beside, dtype=np.float64),
        limits=limits,
    )
    added = np.arange(len(result.faces)) >= len(faces)
    weld = _welds(result.points, result.faces, added, far)
    n_welds = 0
    if weld.any():
        n_welds = 1 + int(
            topology.face_components(len(result.points), result.faces[weld]).max()
        )
    return Surface(result.points, result.faces[~weld]), n_welds


def _welds(points: Points, faces: Faces, added: FaceMask, far: float) -> FaceMask:
    """Return which of the added faces (m,) belong to a fill that is a weld."""
    weld = np.zeros(len(faces), dtype=bool)
    fill = np.flatnonzero(added)
    if fill.size == 0:
        return weld
    old = faces[~added]
    normals = topology.vertex_normals(points, old)
    labels = topology.face_components(len(points), faces[fill])
    for label in range(labels.max() + 1):
        here = fill[labels == label]
        if _joins_fingers(points, old, normals, faces[here], far):
            weld[here] = True
    return weld


def _joins_fingers(
    points: Points, old: Faces, normals: NDArray[np.float64], fill: Faces, far: float
) -> bool:
    """Return whether a fill spans a gap that is a long way around."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    edges, counts = topology.edge_counts(fill)
    edges = edges[counts == 2]  # across the hole, not along its rim
    across = points[edges[:, 1]] - points[edges[:, 0]]
    gap = np.linalg.norm(across, axis=1)
    wide = gap > _TOUCHING
    if not wide.any():
        return False
    (a, b), across, gap = edges[wide].T, across[wide], gap[wide]
    facing = np.einsum("ij,ij->i", normals[a], across) > _FACING * gap
    facing &= np.einsum("ij,ij->i", normals[b], -across) > _FACING * gap
    # Those that face each other first, then the longest.
    tried = np.lexsort((-gap, ~facing))[:_MOST_TRIED]
    lines, _ = topology.edge_counts(old)
    length = topology.edge_lengths(points, old)
    graph = coo_matrix((length, lines.T), (len(points), len(points))).tocsr()
    limit = max(_WAY_AROUND * float(gap[tried].max()), far)
    way = dijkstra(graph, directed=False, indices=a[tried], limit=limit)
    along = way[np.arange(tried.size), b[tried]]  # infinite beyond the limit
    long = along > _WAY_AROUND * gap[tried]
    return bool((long & (facing[tried] | (along > far))).any())
