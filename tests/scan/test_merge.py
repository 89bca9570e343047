"""Oriented points become one closed surface that knows where it is a guess."""

import numpy as np
import pytest
from tolerances import ROUNDING

from meshes import distance_to, sphere
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.merge import Merged, cut_bridges, merge_points, unsupported_regions
from skinviz.scan.meshlab import Limits
from skinviz.scan.wrist import cut_wrist

RADIUS, CELL, SUPPORT = 40.0, 2.5, 5.0
GAP = 28.0
"""Height along ``TOP`` above which the sphere was not measured. [mm]"""

TOP = np.array([1.0, 1.0, 1.0]) / np.sqrt(3)
"""Where the sphere's unmeasured cap is."""


def merged_sphere(gap):
    """A sphere merged from points and normals, its cap above ``gap`` missing."""
    points = np.asarray(sphere(RADIUS, 5).points)
    points = points[points @ TOP < gap]
    return merge_points(points, points / RADIUS, cell=CELL, support=SUPPORT), points


@pytest.fixture(scope="module")
def open_sphere():
    return merged_sphere(GAP)


@pytest.mark.parametrize("gap", [36.0, 99.0])
def test_the_merged_surface_is_closed_and_in_one_piece(gap):
    merged, _ = merged_sphere(gap)
    assert topology.boundary_loops(merged.faces) == []
    assert topology.n_non_manifold_edges(merged.faces) == 0
    labels = topology.face_components(len(merged.points), merged.faces)
    assert labels.max() == 0


def test_the_merged_surface_lies_on_the_measured_one(open_sphere):
    merged, _ = open_sphere
    used = merged.supported & (merged.points @ TOP < GAP - SUPPORT)
    radius = np.linalg.norm(merged.points[used], axis=1)
    assert np.sqrt(((radius - RADIUS) ** 2).mean()) < 0.05
    assert np.abs(radius - RADIUS).max() < 0.5
    assert topology.enclosed_volume(merged.points, merged.faces) > 0


def test_support_is_the_distance_to_the_nearest_measured_point(open_sphere):
    merged, measured = open_sphere
    some = np.random.default_rng(0).choice(len(merged.points), 400, replace=False)
    gaps = np.linalg.norm(merged.points[some, None] - measured, axis=2).min(axis=1)
    np.testing.assert_array_equal(merged.supported[some], gaps <= SUPPORT)


def test_the_unmeasured_cap_is_the_one_region_without_evidence(open_sphere):
    merged, _ = open_sphere
    regions = unsupported_regions(merged)
    assert len(regions) == 1
    points = merged.points[merged.faces[regions[0]]].reshape(-1, 3)
    # Nothing nearer than the support to the rim, which is at GAP, counts.
    assert (points @ TOP).min() > GAP
    assert np.abs(np.cross(points.mean(axis=0), TOP)).max() < 1
    width = np.sqrt(RADIUS**2 - GAP**2)
    area = topology.face_areas(merged.points, merged.faces[regions[0]]).sum()
    assert 0.8 * np.pi * (width - SUPPORT) ** 2 < area < 1.1 * np.pi * width**2


def dumbbell(bridged):
    """A torus of one piece: its ring is a hand whose two ends a weld joins."""
    import pyvista as pv

    shape = pv.ParametricTorus(ringradius=30, crosssectionradius=8).triangulate()
    points, faces = topology.arrays(shape.clean())
    angle = np.arctan2(points[:, 1], points[:, 0])
    return Merged(points, faces, np.abs(angle) > bridged)


def test_a_bridge_without_evidence_is_cut_and_leaves_two_holes():
    merged = dumbbell(0.5)
    cut, n = cut_bridges(merged, largest=1e9)
    assert n == 1
    assert len(topology.boundary_loops(cut.faces)) == 2
    assert unsupported_regions(cut) == []
    np.testing.assert_array_equal(cut.points, merged.points)


def test_what_may_be_the_wrist_is_not_cut_as_a_bridge():
    merged = dumbbell(0.5)
    cut, n = cut_bridges(merged, largest=10.0)
    assert n == 0
    np.testing.assert_array_equal(cut.faces, merged.faces)


