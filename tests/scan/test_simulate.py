"""The scanner simulator measures what its laser and its camera both see."""

import numpy as np
import pytest
import pyvista as pv
from scipy import stats

from meshes import (
    cube,
    distance_to,
    joined,
    moved,
    plane,
    pose,
    sphere,
    tetrahedron,
    toy_hand,
    tube,
)
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan.scan import transform
from skinviz.scan.simulate import Scanner, directions_around, simulate_scan
from skinviz.scan.topology import polydata

EXACT = Scanner(
    noise=0.0,
    resolution=0.0,
    spike_fraction=0.0,
    outlier_fraction=0.0,
    pose_shift=0.0,
    pose_tilt=0.0,
)
"""A scanner without faults: what is left is geometry."""

UP = [[0.0, 0.0, 1.0]]


def changed(**values):
    return Scanner(**{**EXACT.__dict__, **values})


def scanned(mesh, directions=UP, scanner=EXACT, seed=0):
    return simulate_scan(mesh, directions, scanner, np.random.default_rng(seed))


def world_points(view):
    return transform(view.pose, view.points[view.valid])


def test_a_seed_gives_the_same_scan_and_another_seed_another():
    first, again, other = (
        scanned(toy_hand(), [[0, 1, 0.2], [0, -1, 0.1]], Scanner(pitch=2.0), seed)
        for seed in (7, 7, 8)
    )
    for a, b, c in zip(first.views, again.views, other.views, strict=True):
        np.testing.assert_array_equal(a.points, b.points)
        np.testing.assert_array_equal(a.pose, b.pose)
        assert not np.array_equal(a.points, c.points, equal_nan=True)
    assert not np.array_equal(first.views[1].pose, other.views[1].pose)


def test_without_faults_every_point_lies_on_the_true_shape():
    mesh = moved(toy_hand(), pose((0.3, 0.8, -0.4), (-524, 190, 296)))
    directions = directions_around(6, (0.2, 0.3, 1), (1, 0, 0))
    scan = scanned(mesh, directions, changed(pitch=1.5))
    assert len(scan.views) == 6
    for view in scan.views:
        points = world_points(view)
        assert len(points) > 500
        assert distance_to(mesh, points).max() < 1e-3


def test_depth_of_a_sphere_is_the_analytic_one():
    view = scanned(sphere(40, 5), [[1, 2, -3]], changed(pitch=1.0)).views[0]
    x, y, z = view.points[view.valid].T
    # Chords of a sphere of 20,480 triangles lie at most 0.03 mm inside it.
    depth = np.sqrt(40**2 - x**2 - y**2) - z
    inside = x**2 + y**2 < 30**2
    assert inside.sum() > 2000
    assert np.abs(depth[inside]).max() < 0.06


def test_the_grid_is_even_and_z_points_to_the_scanner():
    towards = np.array([1.0, -2.0, 0.5]) / np.sqrt(5.25)
    view = scanned(sphere(), [towards], changed(pitch=2.0)).views[0]
    rotation = view.pose[:3, :3]
    np.testing.assert_allclose(rotation[:, 2], towards, atol=1e-12)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)
    steps_x = np.diff(view.points[..., 0], axis=1)
    steps_y = np.diff(view.points[..., 1], axis=0)
    np.testing.assert_allclose(steps_x[np.isfinite(steps_x)], 2.0, rtol=1e-9)
    np.testing.assert_allclose(steps_y[np.isfinite(steps_y)], 2.0, rtol=1e-9)


