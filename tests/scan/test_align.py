"""Rigid errors of overlapping views are undone."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from meshes import distance_to, pose, toy_hand
from skinviz.errors import MeshError
from skinviz.scan.align import align_patches
from skinviz.scan.partners import Patch
from skinviz.scan.scan import transform
from skinviz.scan.simulate import Scanner, directions_around, simulate_scan
from skinviz.scan.views import make_patch, view_surface

AXES = np.array([60.0, 45.0, 30.0])
"""Half axes of an ellipsoid: no rigid motion maps it onto itself. [mm]"""


def ellipsoid_patch(name, towards, half_width=1.3, step=0.018):
    """Points of the ellipsoid that lie within an angle [rad] of a direction.

    The samples differ from patch to patch, as those of two range views do.
    """
    towards = np.asarray(towards) / np.linalg.norm(towards)
    helper = np.eye(3)[np.argmin(np.abs(towards))]
    x = np.cross(helper, towards)
    x /= np.linalg.norm(x)
    y = np.cross(towards, x)
    reach = np.sin(half_width)
    u, v = (g.ravel() for g in np.meshgrid(*[np.arange(-reach, reach, step)] * 2))
    inside = u**2 + v**2 < reach**2
    u, v = u[inside], v[inside]
    unit = np.outer(u, x) + np.outer(v, y) + np.outer(np.sqrt(1 - u**2 - v**2), towards)
    normals = unit / AXES
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    steady = u**2 + v**2 < (reach - 2 * step) ** 2
    return Patch(name, unit * AXES, normals, steady)


def around(n):
    turn = 2 * np.pi * np.arange(n) / n
    return np.stack([0.3 * np.cos(3 * turn), np.cos(turn), np.sin(turn)], axis=1)


def in_sensor_frame(patch, true_pose):
    """A patch as its own sensor sees it, placed by the true pose."""
    rotation = true_pose[:3, :3]
    return Patch(
        patch.name,
        (patch.points - true_pose[:3, 3]) @ rotation,
        patch.normals @ rotation,
        patch.steady,
    )


def farthest_move(patch, found, true):
    return np.linalg.norm(
        transform(found, patch.points) - transform(true, patch.points), axis=1
    ).max()


@pytest.mark.parametrize("n_views", [2, 3, 8])
def test_small_rigid_errors_are_undone(n_views):
    rng = np.random.default_rng(n_views)
    directions = around(n_views) if n_views > 2 else [[0, 1, 0.0], [0, 1, 1.0]]
    true = [pose(rng.uniform(-2, 2, 3), rng.uniform(-300, 300, 3)) for _ in directions]
    patches = tuple(
        in_sensor_frame(ellipsoid_patch(f"v{i}", d), t)
        for i, (d, t) in enumerate(zip(directions, true, strict=True))
    )
    believed = [true[0]]
    for t in true[1:]:
        wrong = t.copy()
        tilt = Rotation.from_rotvec(np.deg2rad(0.5) * rng.standard_normal(3))
        wrong[:3, :3] = tilt.as_matrix() @ t[:3, :3]
        wrong[:3, 3] += 0.7 * rng.standard_normal(3)
        believed.append(wrong)
    errors = [
        farthest_move(p, w, t) for p, w, t in zip(patches, believed, true, strict=True)
    ]
    assert max(errors) > 0.5
    result = align_patches(patches, tuple(believed))
    np.testing.assert_array_equal(result.poses[0], true[0])
    for patch, found, t in zip(patches, result.poses, true, strict=True):
        assert farthest_move(patch, found, t) < 0.01
    assert result.residual < 0.01
    assert 0.1 < result.overlap.min() <= result.overlap.max() <= 1
    assert result.iterations < 60


def test_found_poses_are_rigid():
    patches = (ellipsoid_patch("a", [0, 1, 0]), ellipsoid_patch("b", [0, 1, 1]))
    result = align_patches(patches, (np.eye(4), pose((0.01, 0, -0.01), (0.5, 0, 1))))
    for found in result.poses:
        rotation = found[:3, :3]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1, rel=1e-12)
        np.testing.assert_array_equal(found[3], [0, 0, 0, 1])


def test_true_poses_stay_where_they_are():
    patches = tuple(ellipsoid_patch(f"v{i}", d) for i, d in enumerate(around(4)))
    result = align_patches(patches, (np.eye(4),) * 4)
    for patch, found in zip(patches, result.poses, strict=True):
        assert farthest_move(patch, found, np.eye(4)) < 0.01
    assert result.moved[0] == 0
    assert result.moved.max() < 0.01


def test_alignment_does_not_depend_on_where_the_world_lies():
    patches = (ellipsoid_patch("a", [0, 1, 0]), ellipsoid_patch("b", [0, 1, 1]))
    wrong = pose((0.006, -0.004, 0.005), (0.4, -0.6, 0.3))
    here = align_patches(patches, (np.eye(4), wrong)).poses
    world = pose((1.0, 0.3, -2.0), (-524.0, 190.0, 296.0))
    there = align_patches(patches, (world, world @ wrong)).poses
    # Rounding decides when a round moves less than 0.002 mm and is the last.
    assert farthest_move(patches[1], there[1], world @ here[1]) < 2e-3


def test_how_far_views_moved_is_reported():
    patches = (ellipsoid_patch("a", [0, 1, 0]), ellipsoid_patch("b", [0, 1, 1]))
    shift = np.array([0.6, -0.8, 0.0])
    result = align_patches(patches, (np.eye(4), pose(shift=shift)))
    assert result.moved[0] == 0
    assert result.moved[1] == pytest.approx(1.0, abs=0.01)


def test_a_single_view_keeps_its_pose():
    where = pose((0.3, 0.2, 0.1), (1, 2, 3))
    result = align_patches((ellipsoid_patch("a", [0, 1, 0]),), (where,))
    np.testing.assert_array_equal(result.poses[0], where)
    assert (result.residual, result.iterations) == (0, 0)
    assert result.moved.tolist() == [0]


def test_a_view_that_overlaps_no_other_is_named():
    patches = (
        ellipsoid_patch("front", [0, 1, 0]),
        ellipsoid_patch("side", [0, 1, 1]),
        ellipsoid_patch("astray", [0, 1, 0.5]),
    )
    poses = (np.eye(4), np.eye(4), pose(shift=(200.0, 0, 0)))
    with pytest.raises(MeshError, match="view 'astray' overlaps no other view"):
        align_patches(patches, poses)


def test_opposite_surfaces_are_no_partners():
    # Two sides of a thin sheet lie within reach but face away from each other.
    x, y = (g.ravel() for g in np.meshgrid(*[np.arange(-20.0, 20.0)] * 2))
    points = np.stack([x, y, np.zeros_like(x)], axis=1)
    up = np.tile([0.0, 0, 1], (len(x), 1))
    everywhere = np.ones(len(x), dtype=bool)
    sheet = Patch("top", points, up, everywhere)
    back = Patch("bottom", points - [0, 0, 1], -up, everywhere)
    with pytest.raises(MeshError, match="overlaps no other view"):
        align_patches((sheet, back), (np.eye(4), np.eye(4)))


def test_a_motion_that_the_surface_leaves_open_does_not_blow_up():
    # Two plates can slide on each other; only tilt and height are determined.
    rng = np.random.default_rng(3)
    plates = []
    for name in ("a", "b"):
        xy = rng.uniform(-30, 30, (3000, 2))
        points = np.column_stack([xy, np.zeros(len(xy))])
        up = np.tile([0.0, 0, 1], (len(xy), 1))
        plates.append(Patch(name, points, up, np.ones(len(xy), dtype=bool)))
    wrong = pose((0.004, -0.003, 0.0), (0.0, 0.0, 0.8))
    result = align_patches(tuple(plates), (np.eye(4), wrong))
    found = transform(result.poses[1], plates[1].points)
    assert np.abs(found[:, 2]).max() < 1e-3
    assert np.linalg.norm(found - plates[1].points, axis=1).max() < 1.0


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.1])
def test_views_of_precise_and_of_noisy_scanners_are_aligned(noise):
    directions = directions_around(6, (0, 0, 1), (0, 1, 0))
    scanner = Scanner(
        pitch=1.2, noise=noise, resolution=0, spike_fraction=0, outlier_fraction=0
    )
    scan = simulate_scan(toy_hand(), directions, scanner, np.random.default_rng(4))
    patches = tuple(make_patch(view, *view_surface(view)[:2]) for view in scan.views)
    result = align_patches(patches, tuple(view.pose for view in scan.views))
    # Most of each view is seen by a neighbour, whatever the noise.
    assert result.overlap.min() > 0.4
    for patch, found in zip(patches, result.poses, strict=True):
        gap = distance_to(toy_hand(), transform(found, patch.points))
        assert np.sqrt((gap**2).mean()) < 0.1 + 1.5 * noise