def test_a_ring_without_evidence_around_a_finger_is_no_bridge():
    # Cutting it would lose the fingertip.
    points, faces = topology.arrays(sphere(RADIUS, 4))
    merged = Merged(points, faces, (np.abs(points[:, 2] - 10) > 5))
    assert len(topology.boundary_loops(faces[unsupported_regions(merged)[0]])) == 2
    cut, n = cut_bridges(merged, largest=1e9)
    assert n == 0
    np.testing.assert_array_equal(cut.faces, faces)


def test_regions_come_largest_first_and_every_bare_face_has_one():
    points, faces = topology.arrays(sphere(RADIUS, 3))
    supported = (np.abs(points[:, 2]) < 30) | (points[:, 2] < -36)
    merged = Merged(points, faces, supported)
    regions = unsupported_regions(merged)
    areas = [topology.face_areas(points, faces[r]).sum() for r in regions]
    assert len(regions) == 2
    assert areas == sorted(areas, reverse=True)
    bare = np.flatnonzero(~supported[faces].any(axis=1))
    np.testing.assert_array_equal(np.sort(np.concatenate(regions)), bare)
    assert unsupported_regions(Merged(points, faces, np.ones(len(points), bool))) == []


def test_a_piece_apart_is_left_out():
    points = np.concatenate(
        [sphere(RADIUS, 4).points, sphere(8.0, 3, centre=(80, 0, 0)).points]
    )
    normals = np.concatenate(
        [sphere(RADIUS, 4).points / RADIUS, sphere(8.0, 3).points / 8.0]
    )
    merged = merge_points(points, normals, cell=CELL, support=SUPPORT)
    assert merged.points[merged.faces].reshape(-1, 3)[:, 0].max() < RADIUS + 1


def test_a_finer_cell_gives_a_finer_surface():
    points = np.asarray(sphere(RADIUS, 5).points)
    coarse, fine = (
        merge_points(points, points / RADIUS, cell=cell, support=SUPPORT)
        for cell in (3, 1.5)
    )
    assert len(fine.faces) > 2.5 * len(coarse.faces)


def test_merging_that_takes_too_long_is_stopped():
    points = np.asarray(sphere(RADIUS, 4).points)
    with pytest.raises(MeshError, match=r"poisson.*longer than"):
        merge_points(
            points, points / RADIUS, cell=1.0, support=2.0, limits=Limits(timeout=0.01)
        )


def test_the_wrist_is_cut_plane_behind_the_cap(open_sphere):
    merged, _ = open_sphere
    region = unsupported_regions(merged)[0]
    rim = np.unique(topology.boundary_edges(merged.faces[region]))
    points, faces = cut_wrist(merged, region, trim=SUPPORT)
    loops = topology.boundary_loops(faces)
    assert len(loops) == 1
    edge = points[loops[0]]
    centred = edge - edge.mean(axis=0)
    spread = np.linalg.svd(centred, compute_uv=False)
    assert spread[2] / np.sqrt(len(edge)) < 1e-3
    normal = np.linalg.svd(centred)[2][2]
    assert abs(normal @ TOP) > np.cos(np.deg2rad(5))
    # The plane lies the trim below the lowest point of the cap's rim.
    lowest = (merged.points[rim] @ TOP).min()
    assert (edge @ TOP).mean() == pytest.approx(lowest - SUPPORT, abs=1.0)
    assert topology.n_non_manifold_edges(faces) == 0
    assert topology.face_components(len(points), faces).max() == 0


def test_cutting_moves_nothing_that_it_keeps(open_sphere):
    merged, _ = open_sphere
    points, faces = cut_wrist(merged, unsupported_regions(merged)[0], trim=SUPPORT)
    whole = topology.polydata(merged.points, merged.faces)
    assert distance_to(whole, points).max() < 1e-4
    kept = topology.face_areas(points, faces).sum()
    height = (points @ TOP).max() + RADIUS
    # A spherical segment's area is 2πr times its height.
    assert kept == pytest.approx(2 * np.pi * RADIUS * height, rel=0.01)


def test_cutting_does_not_depend_on_the_frame(open_sphere):
    merged, _ = open_sphere
    region = unsupported_regions(merged)[0]
    rotation = np.linalg.qr(np.random.default_rng(4).standard_normal((3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    turned = Merged(merged.points @ rotation.T, merged.faces, merged.supported)
    here = topology.face_areas(*cut_wrist(merged, region, SUPPORT)).sum()
    there = topology.face_areas(*cut_wrist(turned, region, SUPPORT)).sum()
    assert there == pytest.approx(here, rel=1e7 * ROUNDING)
