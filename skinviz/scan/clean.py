"""From a raw scan to a clean hand mesh, and a report of what was done.

The steps, in their order: views are made into patches, aligned and merged;
islands go; the wrist is opened; other holes are closed; the surface is remeshed
and checked. A scan that is already a mesh starts at the islands.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from skinviz._validate import in_range
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.align import align_patches
from skinviz.scan.checks import require_hand_size, require_triangles
from skinviz.scan.merge import Merged, merge, unsupported_regions
from skinviz.scan.meshlab import DEFAULT_TIMEOUT, Filter, run_filters
from skinviz.scan.report import CleaningReport, Progress, Recorder
from skinviz.scan.scan import Scan, no_surface, transform
from skinviz.scan.topology import Faces, Points
from skinviz.scan.views import PatchCounts, make_patch
from skinviz.scan.wrist import cut_wrist

if TYPE_CHECKING:
    import pyvista

STEPS = (
    "triangulate",
    "align",
    "merge",
    "open wrist",
    "repair",
    "close holes",
    "remesh",
    "check",
)
"""Names of the steps, in their order; a mesh without views starts at "repair"."""

_MOST_UNMEASURED = 0.25  # of the merged surface, its cap at the wrist included
_SMALLEST_WRIST = 200.0  # mm²; the opening of a child's wrist is above 1000


def clean_scan(
    scan: Scan,
    *,
    edge_length: float = 1.2,
    max_incidence: float = np.deg2rad(75),
    min_island: int = 200,
    timeout: float = DEFAULT_TIMEOUT,
    progress: Progress | None = None,
) -> tuple[pyvista.PolyData, CleaningReport]:
    """Make a manifold hand mesh, open only at the wrist, from a raw scan.

    Parameters
    ----------
    scan : Scan
        Range views, or a mesh. [mm]
    edge_length : float
        Target length of the edges. [mm]
    max_incidence : float
        Triangles of a view seen at a larger angle are bridges. [rad]
    min_island : int
        Pieces of a view with fewer triangles are outliers.
    timeout : float
        Time after which a pymeshlab worker is stopped. [s]
    progress : callable, optional
        Called with the name of each step as it begins.

    Returns
    -------
    mesh : pyvista.PolyData
        One manifold component in mm, outward normals as point data ``Normals``.
    report : CleaningReport
        Counts for each step.

    Raises
    ------
    MeshError
        If the scan is empty, not the size of a hand, or cannot be cleaned.

    Notes
    -----
    The first view's pose fixes the frame. The wrist is taken to be the largest
    opening; it is left open, cut plane where it was never measured, and every
    other hole is closed.
    """
    in_range(edge_length, 0.05, 20, "edge_length", "mm")
    in_range(max_incidence, 0.1, np.pi / 2, "max_incidence", "rad")
    in_range(min_island, 0, 1e9, "min_island")
    in_range(timeout, 1e-3, 1e6, "timeout", "s")
    recorder = Recorder(progress or (lambda _: None))
    if scan.views:
        points, faces = _merge_views(
            scan,
            recorder,
            edge_length=edge_length,
            max_incidence=max_incidence,
            min_island=min_island,
            timeout=timeout,
        )
    elif scan.mesh is not None:
        points, faces = require_triangles(scan.mesh, scan.source or "mesh")
        require_hand_size(points, scan.source or "mesh")
    elif scan.cloud is not None:
        raise no_surface(scan.cloud, scan.source or "scan")
    else:
        raise MeshError(f"{scan.source or 'scan'} has neither views nor a mesh")
    points, faces = _repair(points, faces, timeout, recorder)
    points, faces = _close_holes(points, faces, timeout, recorder)
    points, faces = _remesh(points, faces, edge_length, timeout, recorder)
    mesh = _finish(points, faces, recorder)
    return mesh, CleaningReport(tuple(recorder.steps))


def _merge_views(
    scan: Scan,
    recorder: Recorder,
    *,
    edge_length: float,
    max_incidence: float,
    min_island: int,
    timeout: float,
) -> tuple[Points, Faces]:
    """Triangulate, align and merge range views, and open the wrist."""
    recorder.begin("triangulate")
    made = [
        make_patch(view, max_incidence=max_incidence, min_island=min_island)
        for view in scan.views
    ]
    patches = tuple(patch for patch, _, _ in made)
    _record_patches(recorder, [counts for _, _, counts in made])

    recorder.begin("align")
    placed = [
        transform(v.pose, p.points) for v, p in zip(scan.views, patches, strict=True)
    ]
    require_hand_size(np.concatenate(placed), scan.source or "scan")
    aligned = align_patches(patches, tuple(view.pose for view in scan.views))
    recorder.end(
        "align",
        iterations=aligned.iterations,
        settled=int(aligned.settled),
        residual_mm=round(aligned.residual, 4),
        least_overlap=round(float(aligned.overlap.min()), 3),
        largest_move_mm=round(float(aligned.moved.max()), 3),
    )
    if aligned.residual > edge_length:
        raise MeshError(
            f"{scan.source or 'scan'}: aligned views still lie "
            f"{aligned.residual:.2f} mm apart; check the poses, and that the hand "
            "did not move between views"
        )
    points = np.concatenate(
        [
            transform(pose, patch.points)
            for pose, patch in zip(aligned.poses, patches, strict=True)
        ]
    )
    normals = np.concatenate(
        [
            patch.normals @ pose[:3, :3].T
            for pose, patch in zip(aligned.poses, patches, strict=True)
        ]
    )

    recorder.begin("merge")
    support = 2 * edge_length
    merged = merge(points, normals, cell=edge_length, support=support, timeout=timeout)
    recorder.end("merge", measured_points=len(points), faces=len(merged.faces))
    return _open_wrist(merged, support, scan.source or "scan", recorder)


def _open_wrist(
    merged: Merged, support: float, source: str, recorder: Recorder
) -> tuple[Points, Faces]:
    """Cut away the widest region without evidence, if it is as wide as a wrist."""
    recorder.begin("open wrist")
    regions = unsupported_regions(merged)
    areas = [
        float(topology.face_areas(merged.points, merged.faces[r]).sum())
        for r in regions
    ]
    whole = float(topology.face_areas(merged.points, merged.faces).sum())
    if sum(areas) > _MOST_UNMEASURED * whole:
        raise MeshError(
            f"{source}: {sum(areas) / whole:.0%} of the surface was "
            "never measured; scan the hand from all around"
        )
    opened = bool(areas) and areas[0] >= _SMALLEST_WRIST
    out_points, out_faces = merged.points, merged.faces
    if opened:
        out_points, out_faces = cut_wrist(merged, regions[0], trim=support)
    recorder.end(
        "open wrist",
        openings=int(opened),
        removed_mm2=round(areas[0], 1) if opened else 0.0,
        holes_bridged=len(areas) - opened,
        bridged_mm2=round(sum(areas[opened:]), 1),
    )
    return topology.compact(out_points, out_faces)


def _record_patches(recorder: Recorder, counts: list[PatchCounts]) -> None:
    """Sum the views' counts into one step."""
    totals = {name: sum(getattr(c, name) for c in counts) for name in asdict(counts[0])}
    recorder.end("triangulate", views=len(counts), **totals)


