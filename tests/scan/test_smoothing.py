"""Smoothing takes noise away and nothing else."""

import numpy as np
import pytest

from meshes import faces_of, grid, plane, sphere
from skinviz.scan import topology
from skinviz.scan.grid import triangulate
from skinviz.scan.smoothing import range_noise, smoothed


def test_the_noise_of_a_flat_grid_is_its_standard_deviation():
    height = 0.25 * np.random.default_rng(0).standard_normal((200, 200))
    assert range_noise(height) == pytest.approx(0.25, rel=0.02)
    height[np.random.default_rng(1).random(height.shape) < 0.2] = np.nan
    assert range_noise(height) == pytest.approx(0.25, rel=0.02)


def test_a_curved_grid_has_no_noise():
    x, y = np.meshgrid(*[0.8 * np.arange(-20, 21)] * 2)
    assert range_noise(-(x**2 + y**2) / 60) < 1e-12
    assert range_noise(np.full((5, 5), np.nan)) == 0


def test_a_plane_stays_in_itself():
    tilted = np.array(plane(12).points)
    tilted[:, 2] = 5 + 0.7 * tilted[:, 0] - 0.3 * tilted[:, 1]
    after = smoothed(tilted, faces_of(plane(12)), 9)
    np.testing.assert_allclose(
        after[:, 2], 5 + 0.7 * after[:, 0] - 0.3 * after[:, 1], atol=1e-12
    )


def test_a_sphere_hardly_shrinks():
    points, faces = topology.arrays(sphere(40, 4))
    edge = topology.edge_lengths(points, faces).mean()
    radius = np.linalg.norm(smoothed(points, faces, 8), axis=1)
    # Each round's half way to neighbours an edge away sinks by edge²/(4 radius).
    plain = 8 * edge**2 / (4 * 40)
    assert np.median(abs(radius - 40)) < 0.02 * plain
    assert abs(radius - 40).max() < 0.15 * plain


@pytest.mark.parametrize(("rounds", "most"), [(2, 0.6), (8, 0.3), (30, 0.2)])
def test_noise_goes(rounds, most):
    height = np.random.default_rng(4).standard_normal((60, 60))
    points, faces, _ = triangulate(grid(0.01 * height), np.deg2rad(75))
    after = smoothed(points, faces, rounds)[:, 2].reshape(60, 60)[8:-8, 8:-8]
    assert after.std() < most * 0.01


def test_nothing_crosses_a_cut():
    points, faces = topology.arrays(plane(13))
    points[points[:, 0] > 0, 2] += 9.0
    high = points[faces][:, :, 2] > 5
    apart = faces[high.all(axis=1) | ~high.any(axis=1)]
    after = smoothed(points, apart, 20)
    np.testing.assert_allclose(after[:, 2], points[:, 2], atol=1e-12)


def test_points_of_no_face_stay():
    points, faces = topology.arrays(plane(5))
    far = np.vstack([points, [[100.0, 0, 0]]])
    np.testing.assert_array_equal(smoothed(far, faces, 5)[-1], far[-1])
    assert smoothed(far, faces, 0) is far
