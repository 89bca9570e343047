"""Of a view only what can be trusted becomes a patch, and that without its noise."""

import numpy as np
import pytest

from meshes import grid
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.grid import triangulate
from skinviz.scan.scan import RangeView
from skinviz.scan.views import drop_islands, erode_rim, make_patch, view_surface

STEEP = np.deg2rad(75)


def view(height, pitch=1.0):
    return RangeView("front", grid(np.asarray(height, dtype=float), pitch), np.eye(4))


def test_islands_below_the_size_go_and_others_stay():
    height = np.full((12, 20), np.nan)
    height[1:4, 1:4] = 0  # 8 triangles
    height[5:11, 8:18] = 0  # 90 triangles
    points, faces, _ = triangulate(grid(height), STEEP)
    assert len(faces) == 98
    assert len(drop_islands(len(points), faces, 9)) == 90
    assert len(drop_islands(len(points), faces, 8)) == 98
    assert len(drop_islands(len(points), faces, 91)) == 0
    assert drop_islands(3, faces[:0], 5).shape == (0, 3)


def test_eroding_takes_one_ring_at_a_time():
    points, faces, _ = triangulate(grid(np.zeros((9, 9))), STEEP)
    for rings in range(4):
        inner = erode_rim(faces, rings)
        area = topology.face_areas(points, inner).sum()
        assert area == (8 - 2 * rings) ** 2


def test_a_patch_counts_what_it_dropped():
    height = np.full((30, 40), np.nan)
    height[2:22, 2:32] = 0.0
    height[2:22, 17:32] = -50.0  # a jump amid the rectangle
    height[25:28, 35:38] = 0.0  # an island of 8 triangles
    points, faces, counts = view_surface(view(height), min_island=20)
    patch = make_patch(view(height), points, faces)
    assert counts.returns == 20 * 30 + 9 == view(height).valid.sum()
    assert counts.bridges == 2 * 19
    assert counts.island_faces == 8
    # Two plates of 19 × 14 cells lose a ring each.
    assert counts.faces == len(faces) == 2 * 2 * 17 * 12
    assert counts.rim_faces == 2 * 2 * (19 * 14 - 17 * 12)
    assert patch.steady.sum() == 2 * 16 * 11
    np.testing.assert_array_equal(
        patch.normals, np.tile([0.0, 0, 1], (patch.points.shape[0], 1))
    )


def test_normals_of_a_slope_are_the_slopes():
    slope = np.deg2rad(40)
    height = np.tile(np.tan(slope) * np.arange(40), (40, 1))
    points, faces, _ = view_surface(view(height))
    patch = make_patch(view(height), points, faces)
    expected = np.array([-np.sin(slope), 0, np.cos(slope)])
    np.testing.assert_allclose(
        patch.normals, np.tile(expected, (len(patch.points), 1)), atol=1e-12
    )


@pytest.mark.parametrize(("size", "left"), [(0.1, 0.7), (0.5, 0.25)])
def test_normals_are_smoothed_as_far_as_noise_asks_for(size, left):
    noise = size * np.random.default_rng(5).standard_normal((60, 60))
    points, faces, _ = view_surface(view(noise))
    patch = make_patch(view(noise), points, faces)
    raw = topology.vertex_normals(points, faces)
    tilt = np.arccos(np.clip(patch.normals[:, 2], -1, 1))
    raw_tilt = np.arccos(np.clip(raw[:, 2], -1, 1))
    assert np.sqrt((tilt**2).mean()) < left * np.sqrt((raw_tilt**2).mean())
    np.testing.assert_allclose(np.linalg.norm(patch.normals, axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize(
    "height",
    [
        np.full((5, 5), np.nan),
        np.zeros((1, 50)),
        np.zeros((6, 6)),
        np.where(np.eye(30) > 0, 0.0, np.nan),
    ],
    ids=["no return", "one row", "too small", "a diagonal"],
)
def test_a_view_without_a_surface_is_refused_by_name(height):
    with pytest.raises(MeshError, match="'front' has no surface left"):
        view_surface(view(height))


def test_what_is_seen_at_a_grazing_angle_is_no_partner():
    for angle, steady in ((50, 28 * 28), (70, 0)):
        slope = np.tile(np.tan(np.deg2rad(angle)) * np.arange(32.0), (32, 1))
        points, faces, _ = view_surface(view(slope))
        assert make_patch(view(slope), points, faces).steady.sum() == steady
