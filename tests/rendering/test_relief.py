"""Fine relief: the slope of a height field, and light that stays sane."""

import numpy as np
import pytest
from planned_scenes import hand

from meshes import sphere, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    Relief,
    SkinTexture,
    TorranceSparrow,
    render,
    textured,
)
from skinviz.rendering.engraving import FURROW, engrave
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.tolerance import compare
from skinviz.scene.kernels import all_ridges

UP, START, SEED = np.array([0.0, 0, 1]), np.array([0.3, -2.2, 5.7]), 3


def ridges_at(points):
    """F2 − F1 of points (n, 3) and its gradients."""
    values, slopes = np.zeros(len(points)), np.zeros(points.shape)
    all_ridges(np.ascontiguousarray(points), SEED, values, slopes)
    return values, slopes


def height(points, depth):
    """The surface's height at points (n, 3), in units of the cells."""
    return -depth * np.exp(-np.square(ridges_at(points)[0] / FURROW))


def engraved(points, normals, depth, step=1.0):
    """Normals (n, 3) after the relief is on them."""
    flat = np.ascontiguousarray(normals.T)
    engrave(np.ascontiguousarray(points.T), flat, START, step, depth, SEED)
    return flat.T


@pytest.fixture(scope="module")
def places():
    """Many places on the plane z = 0."""
    x = np.random.default_rng(1).uniform(-50, 50, (20000, 3))
    x[:, 2] = 0
    return x


def test_ridges_have_the_gradients_that_differences_have(places):
    steps, (values, slopes) = 1e-6 * np.eye(3), ridges_at(places)
    assert (values >= 0).all()
    found = [
        (ridges_at(places + h)[0] - ridges_at(places - h)[0]) / 2e-6 for h in steps
    ]
    error = np.abs(np.stack(found, axis=1) - slopes).max(axis=1)
    assert np.quantile(error, 0.999) < 1e-6  # but where one point takes over


def test_furrows_are_as_close_as_cells_are(places):
    # Along a line, a wall about every cell: one scattered point in each unit cube.
    line = np.zeros((20001, 3))
    line[:, 0] = np.linspace(0, 1000, 20001)
    values = ridges_at(line)[0]
    low = (values[1:-1] < values[:-2]) & (values[1:-1] < values[2:])
    assert 700 < (low & (values[1:-1] < 0.1)).sum() < 1800


def test_normals_are_those_of_the_height_field(places):
    depth, h = 0.05, 1e-6
    found = engraved(places, np.broadcast_to(UP, places.shape), depth)
    at = START + places
    slope = np.stack(
        [
            (height(at + h * e, depth) - height(at - h * e, depth)) / (2 * h)
            for e in np.eye(3)[:2]
        ],
        axis=1,
    )
    true = np.concatenate([-slope, np.ones((len(slope), 1))], axis=1)
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    error = np.linalg.norm(found - true, axis=1)
    assert np.quantile(error, 0.999) < 1e-6
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, rtol=1e-12)


def test_the_light_on_a_height_field_is_what_falls_on_its_ground(places):
    # For any field: the mean of N'·L / N'·N is N·L where nothing is in its own shade.
    light = np.array([0.5, 0.2, 0.8])
    found = engraved(places, np.broadcast_to(UP, places.shape), 0.05)
    falling = found @ light / (found @ UP)
    assert falling.min() > 0
    np.testing.assert_allclose(falling.mean(), light @ UP, rtol=0.01)


def test_it_moves_with_nothing_but_place(places):
    # A mesh in its own coordinates and one in mm have the same relief.
    found = engraved(places, np.broadcast_to(UP, places.shape), 0.05)
    other = engraved(places / 8, np.broadcast_to(UP, places.shape), 0.05, step=8.0)
    np.testing.assert_allclose(found, other, atol=1e-9)


def test_no_depth_is_the_same_picture(matt):
    smooth = render(matt, Plan(samples=1))
    other = render(matt.replace(relief=Relief(0.0, 2.0, 5)), Plan(samples=1))
    np.testing.assert_array_equal(smooth.xyz, other.xyz)


def test_a_relief_is_a_seeds_and_leaves_the_outline(matt):
    ball = matt.replace(mesh=sphere(20, 4), relief=Relief(80, 3.0, 1))
    one, same = render(ball, Plan(samples=4)), render(ball, Plan(samples=4))
    other = render(ball.replace(relief=Relief(80, 3.0, 2)), Plan(samples=4))
    np.testing.assert_array_equal(one.xyz, same.xyz)
    np.testing.assert_array_equal(one.covered, other.covered)
    assert np.abs(one.xyz - other.xyz).max() > 0.01


def test_the_mean_brightness_hardly_changes(matt):
    lit = matt.replace(lights=(DirectionalLight([0.5, 0.2, 0.8]),))
    smooth = render(lit, Plan(samples=16)).xyz[..., 1].mean()
    rough = render(lit.replace(relief=Relief(40, 1.0)), Plan(samples=16)).xyz[..., 1]
    np.testing.assert_allclose(rough.mean(), smooth, rtol=0.03)
    assert rough.std() > 0.005 * smooth


def test_no_pixel_is_black_or_dazzling_where_the_viewer_grazes(matt):
    # The normals of many points face away from a viewer at 85 degrees.
    seen = matt.replace(
        surface=TorranceSparrow(),
        relief=Relief(100, 1.0),
        camera=Camera([np.sin(1.48), 0, np.cos(1.48)], [0, 1, 0], (64, 64)),
    )
    picture = render(seen, Plan(samples=1))
    filled = picture.covered == picture.rays
    own = picture.xyz[..., 1][filled]
    smooth = render(seen.replace(relief=Relief()), Plan(samples=1)).xyz[..., 1][filled]
    assert np.isfinite(own).all()
    assert own.min() > 0.6 * smooth.min()
    assert own.max() < 1.5 * smooth.max()


def test_light_at_the_zenith_leaves_no_black_point(matt):
    hills = matt.replace(mesh=wave(33), relief=Relief(100, 1.0))
    own = render(hills, Plan(samples=1))
    filled = own.covered == own.rays
    smooth = render(hills.replace(relief=Relief()), Plan(samples=1))
    assert (own.xyz[..., 1][filled] > 0.5 * smooth.xyz[..., 1][filled]).all()


@pytest.mark.parametrize("tolerance", [0.5, 2.0])
def test_plans_keep_their_tolerance_on_uneven_skin(model, tolerance):
    texture = SkinTexture(
        melanin_mottling=0.3, mottling_mm=8, relief_um=60, relief_mm=2.0, seed=2
    )
    scene = textured(hand(model), texture)
    exact = render(scene, Plan())
    found = render(scene, tolerance=tolerance)
    told = compare(found.xyz, exact.xyz, exact.covered, white_xyz(scene))
    assert told.kept(tolerance)


@pytest.mark.parametrize(
    ("amounts", "message"),
    [
        ((-1.0, 1.0, 0), "relief depth must be in .0, 500. µm"),
        ((10.0, 0.0, 0), "relief spacing must be in"),
        ((10.0, 1.0, 0.5), "seed must be a whole number"),
        ((float("nan"), 1.0, 0), "relief depth"),
    ],
)
def test_what_no_skin_has_is_refused(amounts, message):
    with pytest.raises(ValueError, match=message):
        Relief(*amounts)
