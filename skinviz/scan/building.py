"""Steps that make a surface of range views or of oriented points."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.align import align_patches
from skinviz.scan.checks import require_hand_size
from skinviz.scan.grid import range_of
from skinviz.scan.merge import (
    Merged,
    cut_bridges,
    merge_points,
    unsupported_regions,
)
from skinviz.scan.meshlab import Limits
from skinviz.scan.partners import Patch, Pose
from skinviz.scan.scan import PointCloud, transform
from skinviz.scan.smoothing import range_noise
from skinviz.scan.views import make_patch, view_surface
from skinviz.scan.workpiece import Counts, Surface, Workpiece
from skinviz.scan.wrist import cut_wrist

T = TypeVar("T")

_MOST_UNMEASURED = 0.25  # of the merged surface, its cap at the wrist included
_SMALLEST_WRIST = 200.0  # mm²; the opening of a child's wrist is above 1000
_NEIGHBOURS = 12


def triangulate(
    piece: Workpiece,
    _: Limits,
    *,
    max_incidence: float,
    max_stretch: float,
    min_island: float,
    rim_rings: float,
) -> tuple[Workpiece, Counts]:
    """Make each view a patch: no bridges over depth jumps, no islands, no rim."""
    made = [
        view_surface(
            view,
            max_incidence=max_incidence,
            max_stretch=max_stretch,
            min_island=int(min_island),
            rim_rings=int(rim_rings),
        )
        for view in piece.views
    ]
    patches = tuple(
        make_patch(view, points, faces)
        for view, (points, faces, _) in zip(piece.views, made, strict=True)
    )
    poses = tuple(view.pose for view in piece.views)
    cloud = _gathered(patches, poses)
    require_hand_size(cloud.points, piece.source)
    noise = [range_noise(range_of(view.points, view.eye)) for view in piece.views]
    each = [asdict(counts) for _, _, counts in made]
    totals = {name: sum(counts[name] for counts in each) for name in each[0]}
    piece = replace(piece, patches=patches, poses=poses, cloud=cloud)
    typical = round(float(np.median(noise)), 3)
    return piece, {"views": len(made), **totals, "noise_mm": typical}


def align(
    piece: Workpiece, _: Limits, *, reach: float, max_residual: float
) -> tuple[Workpiece, Counts]:
    """Lay all patches on each other, the first one where it is."""
    aligned = align_patches(piece.patches, piece.poses, reach=reach)
    if aligned.residual > max_residual:
        raise MeshError(
            f"{piece.source}: aligned views still lie "
            f"{aligned.residual:.2f} mm apart; check the poses, and that the hand "
            "did not move between views"
        )
    counts: Counts = {
        "iterations": aligned.iterations,
        "settled": int(aligned.settled),
        "residual_mm": round(aligned.residual, 4),
        "least_overlap": round(float(aligned.overlap.min()), 3),
        "largest_move_mm": round(float(aligned.moved.max()), 3),
    }
    cloud = _gathered(piece.patches, aligned.poses)
    return replace(piece, poses=aligned.poses, cloud=cloud), counts


def drop_outliers(
    piece: Workpiece, _: Limits, *, max_distance: float
) -> tuple[Workpiece, Counts]:
    """Drop points that lie much farther from their neighbours than points do."""
    from scipy.spatial import cKDTree

    cloud = _required(piece.cloud)
    n_near = min(_NEIGHBOURS, len(cloud.points) - 1)
    gaps, _index = cKDTree(cloud.points).query(cloud.points, k=n_near + 1, workers=-1)
    mean = np.asarray(gaps)[:, 1:].mean(axis=1)
    kept = mean <= max_distance * np.median(mean)
    normals = None if cloud.normals is None else cloud.normals[kept]
    counts: Counts = {"points": len(kept), "outliers": int((~kept).sum())}
    return replace(piece, cloud=PointCloud(cloud.points[kept], normals)), counts


def merge(
    piece: Workpiece, limits: Limits, *, cell: float, support: float
) -> tuple[Workpiece, Counts]:
    """Make one closed surface of all points, that knows where it has none."""
    cloud = _required(piece.cloud)
    merged = merge_points(
        cloud.points,
        _required(cloud.normals),
        cell=cell,
        support=support,
        limits=limits,
    )
    counts: Counts = {"measured_points": len(cloud.points), "faces": len(merged.faces)}
    return _with_merged(piece, merged), counts


def cut_welds(piece: Workpiece, _: Limits) -> tuple[Workpiece, Counts]:
    """Cut what no point supports and what joins the surface to itself: welds."""
    merged, cut = cut_bridges(_required(piece.merged), _SMALLEST_WRIST)
    return _with_merged(piece, merged), {"welds": cut}


def open_wrist(piece: Workpiece, _: Limits, *, trim: float) -> tuple[Workpiece, Counts]:
    """Cut away the widest region without evidence, if it is as wide as a wrist."""
    merged = _required(piece.merged)
    regions = unsupported_regions(merged)
    areas = [
        float(topology.face_areas(merged.points, merged.faces[r]).sum())
        for r in regions
    ]
    whole = float(topology.face_areas(merged.points, merged.faces).sum())
    if sum(areas) > _MOST_UNMEASURED * whole:
        raise MeshError(
            f"{piece.source}: {sum(areas) / whole:.0%} of the surface was "
            "never measured; scan the hand from all around"
        )
    opened = bool(areas) and areas[0] >= _SMALLEST_WRIST
    points, faces = merged.points, merged.faces
    if opened:
        points, faces = cut_wrist(merged, regions[0], trim=trim)
    counts: Counts = {
        "openings": int(opened),
        "removed_mm2": round(areas[0], 1) if opened else 0.0,
        "holes_bridged": len(areas) - opened,
        "bridged_mm2": round(sum(areas[opened:]), 1),
    }
    surface = Surface(*topology.compact(points, faces))
    return replace(piece, merged=None, surface=surface), counts


def _gathered(patches: tuple[Patch, ...], poses: tuple[Pose, ...]) -> PointCloud:
    """Return all patches' points in one frame."""
    placed = list(zip(patches, poses, strict=True))
    return PointCloud(
        np.concatenate([transform(pose, patch.points) for patch, pose in placed]),
        np.concatenate([_turned(pose, patch.normals) for patch, pose in placed]),
    )


def _turned(pose: Pose, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors (n, 3) after a pose's rotation."""
    return np.asarray(vectors @ pose[:3, :3].T)


def _with_merged(piece: Workpiece, merged: Merged) -> Workpiece:
    """Return a workpiece whose surface is the merged one."""
    surface = Surface(*topology.compact(merged.points, merged.faces))
    return replace(piece, merged=merged, surface=surface)


def _required(part: T | None) -> T:
    """Return a part that the order of the steps has put there."""
    if part is None:
        raise MeshError("a step lacks what it works on; see skinviz.scan.steps.KINDS")
    return part