def _repair(
    points: Points, faces: Faces, timeout: float, recorder: Recorder
) -> tuple[Points, Faces]:
    """Drop duplicates, null and non-manifold faces, and all but the main piece."""
    recorder.begin("repair")
    bad_edges = topology.n_non_manifold_edges(faces)
    result = run_filters(
        points,
        faces,
        [
            Filter("meshing_remove_duplicate_vertices", {}),
            Filter("meshing_remove_duplicate_faces", {}),
            Filter("meshing_remove_null_faces", {}),
            Filter("meshing_repair_non_manifold_edges", {}),
            Filter("meshing_repair_non_manifold_vertices", {}),
            Filter("meshing_re_orient_faces_coherently", {}),
        ],
        timeout=timeout,
    )
    labels = topology.face_components(len(result.points), result.faces)
    main = topology.largest_piece(len(result.points), result.faces)
    recorder.end(
        "repair",
        non_manifold_edges=bad_edges,
        faces_removed=len(faces) - len(result.faces),
        islands=int(labels.max()),
        island_faces=len(result.faces) - len(main),
    )
    return topology.compact(result.points, main)


def _close_holes(
    points: Points, faces: Faces, timeout: float, recorder: Recorder
) -> tuple[Points, Faces]:
    """Close every hole but the one with the largest outline: the wrist."""
    recorder.begin("close holes")
    loops = topology.boundary_loops(faces)
    if len(loops) > 1:
        extent = [float(np.ptp(points[loop], axis=0).max()) for loop in loops]
        wrist = loops[int(np.argmax(extent))]
        to_close = np.asarray(~np.isin(faces, wrist).any(axis=1))
        result = run_filters(
            points,
            faces,
            [
                Filter(
                    "compute_selection_by_condition_per_face", {"condselect": "fq > 0"}
                ),
                Filter(
                    "meshing_close_holes",
                    {
                        "maxholesize": max(len(loop) for loop in loops) + 1,
                        "selected": True,
                        "selfintersection": False,
                    },
                ),
            ],
            face_scalars=np.asarray(to_close, dtype=np.float64),
            timeout=timeout,
        )
        added = len(result.faces) - len(faces)
        points, faces = result.points, result.faces
    else:
        added = 0
    recorder.end(
        "close holes",
        holes=max(len(loops) - 1, 0),
        faces_added=added,
        holes_left=max(len(topology.boundary_loops(faces)) - 1, 0),
    )
    return points, faces


