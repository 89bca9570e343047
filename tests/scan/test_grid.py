"""Range grids become triangles that face the sensor and bridge no depth jump."""

import numpy as np
import pytest

from meshes import grid
from skinviz.scan import topology
from skinviz.scan.grid import relative_noise, smoothing_rounds, triangulate

STEEP = np.deg2rad(75)


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


def noisy(height, noise, seed=0):
    """A grid of rays 0.8 mm apart, its range off by Gaussian noise. [mm]"""
    rng = np.random.default_rng(seed)
    return grid(height + noise * rng.standard_normal(height.shape), 0.8)


@pytest.mark.parametrize("angle", [0, 30, 55])
def test_noise_is_found_on_any_slope(angle):
    slope = np.tan(np.deg2rad(angle)) * 0.8 * np.arange(120)
    found = relative_noise(noisy(np.tile(slope, (100, 1)), 0.3), None)
    assert found == pytest.approx(0.3 / 0.8, rel=0.05)


def test_noise_along_rays_that_meet_is_found():
    eye = np.array([40.0, 40.0, 300.0])
    flat = grid(np.zeros((100, 100)), 0.8)
    away = flat - eye
    off = 0.2 * np.random.default_rng(1).standard_normal((100, 100, 1))
    points = flat + off * away / np.linalg.norm(away, axis=-1, keepdims=True)
    assert relative_noise(points, eye) == pytest.approx(0.2 / 0.8, rel=0.05)


def test_a_smooth_grid_is_not_smoothed():
    height = np.tile(-0.001 * np.arange(50.0) ** 2, (50, 1))
    assert smoothing_rounds(relative_noise(grid(height), None)) == 0
    assert smoothing_rounds(relative_noise(grid(np.full((9, 9), np.nan)), None)) == 0


@pytest.mark.parametrize("angle", [0, 45, 60])
def test_noise_makes_no_bridges_of_a_slope(angle):
    # Half a millimetre tilts triangles of 0.8 mm by 40 degrees and more.
    slope = np.tan(np.deg2rad(angle)) * 0.8 * np.arange(80)
    points = noisy(np.tile(slope, (80, 1)), 0.5)
    _, faces, bridges = triangulate(points, STEEP)
    assert bridges < 0.01 * len(faces)


def test_noise_hides_no_bridge():
    height = np.zeros((60, 60))
    height[:, 30:] = -15.0
    points, faces, _ = triangulate(noisy(height, 0.5), STEEP)
    assert np.ptp(points[faces][:, :, 2], axis=1).max() < 8
    assert topology.face_components(len(points), faces).max() >= 1