@pytest.mark.parametrize("turn", [0.0, np.pi / 2, np.pi, 3 * np.pi / 2])
def test_a_point_that_the_camera_does_not_see_is_absent(turn):
    # A wall stands on a floor: with camera and laser 45° apart its shadow is as
    # wide as the wall is high, on the side away from the camera.
    height = 20.0
    wall = polydata(
        np.array([[0.0, -30, 0], [0, 30, 0], [0, 30, height], [0, -30, height]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    mesh = moved(joined(plane(41, 80.0), wall), pose((0, 0, turn)))
    laser, both = (
        scanned(mesh, UP, changed(pitch=0.5, triangulation_angle=angle)).views[0]
        for angle in (0.0, np.pi / 4)
    )
    assert not (both.valid & ~laser.valid).any()
    # The camera stands off along the sensor's x; the wall's normal is world x.
    across, along = pose((0, 0, turn))[:3, :2].T
    lean = laser.pose[:3, 0] @ across
    points = transform(laser.pose, laser.points[laser.valid])
    lost = ~both.valid[laser.valid]
    if abs(lean) < 0.5:  # the camera looks along the wall: nothing is hidden
        assert not lost.any()
        return
    behind = -np.sign(lean) * (points @ across)
    beside = np.abs(points @ along)
    dark = (beside < 29.5) & (behind > 0.5) & (behind < height - 0.5)
    light = (beside > 30.5) | (behind < -0.5) | (behind > height + 0.5)
    assert dark.sum() > 4000
    assert lost[dark].all()
    assert not lost[light].any()


def test_back_faces_are_not_returned():
    # Looking into the open end of a tube along its axis shows only its inside.
    askew = scanned(tube(20, 60), [[0.3, 0, 1.0]], changed(pitch=0.5)).views[0]
    points = world_points(askew)
    assert len(points) > 100
    outward = points[:, :2] / np.linalg.norm(points[:, :2], axis=1, keepdims=True)
    towards = np.array([0.3, 0.0]) / np.hypot(0.3, 1.0)
    assert (outward @ towards > 0).all()
    reverse = polydata(plane().points, np.asarray(plane().regular_faces)[:, ::-1])
    assert not scanned(reverse).views[0].valid.any()


@pytest.mark.parametrize("limit", [30, 60, 75])
def test_returns_end_at_the_largest_incidence(limit):
    scanner = changed(pitch=0.7, max_incidence=np.deg2rad(limit), triangulation_angle=0)
    view = scanned(sphere(40, 5), UP, scanner).views[0]
    x, y, _ = view.points[view.valid].T
    incidence = np.rad2deg(np.arcsin(np.hypot(x, y) / 40))
    assert incidence.max() == pytest.approx(limit, abs=2)
    assert incidence.max() < limit + 1.5


def test_rays_from_a_point_reach_a_sphere_where_geometry_says():
    distance, radius = 300.0, 40.0
    # Fine enough that its faces lie within 6 µm of the sphere.
    shape = sphere(radius, 6)
    scanner = changed(pitch=1.5, distance=distance, triangulation_angle=0.0)
    view = scanned(shape, UP, scanner).views[0]
    np.testing.assert_array_equal(view.eye, [0, 0, distance])
    points = view.points[view.valid]
    # A ray's direction follows from its cell: the grid is even where z is 0.
    away = (points - view.eye) / np.linalg.norm(points - view.eye, axis=1)[:, None]
    cross = (view.eye + away * (-distance / away[:, 2:])) / scanner.pitch
    step = cross[:, :2] - cross[0, :2]
    np.testing.assert_allclose(step, np.round(step), atol=1e-4)
    # The nearer root of |eye + t·away| = radius.
    along = -away[:, 2] * distance
    t = along - np.sqrt(along**2 - distance**2 + radius**2)
    expected = view.eye + t[:, None] * away
    incidence = np.einsum("ij,ij->i", -away, expected) / radius
    inner = incidence > 0.5
    assert inner.sum() > 1000
    np.testing.assert_allclose(points[inner], expected[inner], atol=0.02)


@pytest.mark.parametrize("angle", [15, 30])
def test_a_shadow_from_a_baseline_is_as_wide_as_similar_triangles_say(angle):
    # A wall of height h at x = 0 hides floor from a camera at x = ±b and height D.
    height, distance = 20.0, 400.0
    wall = polydata(
        np.array([[0.0, -30, 0], [0, 30, 0], [0, 30, height], [0, -30, height]]),
        np.array([[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]]),
    )
    turn = pose((0, 0, np.pi / 2))  # across the sensor's x
    mesh = moved(joined(plane(41, 160.0), wall), turn)
    scanner = changed(
        pitch=0.5, distance=distance, triangulation_angle=np.deg2rad(angle)
    )
    view = scanned(mesh, UP, scanner).views[0]
    origin = np.asarray(mesh.points).mean(axis=0)
    rise = distance + origin[2]  # of laser and camera above the floor
    camera = view.pose[:3, 3] + view.pose[:3, :3] @ [scanner.baseline, 0, distance]
    assert scanner.baseline == pytest.approx(distance * np.tan(np.deg2rad(angle)))
    camera = transform(np.linalg.inv(turn), camera)
    assert abs(camera[0]) == pytest.approx(scanner.baseline)
    points = transform(np.linalg.inv(turn), world_points(view))
    floor = points[(np.abs(points[:, 2]) < 0.01) & (np.abs(points[:, 1]) < 25)]
    behind = -np.sign(camera[0]) * floor[:, 0]
    shadow = height * abs(camera[0]) / (rise - height)
    seen = behind[behind > 0.5]
    assert seen.min() == pytest.approx(shadow, abs=1.0)


def test_noise_grows_with_the_square_of_the_range():
    noise, distance = 0.05, 300.0
    low = moved(plane(5, 60.0), pose(shift=(0, 0, -60.0)))
    mesh = joined(plane(5, 20.0), low)
    options = {"pitch": 0.25, "distance": distance, "triangulation_angle": 0.0}
    clean = scanned(mesh, UP, changed(**options)).views[0]
    noisy = scanned(mesh, UP, changed(**options, noise=noise), seed=5).views[0]
    error = np.linalg.norm(noisy.points - clean.points, axis=-1)
    reach = np.linalg.norm(clean.points - clean.eye, axis=-1)
    cosine = (clean.eye - clean.points)[..., 2] / reach
    middle = np.asarray(mesh.points)[:, 2].mean()
    variances = []
    for z in (0.0, -60.0):
        at = np.abs(clean.points[..., 2] + middle - z) < 1
        scaled = error[at] * cosine[at] / (noise * (reach[at] / distance) ** 2)
        total = (scaled**2).sum()
        spread = stats.chi2(at.sum())
        assert at.sum() > 1000
        assert spread.ppf(5e-4) < total < spread.isf(5e-4)
        variances.append((error[at] ** 2).mean())
    assert variances[1] > 1.5 * variances[0]


def test_dark_and_slanted_returns_below_the_threshold_are_lost():
    shape = sphere(40, 5)
    dark = np.asarray(shape.points)[:, 0] < 0
    shape.point_data["albedo"] = np.where(dark, 0.2, 0.8)
    scanner = changed(pitch=0.5, triangulation_angle=0.0, min_return=0.4)
    view = scanned(shape, UP, scanner).views[0]
    x, y, _ = world_points(view).T
    assert x.min() > -2.0  # one face's width: albedo is interpolated over it
    # 0.8 cos θ = 0.4 at 60 degrees.
    assert np.hypot(x, y).max() == pytest.approx(40 * np.sin(np.pi / 3), abs=1.0)
    white = scanned(sphere(40, 5), UP, scanner).views[0]
    assert white.valid.sum() > 2 * view.valid.sum()


@pytest.mark.parametrize("albedo", [-0.1, 1.1, np.nan])
def test_an_impossible_albedo_is_refused(albedo):
    shape = sphere(40, 2)
    shape.point_data["albedo"] = np.full(shape.n_points, albedo)
    with pytest.raises(ArgumentError, match="albedo"):
        scanned(shape)


def test_a_scanner_inside_its_object_is_refused():
    with pytest.raises(ArgumentError, match="twice the object's radius"):
        scanned(sphere(40, 2), UP, changed(distance=79.0))


def test_noise_grows_as_one_over_the_cosine():
    noise = 0.05
    shape = sphere(40, 5)
    clean = scanned(shape, UP, changed(pitch=0.4)).views[0].points
    noisy = scanned(shape, UP, changed(pitch=0.4, noise=noise), seed=11).views[0].points
    error = (noisy - clean)[..., 2]
    cosine = np.sqrt(1 - (clean[..., 0] ** 2 + clean[..., 1] ** 2) / 40**2)
    bands = [(1.0, 0.9), (0.9, 0.75), (0.75, 0.6), (0.6, 0.45), (0.45, 0.32)]
    level = 1 - 0.99 ** (1 / len(bands))  # Šidák
    for high, low in bands:
        at = (cosine <= high) & (cosine > low) & np.isfinite(error)
        scaled = error[at] * cosine[at] / noise
        # The faces' own cosine differs from the sphere's by at most 1.5 %.
        spread = stats.chi2(at.sum() - 1)
        variance = scaled.var(ddof=1) * (at.sum() - 1)
        assert spread.ppf(level / 2) * 0.97 < variance < spread.isf(level / 2) * 1.03
        assert abs(scaled.mean()) < 5 / np.sqrt(at.sum())


def test_fractions_of_zero_leave_the_range_untouched():
    quiet = changed(pitch=1.0, spike=50.0, pose_shift=0.0)
    plain = scanned(toy_hand(), [[0, 1, 0]], quiet, seed=1).views[0].points
    other = scanned(toy_hand(), [[0, 1, 0]], quiet, seed=2).views[0].points
    np.testing.assert_array_equal(plain, other)


def test_outliers_are_the_share_that_is_asked_for():
    shape = plane(5, 60.0)
    tilted = moved(shape, pose((0.3, 0, 0)))
    clean = scanned(tilted, UP, changed(pitch=0.3)).views[0]
    stray = scanned(tilted, UP, changed(pitch=0.3, outlier_fraction=0.05)).views[0]
    off = np.abs(stray.points[..., 2] - clean.points[..., 2]) > 1e-6
    n, k = clean.valid.sum(), off.sum()
    assert stats.binomtest(int(k), int(n), 0.05).pvalue > 1e-3
    heights = clean.points[..., 2][clean.valid]
    strays = stray.points[..., 2][off]
    assert heights.min() <= strays.min() <= strays.max() <= heights.max()


def test_spikes_stand_only_beside_depth_edges():
    low = moved(plane(5, 60.0), pose(shift=(0, 0, -30.0)))
    mesh = joined(plane(5, 30.0), low)
    always = changed(pitch=0.5, spike_fraction=1.0, triangulation_angle=0.0)
    clean = scanned(mesh, UP, changed(pitch=0.5, triangulation_angle=0.0)).views[0]
    spiky = scanned(mesh, UP, always).views[0]
    off = np.abs(spiky.points[..., 2] - clean.points[..., 2]) > 1e-6
    z = np.where(clean.valid, clean.points[..., 2], -1e9)
    padded = np.pad(z, 1, constant_values=-1e9)
    neighbours = [
        padded[:-2, 1:-1],
        padded[2:, 1:-1],
        padded[1:-1, :-2],
        padded[1:-1, 2:],
    ]
    jump = np.max([np.abs(z - n) for n in neighbours], axis=0) > 5
    np.testing.assert_array_equal(off, jump & clean.valid)
    lengths = (spiky.points - clean.points)[..., 2][off]
    assert np.abs(lengths).mean() == pytest.approx(2.0, rel=0.3)
    assert 0.3 < (lengths > 0).mean() < 0.7


def test_range_is_rounded_to_the_resolution():
    view = scanned(sphere(), UP, changed(resolution=0.25)).views[0]
    z = view.points[..., 2][view.valid]
    np.testing.assert_array_equal(z, np.round(z / 0.25) * 0.25)


def test_the_first_pose_is_exact_and_others_err_as_stated():
    n = 200
    directions = np.tile([[1.0, 2.0, 0.5]], (n, 1))
    scanner = changed(pitch=30.0, pose_shift=0.5, pose_tilt=0.01)
    views = scanned(sphere(40, 1), directions, scanner, seed=3).views
    exact = scanned(sphere(40, 1), directions[:1], changed(pitch=30.0)).views[0].pose
    np.testing.assert_array_equal(views[0].pose, exact)
    shifts = np.array([v.pose[:3, 3] - exact[:3, 3] for v in views[1:]])
    turns = np.array([v.pose[:3, :3] @ exact[:3, :3].T for v in views[1:]])
    axes = np.stack(
        [
            (turns[:, 2, 1] - turns[:, 1, 2]) / 2,
            (turns[:, 0, 2] - turns[:, 2, 0]) / 2,
            (turns[:, 1, 0] - turns[:, 0, 1]) / 2,
        ],
        axis=1,
    )
    for values, sigma in ((shifts.ravel(), 0.5), (axes.ravel(), 0.01)):
        spread = stats.chi2(values.size)
        total = (values**2).sum() / sigma**2
        assert spread.ppf(1e-3) < total < spread.isf(1e-3)


def test_directions_go_around_the_axis_in_even_steps():
    axis = np.array([1.0, 2.0, -0.5])
    directions = directions_around(8, axis, (0, 0, 1))
    along = axis / np.linalg.norm(axis)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, rtol=1e-12)
    lean = np.rad2deg(np.arcsin(directions @ along))
    np.testing.assert_allclose(lean, [-10, 35] * 4, rtol=1e-9)
    across = directions - np.outer(directions @ along, along)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    turns = (across * np.roll(across, -1, axis=0)).sum(axis=1)
    np.testing.assert_allclose(turns, np.cos(np.pi / 4), rtol=1e-9)
    first = np.array([0, 0, 1]) - along[2] * along
    np.testing.assert_allclose(across[0], first / np.linalg.norm(first), atol=1e-12)


@pytest.mark.parametrize(
    ("n", "axis", "start"),
    [
        (2, (0, 0, 1), (1, 0, 0)),
        (5, (0, 0, 0), (1, 0, 0)),
        (5, (0, 0, 1), (0, 0, 3)),
        (5, (0, 0, 1), (np.nan, 0, 0)),
        (5, (0, 1), (1, 0, 0)),
    ],
)
def test_impossible_rings_of_directions_are_refused(n, axis, start):
    with pytest.raises(ArgumentError):
        directions_around(n, axis, start)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("pitch", 0),
        ("pitch", np.nan),
        ("triangulation_angle", -0.1),
        ("triangulation_angle", 1.2),
        ("max_incidence", 1.7),
        ("noise", -1),
        ("distance", 0),
        ("distance", np.nan),
        ("min_return", 1.5),
        ("resolution", -1e-3),
        ("spike", np.inf),
        ("spike_fraction", 1.5),
        ("outlier_fraction", -0.1),
        ("pose_shift", -1),
        ("pose_tilt", "0.3 deg"),
    ],
)
def test_an_impossible_scanner_is_refused_by_name(name, value):
    spaced = name.replace("_", "[_ ]")
    with pytest.raises(ArgumentError, match=spaced):
        Scanner(**{name: value})