def _remesh(
    points: Points,
    faces: Faces,
    edge_length: float,
    timeout: float,
    recorder: Recorder,
) -> tuple[Points, Faces]:
    """Remesh to near-equilateral triangles of the target edge length."""
    recorder.begin("remesh")
    remesh = Filter(
        "meshing_isotropic_explicit_remeshing",
        {
            "iterations": 4,
            "targetlen": {"length": edge_length},
            "maxsurfdist": {"length": edge_length / 4},
        },
    )
    result = run_filters(points, faces, [remesh], timeout=timeout)
    points, faces = topology.compact(result.points, result.faces)
    edges, _ = topology.edge_counts(faces)
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    recorder.end(
        "remesh",
        points=len(points),
        faces=len(faces),
        mean_edge_mm=round(float(length.mean()), 3),
    )
    return points, faces


def _finish(points: Points, faces: Faces, recorder: Recorder) -> pyvista.PolyData:
    """Point the normals outwards and check what was promised."""
    recorder.begin("check")
    if topology.enclosed_volume(points, faces) < 0:
        faces = faces[:, ::-1]
    bad = topology.n_non_manifold_edges(faces)
    labels = topology.face_components(len(points), faces)
    n_components = int(labels.max()) + 1
    loops = topology.boundary_loops(faces)
    recorder.end(
        "check",
        non_manifold_edges=bad,
        components=n_components,
        boundaries=len(loops),
        length_mm=round(float(np.ptp(_principal(points)[:, 0])), 1),
        area_mm2=round(float(topology.face_areas(points, faces).sum()), 1),
    )
    if bad or n_components != 1 or len(loops) > 1:
        raise MeshError(
            f"cleaning left {bad} non-manifold edges, {n_components} components and "
            f"{len(loops)} boundaries (0, 1 and at most 1 expected); try a smaller "
            "edge_length or inspect the raw views"
        )
    mesh = topology.polydata(points, faces)
    mesh.point_data["Normals"] = topology.vertex_normals(points, faces)
    return mesh


def _principal(points: Points) -> Points:
    """Return points in their principal frame, longest axis first."""
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    return np.asarray(centred @ axes[:, ::-1])
