"""Range grids become triangles that face the sensor and bridge no depth jump."""

import numpy as np
import pytest

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.scan import RangeView
from skinviz.scan.views import drop_islands, erode_rim, make_patch, triangulate

STEEP = np.deg2rad(75)


def grid(height, pitch=1.0):
    """A range grid of heights (rows, columns) above evenly spaced cells."""
    rows, columns = height.shape
    x, y = np.meshgrid(pitch * np.arange(columns), pitch * np.arange(rows))
    points = np.stack([x, y, height], axis=-1)
    return np.where(np.isfinite(height)[..., None], points, np.nan)


def view(height, pitch=1.0):
    return RangeView("front", grid(np.asarray(height, dtype=float), pitch), np.eye(4))


def test_a_full_grid_gives_two_triangles_a_cell():
    points, faces, bridges = triangulate(grid(np.zeros((5, 7))), STEEP)
    assert (len(points), len(faces), bridges) == (35, 2 * 4 * 6, 0)
    assert topology.face_areas(points, faces).sum() == 24


@pytest.mark.parametrize(
    "turned",
    [
        lambda g: g,
        lambda g: g[::-1],
        lambda g: g[:, ::-1],
        lambda g: g[::-1, ::-1],
        lambda g: g.transpose(1, 0, 2),
    ],
    ids=["as made", "rows reversed", "columns reversed", "both reversed", "transposed"],
)
def test_triangles_face_the_sensor_however_the_grid_runs(turned):
    rng = np.random.default_rng(0)
    points, faces, bridges = triangulate(turned(grid(rng.random((6, 8)))), STEEP)
    assert bridges == 0
    assert len(faces) == 2 * 5 * 7
    assert (topology.face_vectors(points, faces)[:, 2] > 0).all()


@pytest.mark.parametrize("axis", [0, 1])
def test_no_triangle_bridges_a_depth_jump(axis):
    height = np.zeros((10, 12))
    if axis:
        height[:, 6:] = -30.0
    else:
        height[5:, :] = -30.0
    points, faces, bridges = triangulate(grid(height), STEEP)
    assert np.ptp(points[faces][:, :, 2], axis=1).max() == 0
    assert bridges == 2 * (height.shape[1 - axis] - 1)
    assert len(faces) + bridges == 2 * 9 * 11
    assert topology.face_components(len(points), faces).max() == 1


def test_a_slope_is_kept_up_to_the_angle_and_dropped_beyond():
    columns = np.arange(8)
    for angle, kept in ((np.deg2rad(74), 98), (np.deg2rad(76), 0)):
        height = np.tile(np.tan(angle) * columns, (8, 1))
        _, faces, bridges = triangulate(grid(height), STEEP)
        assert (len(faces), bridges) == (kept, 98 - kept)


@pytest.mark.parametrize("corner", [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_a_cell_with_one_corner_missing_keeps_the_other_triangle(corner):
    height = np.zeros((2, 2))
    height[corner] = np.nan
    points, faces, bridges = triangulate(grid(height), STEEP)
    assert (len(points), len(faces), bridges) == (3, 1, 0)
    assert set(faces[0].tolist()) == {0, 1, 2}


def test_a_cell_with_two_corners_missing_gives_nothing():
    for height in ([[0, np.nan], [np.nan, 0]], [[0, 0], [np.nan, np.nan]]):
        points, faces, bridges = triangulate(grid(np.array(height)), STEEP)
        assert (len(points), len(faces), bridges) == (2, 0, 0)


def test_the_diagonal_with_the_smaller_step_is_chosen():
    # A ridge along one diagonal must not be cut by an edge across it.
    points, faces, _ = triangulate(grid(np.array([[1.0, 0], [0, 1]])), STEEP)
    edges, counts = topology.edge_counts(faces)
    diagonal = edges[counts == 2][0]
    np.testing.assert_array_equal(points[diagonal][:, 2], [1, 1])


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
    patch, faces, counts = make_patch(view(height), min_island=20)
    assert counts.returns == 20 * 30 + 9 == view(height).valid.sum()
    assert counts.bridges == 2 * 19
    assert counts.island_faces == 8
    # Two plates of 19 × 14 cells lose a ring each.
    assert counts.faces == len(faces) == 2 * 2 * 17 * 12
    assert counts.rim_faces == 2 * 2 * (19 * 14 - 17 * 12)
    assert patch.interior.sum() == 2 * 16 * 11
    np.testing.assert_array_equal(
        patch.normals, np.tile([0.0, 0, 1], (patch.points.shape[0], 1))
    )


def test_normals_of_a_slope_are_the_slopes():
    slope = np.deg2rad(40)
    height = np.tile(np.tan(slope) * np.arange(40), (40, 1))
    patch, _, _ = make_patch(view(height))
    expected = np.array([-np.sin(slope), 0, np.cos(slope)])
    np.testing.assert_allclose(
        patch.normals, np.tile(expected, (len(patch.points), 1)), atol=1e-12
    )


def test_normals_are_smoothed_against_range_noise():
    noise = 0.1 * np.random.default_rng(5).standard_normal((60, 60))
    patch, faces, _ = make_patch(view(noise))
    raw = topology.vertex_normals(patch.points, faces)
    tilt = np.arccos(np.clip(patch.normals[:, 2], -1, 1))
    raw_tilt = np.arccos(np.clip(raw[:, 2], -1, 1))
    assert np.sqrt((tilt**2).mean()) < 0.6 * np.sqrt((raw_tilt**2).mean())
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
        make_patch(view(height))