@pytest.mark.parametrize("direction", [(0, 0, 0), (0, np.nan, 1), (0, 1)])
def test_an_impossible_direction_is_refused(direction):
    with pytest.raises(ArgumentError):
        scanned(sphere(), [direction])


def test_triangles_without_area_are_passed_over():
    points = np.asarray(tetrahedron().points) * 30
    faces = np.asarray(tetrahedron().regular_faces)
    mesh = polydata(points, np.concatenate([faces, [[0, 1, 1], [2, 2, 2]]]))
    got = scanned(mesh, [[1, 1, 1]]).views[0].points
    np.testing.assert_array_equal(
        got, scanned(polydata(points, faces), [[1, 1, 1]]).views[0].points
    )


def test_quadrilaterals_are_scanned_as_their_triangles():
    shape = cube(40.0)
    got = scanned(shape, [[1, 2, 3]]).views[0].points
    expected = scanned(shape.triangulate(), [[1, 2, 3]]).views[0].points
    np.testing.assert_allclose(got, expected, atol=1e-9)


@pytest.mark.parametrize(
    "mesh",
    [
        pv.PolyData(),
        pv.PolyData(np.zeros((4, 3))),
        polydata(np.full((3, 3), np.nan), np.array([[0, 1, 2]])),
    ],
    ids=["empty", "points only", "NaN"],
)
def test_what_is_no_triangle_mesh_is_refused(mesh):
    with pytest.raises(MeshError):
        scanned(mesh)
