"""Two ways to merge the same aligned views: screened Poisson and a distance volume."""

import time
from collections.abc import Iterator

import numpy as np
import pymeshlab
from _clean_cases import Case, alone, peak, scan_of, truth
from _clean_compare import distance
from scipy.spatial import cKDTree

from skinviz.scan import topology
from skinviz.scan.align import align_patches
from skinviz.scan.merge import merge_points
from skinviz.scan.scan import transform
from skinviz.scan.views import make_patch, view_surface

_CELL, _SUPPORT, _BEYOND = 1.2, 2.4, 5.0  # mm; the last: from the true wrist


def compare_merges(case: Case) -> Iterator[str]:
    """Yield a line for each way: error, cover, holes, time and memory."""
    for way in (poisson, volume):
        error, covered, loops, bad, seconds, memory = alone(measured, way, case)
        yield (
            f"{way.__name__}: RMS {np.sqrt((error**2).mean()):.3f}, 95 % "
            f"{np.percentile(error, 95):.3f}, 99 % {np.percentile(error, 99):.3f}, max "
            f"{error.max():.2f} mm; truth within 0.5 mm {covered:.2%}; boundaries "
            f"{loops}, non-manifold edges {bad}; {seconds:.1f} s, {memory:.2f} GiB"
        )


def measured(way, case: Case):
    """Return what one way makes of the aligned views, where points support it."""
    scan = scan_of(case)
    made = [view_surface(view, max_stretch=6.0)[:2] for view in scan.views]
    patches = tuple(
        make_patch(view, *surface)
        for view, surface in zip(scan.views, made, strict=True)
    )
    aligned = align_patches(patches, tuple(view.pose for view in scan.views))
    placed = [
        (transform(pose, patch.points), faces, patch.normals @ pose[:3, :3].T)
        for pose, patch, (_, faces) in zip(aligned.poses, patches, made, strict=True)
    ]
    start = time.perf_counter()
    points, faces = way(placed)
    seconds = time.perf_counter() - start
    every = np.concatenate([p for p, _, _ in placed])
    near = cKDTree(every).query(points)[0] < _SUPPORT
    faces = faces[near[faces].all(axis=1)]
    used, used_faces = topology.compact(points, faces)
    shape = truth()
    true_points, true_faces = topology.arrays(shape)
    rim = true_points[topology.boundary_loops(true_faces)[0]]
    inner = true_points[cKDTree(rim).query(true_points)[0] > _BEYOND]
    covered = (distance(inner, topology.polydata(used, used_faces)) < 0.5).mean()
    return (
        distance(used, shape),
        float(covered),
        len(topology.boundary_loops(used_faces)),
        topology.n_non_manifold_edges(used_faces),
        seconds,
        peak(),
    )


def poisson(placed):
    """Return our merge's points and faces."""
    points = np.concatenate([p for p, _, _ in placed])
    normals = np.concatenate([n for _, _, n in placed])
    merged = merge_points(points, normals, cell=_CELL, support=_SUPPORT)
    return merged.points, merged.faces


def volume(placed):
    """Return the zero surface of a weighted distance volume (VCG's merge)."""
    meshes = pymeshlab.MeshSet(verbose=False)
    for points, faces, normals in placed:
        mesh = pymeshlab.Mesh(points, faces.astype(np.int32), v_normals_matrix=normals)
        meshes.add_mesh(mesh)
    meshes.generate_surface_reconstruction_vcg(
        voxsize=pymeshlab.PureValue(_CELL), subdiv=1
    )
    current = meshes.current_mesh()
    return current.vertex_matrix(), current.face_matrix().astype(np.int64)
