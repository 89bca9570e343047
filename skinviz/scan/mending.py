"""Steps that mend a mesh: each takes a surface and returns one, with its counts.

All are plain functions, ``step(surface, limits, **parameters)``; what they are
called and what their parameters may be is in ``scan.steps``.
"""

from __future__ import annotations

import numpy as np

from skinviz.scan import topology
from skinviz.scan.holes import close_holes
from skinviz.scan.meshlab import Filter, Limits, run_filters
from skinviz.scan.topology import Faces
from skinviz.scan.workpiece import Counts, Surface

_AS_ASKED = (0.5, 1.6)  # of the target: edges that remeshing leaves lie within
_NEARLY_ALL = 0.98  # of the edges
_SAME_MEAN = 0.1  # of the target
_ROUNDS = 6


def repair(surface: Surface, limits: Limits) -> tuple[Surface, Counts]:
    """Drop repeated points and faces, faces without area, and non-manifold parts."""
    before = len(surface.faces)
    bad_edges = topology.n_non_manifold_edges(surface.faces)
    result = run_filters(
        surface.points,
        surface.faces,
        [
            Filter("meshing_remove_duplicate_vertices", {}),
            Filter("meshing_remove_duplicate_faces", {}),
            Filter("meshing_remove_null_faces", {}),
            Filter("meshing_repair_non_manifold_edges", {}),
            Filter("meshing_repair_non_manifold_vertices", {}),
            Filter("meshing_re_orient_faces_coherently", {}),
        ],
        limits=limits,
    )
    counts: Counts = {
        "non_manifold_edges": bad_edges,
        "faces_removed": before - len(result.faces),
    }
    return Surface(result.points, result.faces), counts


def drop_islands(surface: Surface, _: Limits) -> tuple[Surface, Counts]:
    """Keep the piece with the most triangles."""
    n_points, faces = len(surface.points), surface.faces
    labels = topology.face_components(n_points, faces)
    main = topology.largest_piece(n_points, faces)
    counts: Counts = {
        "islands": int(labels.max()),
        "island_faces": len(faces) - len(main),
    }
    return Surface(*topology.compact(surface.points, main)), counts


def remesh(
    surface: Surface, limits: Limits, *, edge_length: float
) -> tuple[Surface, Counts]:
    """Make the triangles near-equilateral, with edges of a target length.

    A mesh whose edges are as asked already is left as it is.
    """
    done = _is_remeshed(surface, edge_length)
    if not done:
        surface = _remeshed(surface, edge_length, limits)
    length = topology.edge_lengths(surface.points, surface.faces)
    counts: Counts = {
        "as_asked_already": int(done),
        "points": len(surface.points),
        "faces": len(surface.faces),
        "mean_edge_mm": round(float(length.mean()), 3),
    }
    return surface, counts


def _is_remeshed(surface: Surface, edge_length: float) -> bool:
    """Return whether the edges have the target length as remeshing leaves them."""
    share = topology.edge_lengths(surface.points, surface.faces) / edge_length
    low, high = _AS_ASKED
    within = float(np.mean((share > low) & (share < high)))
    return within >= _NEARLY_ALL and abs(float(share.mean()) - 1) < _SAME_MEAN


def _remeshed(surface: Surface, edge_length: float, limits: Limits) -> Surface:
    """Return a surface of near-equilateral triangles."""
    remeshing = Filter(
        "meshing_isotropic_explicit_remeshing",
        {
            "iterations": 4,
            "targetlen": {"length": edge_length},
            # Points are put back on the surface anyway, and to measure how far
            # each step strays takes five times as long on a million triangles.
            "checksurfdist": False,
        },
    )
    result = run_filters(surface.points, surface.faces, [remeshing], limits=limits)
    return Surface(*topology.compact(result.points, result.faces))


def untangle(
    surface: Surface, limits: Limits, *, max_width: float
) -> tuple[Surface, Counts]:
    """Cut out triangles that cross others or share an edge with two, close anew."""
    crossing = crossing_faces(surface, limits)
    bad = crossing | _beside_non_manifold(surface.faces)
    found, tangled, removed, rounds = int(crossing.sum()), int(bad.sum()), 0, 0
    while bad.any() and rounds < _ROUNDS:
        rounds += 1
        faces = _without(surface.faces, bad, rounds)
        removed += len(surface.faces) - len(faces)
        faces = topology.largest_piece(len(surface.points), faces)
        cut = Surface(*topology.compact(surface.points, faces))
        cut, _counts = repair(cut, limits)
        cut, _counts = drop_islands(cut, limits)
        surface, _counts = close_holes(cut, limits, max_width=max_width)
        crossing = crossing_faces(surface, limits)
        bad = crossing | _beside_non_manifold(surface.faces)
    counts: Counts = {
        "crossing_faces": found,
        "non_manifold_faces": tangled - found,
        "faces_removed": removed,
        "crossing_left": int(crossing.sum()),
    }
    return surface, counts


def crossing_faces(surface: Surface, limits: Limits) -> topology.FaceMask:
    """Return which faces (m,) pass through another one."""
    select = Filter("compute_selection_by_self_intersections_per_face", {})
    return run_filters(surface.points, surface.faces, [select], limits=limits).selected


def _beside_non_manifold(faces: Faces) -> topology.FaceMask:
    """Return which faces (m,) have an edge that more than two faces share."""
    edges, counts = topology.edge_counts(faces)
    base = int(faces.max(initial=0)) + 1
    wrong = edges[counts > 2] @ (base, 1)
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2) @ (base, 1)
    return np.asarray(np.isin(sides, wrong).any(axis=1))


def _without(faces: Faces, drop: topology.FaceMask, rings: int) -> Faces:
    """Return the faces without some and as many rings of their neighbours."""
    for _ in range(rings):
        drop = np.asarray(np.isin(faces, np.unique(faces[drop])).any(axis=1))
    return faces[~drop]
