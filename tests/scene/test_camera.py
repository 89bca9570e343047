"""Cameras: where points are seen, what fills the picture, and what is no camera."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolerances import ROUNDING

from meshes import moved, plane, pose, sphere
from skinviz import Camera
from skinviz.errors import ArgumentError

UP = [0.0, 1.0, 0.0]
Z = [0.0, 0.0, 1.0]

DIRECTIONS = [Z, [1, 0, 0], [0.3, -0.8, 0.4], [-1, -1, -1e-3], [0, 1e-3, -1]]
UPS = [UP, [0, 0, 1], [0.5, 0.6, 0.1], [0, 1, 0.3], [1, 0, 0]]
POINTS = np.asarray(moved(sphere(40, 2), pose((1, 2, 3), (60, -20, 5))).points)


@pytest.fixture(params=range(len(DIRECTIONS)))
def looking(request):
    """A direction and what is up."""
    return DIRECTIONS[request.param], UPS[request.param]


# Where points are seen ----------------------------------------------------------


@pytest.mark.parametrize("distance", [np.inf, 500.0])
def test_the_axes_are_right_up_and_towards_the_viewer(looking, distance):
    view = Camera(*looking, (64, 48), distance=distance).view(POINTS)
    axes = np.stack([view.right, view.up, view.direction])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1, rel=1e-12)
    direction, up = (np.array(x) / np.linalg.norm(x) for x in looking)
    np.testing.assert_allclose(view.direction, direction, rtol=1e-12, atol=1e-15)
    assert view.up @ up > 0
    assert abs(view.right @ up) < 1e-12


@pytest.mark.parametrize("distance", [np.inf, 500.0, 61.0])
def test_the_target_is_in_the_middle_and_pixels_are_their_size(looking, distance):
    camera = Camera(
        *looking, (64, 48), distance=distance, target=[7, 8, 9], height=24.0
    )
    view = camera.view(POINTS)
    assert view.pixel == pytest.approx(0.5, rel=ROUNDING)
    np.testing.assert_allclose(view.project([7.0, 8, 9]), [32, 24], rtol=1e-12)
    aside = view.target + np.array([[1], [-2], [0.25]]) * view.right + view.up
    np.testing.assert_allclose(
        view.project(aside), [[34, 22], [28, 22], [32.5, 22]], rtol=1e-12
    )


@given(
    depth=st.floats(-1e3, 90),
    across=st.floats(-50, 50),
    along=st.floats(-50, 50),
)
def test_near_cameras_show_what_is_nearer_larger(depth, across, along):
    # By similar triangles with the eye at their tip.
    view = Camera(Z, UP, (10, 10), distance=100.0, target=[1, 2, 3], height=10.0).view(
        POINTS
    )
    point = np.array([1 + across, 2 + along, 3 + depth])
    share = 100 / (100 - depth)
    np.testing.assert_allclose(
        view.project(point),
        [5 + across * share, 5 - along * share],
        rtol=1e-9,
        atol=1e-9,
    )


def test_parallel_rays_show_every_depth_alike():
    view = Camera(Z, UP, (10, 10), target=[1, 2, 3], height=10.0).view(POINTS)
    shown = view.project([[2.0, 3, z] for z in (-1e6, 0.0, 1e6)])
    np.testing.assert_allclose(shown, [[6, 4]] * 3, rtol=1e-9)


def test_far_cameras_come_to_parallel_rays():
    far, parallel = (
        Camera([1, 2, 3], UP, (50, 50), distance=distance).view(POINTS)
        for distance in (1e9, np.inf)
    )
    np.testing.assert_allclose(far.project(POINTS), parallel.project(POINTS), atol=1e-5)


def test_points_on_a_ray_are_seen_in_one_place(looking):
    view = Camera(*looking, (32, 32), distance=300.0).view(POINTS)
    eye, infinite = view.homogeneous[:3], view.homogeneous[3]
    assert infinite == 1
    points = eye + np.array([[0.2], [0.7], [5]]) * (POINTS[17] - eye)
    np.testing.assert_allclose(
        view.project(points), np.tile(view.project(POINTS[17]), (3, 1)), rtol=1e-9
    )


def test_the_eye_is_its_distance_from_the_target(looking):
    near = Camera(*looking, distance=300.0, target=[1, 2, 3]).view(POINTS)
    np.testing.assert_allclose(
        near.homogeneous, [*(np.array([1, 2, 3]) + 300 * near.direction), 1]
    )
    far = Camera(*looking).view(POINTS)
    np.testing.assert_array_equal(far.homogeneous, [*far.direction, 0])


# What fills the picture ---------------------------------------------------------


@pytest.mark.parametrize("size", [(64, 64), (200, 10), (10, 200), (1, 1), (33, 32)])
@pytest.mark.parametrize("distance", [np.inf, 400.0, 130.0])
def test_by_itself_a_picture_shows_the_whole_mesh_with_a_margin(
    looking, size, distance
):
    view = Camera(*looking, size, distance=distance).view(POINTS)
    shown = view.project(POINTS)
    width, height = size
    assert (shown > 0).all()
    assert (shown < [width, height]).all()
    # The margin is 6 %, on the side that touches first.
    off = np.abs(shown - [width / 2, height / 2]).max(axis=0)
    share = (2 * off / [width, height]).max()
    assert share == pytest.approx(1 / 1.06, rel=1e-9)


def test_parallel_views_are_centred_on_what_is_seen(looking):
    shown = Camera(*looking, (64, 64)).view(POINTS).project(POINTS)
    middle = (shown.min(axis=0) + shown.max(axis=0)) / 2
    np.testing.assert_allclose(middle, [32, 32], rtol=1e-9)


def test_a_given_height_is_shown():
    view = Camera(Z, UP, (40, 20), height=7.0).view(POINTS)
    assert view.pixel == pytest.approx(0.35, rel=ROUNDING)


def test_a_given_target_keeps_the_whole_mesh_in_the_picture():
    aside = Camera(Z, UP, (40, 40), target=[100, 0, 0]).view(POINTS)
    shown = aside.project(POINTS)
    assert ((shown > 0) & (shown < 40)).all()
    np.testing.assert_allclose(aside.project([100, 0, 0]), [20, 20])


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1e3, 1e9])
def test_views_scale_with_what_they_show(looking, scale):
    one = Camera(*looking, (30, 20)).view(POINTS)
    other = Camera(*looking, (30, 20)).view(scale * POINTS)
    assert other.pixel == pytest.approx(scale * one.pixel, rel=1e-9)
    np.testing.assert_allclose(
        other.project(scale * POINTS), one.project(POINTS), rtol=1e-9
    )


def test_edge_on_a_flat_thing_is_shown_by_its_width():
    flat = np.asarray(plane(3, 40.0).points)
    view = Camera([1, 0, 0], Z, (20, 20)).view(flat)
    assert view.pixel == pytest.approx(40 * 1.06 / 20, rel=1e-9)


def test_a_point_or_a_line_along_the_view_has_a_picture():
    for points in (np.zeros((1, 3)), np.outer([-1, 0, 2], Z)):
        view = Camera(Z, UP, (4, 4)).view(points)
        np.testing.assert_allclose(view.project(points), 2)


# What is no camera --------------------------------------------------------------


@pytest.mark.parametrize("distance", [-50.0, 0.0, np.nan, 1e-4, 1e10, -np.inf, "far"])
def test_impossible_distances_are_refused(distance):
    with pytest.raises(ArgumentError, match="camera distance"):
        Camera(Z, UP, distance=distance)


@pytest.mark.parametrize("height", [-1.0, 0.0, np.nan, np.inf, 1e10, "all", True])
def test_impossible_heights_are_refused(height):
    with pytest.raises(ArgumentError, match="camera height"):
        Camera(Z, UP, height=height)


@pytest.mark.parametrize("target", [[0, 0], [0, 0, np.nan], [[0, 0, 0]], "middle", 5])
def test_impossible_targets_are_refused(target):
    with pytest.raises(ArgumentError, match="camera target"):
        Camera(Z, UP, target=target)


@pytest.mark.parametrize("distance", [40.0, 39.0, 0.01])
def test_an_eye_among_what_is_to_fill_the_picture_is_refused(distance):
    ball = np.asarray(sphere(40, 3).points)
    camera = Camera(Z, UP, distance=distance)
    with pytest.raises(ArgumentError, match=r"not in front of the whole mesh.*height"):
        camera.view(ball)
    Camera(Z, UP, distance=distance, height=5.0).view(ball)  # says what it shows


def test_numbers_are_kept_as_floats():
    camera = Camera(
        Z, UP, distance=np.float32(80), height=np.int64(5), target=(1, 2, 3)
    )
    assert type(camera.distance) is float
    assert type(camera.height) is float
    assert camera.target.dtype == np.float64
