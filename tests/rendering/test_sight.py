"""What a view and a mesh have in common: the eye, who faces it, blocks of pixels."""

import numpy as np
import pytest

from meshes import faces_of, joined, moved, plane, polydata, pose, sphere
from skinviz import Camera, Plan, geometry_of
from skinviz.rendering import trace
from skinviz.rendering.sight import Sight

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]


def sight_of(mesh, camera):
    geometry = geometry_of(mesh)
    return Sight(geometry, camera.view(geometry.in_mm))


def scattered(n=40, size=1.5):
    """Small triangles here and there, with much nothing between them."""
    rng = np.random.default_rng(8)
    corners = rng.uniform(-50, 50, (n, 1, 3)) + rng.normal(0, size, (n, 3, 3))
    return polydata(corners.reshape(-1, 3), np.arange(3 * n).reshape(n, 3))


CAMERAS = {
    "whole": Camera([0.2, 0.3, 1], UP, (100, 77)),
    "part": Camera([0.2, 0.3, 1], UP, (100, 77), target=[10, 5, 0], height=25.0),
    "near": Camera([0.2, 0.3, 1], UP, (77, 100), distance=200.0),
    "among": Camera([0.2, 0.3, 1], UP, (100, 100), distance=10.0, height=9.0),
    "large": Camera([0.2, 0.3, 1], UP, (1000, 3), target=[10, 5, 0], height=0.3),
    "one pixel": Camera([0.2, 0.3, 1], UP, (1, 1)),
    "away": Camera(Z, UP, (20, 20), target=[900, 0, 0], height=10.0),
}


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("mesh", [scattered(), sphere(40, 1)], ids=["bits", "ball"])
def test_blocks_that_are_left_out_show_nothing(mesh, name):
    sight = sight_of(mesh, CAMERAS[name])
    width, height = sight.view.size
    block, marked = sight.blocks
    pixels = np.arange(width * height)
    hits = trace.cast(sight, Plan().cells, pixels)
    row, column = np.divmod(pixels, width)
    assert not hits.covered[~marked[row // block, column // block]].any()


def test_blocks_leave_out_most_of_nothing():
    sight = sight_of(scattered(), CAMERAS["whole"])
    _, marked = sight.blocks
    assert marked.any()
    assert marked.mean() < 0.3


def test_nothing_is_asked_of_a_view_past_the_mesh():
    assert not sight_of(sphere(40, 1), CAMERAS["away"]).blocks[1].any()


@pytest.mark.parametrize("distance", [np.inf, 90.0])
def test_vertices_face_the_eye_by_their_normals(distance):
    sight = sight_of(sphere(40, 3), Camera(Z, UP, (8, 8), distance=distance))
    z = sight.geometry.in_mm[:, 2]
    # From near, less than half of a sphere is seen: what is above its horizon.
    horizon = 0 if distance == np.inf else 40**2 / distance
    sure = np.abs(z - horizon) > 1.0
    np.testing.assert_array_equal(sight.facing[sure], (z > horizon)[sure])


def test_the_eye_and_frame_are_in_the_meshes_own_size():
    mesh = moved(joined(plane(3), sphere(5, 1)), pose((0.4, 0.1, 2), (1e3, -500, 20)))
    scaled = polydata(1e4 * np.asarray(mesh.points), faces_of(mesh))
    for distance in (np.inf, 300.0):
        one = sight_of(mesh, Camera(Z, UP, (9, 9), distance=distance))
        other = sight_of(scaled, Camera(Z, UP, (9, 9), distance=1e4 * distance))
        np.testing.assert_allclose(one.eye, other.eye, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(one.frame, other.frame, rtol=1e-9, atol=1e-12)
