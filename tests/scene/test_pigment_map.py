"""Maps from points: exact there, between the extremes everywhere, and smooth."""

import numpy as np
import pytest
from hands import coarse_hand

from meshes import faces_of, joined, plane, sphere, toy_hand
from skinviz import landmarks, pigment_map
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan import topology
from skinviz.scan.topology import polydata

BACK, PALM, TIP = [0.2, 0.004, 0.005], [0.05, 0.0, 0.004], [0.08, 0.02, 0.006]


@pytest.fixture(scope="module")
def mapped():
    points = {
        "back": BACK,
        "palm_side": PALM,
        "fingertip": TIP,
        "index_fingertip": BACK,
    }
    return pigment_map(coarse_hand(), points)


def test_it_is_exact_at_the_points(mapped):
    at = landmarks(coarse_hand())
    np.testing.assert_allclose(mapped[at["back"]], BACK, rtol=1e-12)
    np.testing.assert_allclose(mapped[at["palm"]], PALM, rtol=1e-12)
    np.testing.assert_allclose(mapped[at["little_pad"]], PALM, rtol=1e-12)
    np.testing.assert_allclose(mapped[at["ring_fingertip"]], TIP, rtol=1e-12)


def test_a_narrower_name_comes_before_a_wider_one(mapped):
    at = landmarks(coarse_hand())["index_fingertip"]
    np.testing.assert_allclose(mapped[at], BACK, rtol=1e-12)


def test_it_stays_between_the_extremes_and_so_positive(mapped):
    given = np.array([BACK, PALM, TIP])
    assert (mapped >= given.min(axis=0)).all()
    assert (mapped <= given.max(axis=0)).all()


def test_its_slope_is_bounded(mapped):
    # Between neighbours no more than some times what the points themselves ask for.
    points, faces = topology.arrays(coarse_hand())
    edges, _ = topology.edge_counts(faces)
    a, b = edges.T
    rise = np.abs(mapped[a] - mapped[b])[:, 0]
    length = np.linalg.norm(points[a] - points[b], axis=1)
    at = points[list(landmarks(coarse_hand()).values())]
    apart = np.linalg.norm(at[:, None] - at, axis=2)
    nearest = apart[apart > 0].min()
    assert (rise / length).max() < 2 * (BACK[0] - PALM[0]) / nearest


def test_it_has_no_cusp_at_a_point():
    # Beside a cusp the slope would stay as it is on finer meshes, or grow.
    slopes = []
    for n in (21, 41, 81):
        mesh = plane(n, 80.0)
        corner, middle, beside = 0, n * n // 2, n * n // 2 + 1
        found = pigment_map(mesh, {corner: [0.0], n * n - 1: [0.0], middle: [1.0]})
        slopes.append((1 - found[beside, 0]) / (80 / (n - 1)))
    assert slopes[2] < 0.75 * slopes[1] < 0.75**2 * slopes[0] / 0.9


def test_between_two_points_of_a_strip_it_is_a_spline_in_tension():
    # In one dimension the field of least energy is known: see the algebra below.
    length, bend, soft = 80.0, 15.0, 0.05
    x = np.linspace(-100.0, 180.0, 281)
    points = np.stack(
        [np.tile(x, 3), np.repeat([-1.0, 0, 1], x.size), np.zeros(843)], axis=1
    )
    i = (np.arange(2)[:, None] * x.size + np.arange(x.size - 1)).ravel()
    lower = np.stack([i, i + 1, i + 1 + x.size], axis=1)
    upper = np.stack([i, i + 1 + x.size, i + x.size], axis=1)
    mesh = polydata(points, np.concatenate([lower, upper]))
    start, end = x.size + 100, x.size + 180
    found = pigment_map(mesh, {start: [0.0], end: [1.0]})[x.size : 2 * x.size, 0]
    # Odd about the middle, a line and two exponentials between the points, one beyond.
    ratio = np.exp(-length / bend)
    share = 0.5 / (length / bend - 1 + ratio)
    inside = (x >= 0) & (x <= length)
    t = x[inside]
    true = (
        0.5
        + 2 * share / bend * (t - length / 2)
        + share * (np.exp(-t / bend) - np.exp((t - length) / bend))
    )

    def faded(w):
        return np.where(w < soft, np.maximum(w, 0) ** 2 / (2 * soft), w - soft / 2)

    true = faded(true) / (faded(true) + faded(1 - true))
    np.testing.assert_allclose(found[inside], true, atol=0.01)


def test_one_value_everywhere_is_kept():
    found = pigment_map(plane(), {0: BACK, 40: BACK, (20, 20, 0): BACK})
    np.testing.assert_allclose(found, np.broadcast_to(BACK, found.shape), rtol=1e-12)


def test_a_piece_without_a_point_has_what_is_next_to_it():
    mesh = joined(plane(), sphere(2.0, 1, (-20, -20, 3)))
    n = plane().n_points
    found = pigment_map(mesh, {0: [1.0], n - 1: [0.0]})
    assert (found[n:] > 0.8).all()


def test_each_piece_is_spread_over_by_itself():
    mesh = joined(plane(), sphere(2.0, 1, (0, 0, 3)))
    n = plane().n_points
    found = pigment_map(mesh, {0: [1.0], n: [0.25]})
    np.testing.assert_allclose(found[:n], 1.0)
    np.testing.assert_allclose(found[n:], 0.25)


def test_coordinates_go_to_the_nearest_vertex():
    found = pigment_map(plane(), {(-19.5, -19.8, 1.0): [1.0], (20, 20, 0): [0.0]})
    assert found[0] == 1


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ({}, "at least one"),
        ({"bakc": BACK}, "did you mean 'back'"),
        ({999: BACK}, "vertex 999 is none of the mesh's 81"),
        ({-1: BACK}, "vertex -1"),
        ({True: BACK}, "a point must be"),
        ({(0, 0, 60): BACK}, "60 mm from the mesh"),
        ({(0, 0): BACK}, "three coordinates"),
        ({(0, 0, np.nan): BACK}, "three coordinates"),
        ({(0, 0, 0): BACK, 40: PALM}, "same vertex, 40"),
        ({0: BACK, 1: [0.1]}, "as many numbers"),
        ({0: [np.nan]}, "finite"),
        ({0: "dark"}, "numbers"),
    ],
)
def test_what_cannot_be_spread_is_refused(points, message):
    with pytest.raises(ArgumentError, match=message):
        pigment_map(plane(), points)


def test_names_need_a_hand():
    with pytest.raises(MeshError, match="fingers"):
        pigment_map(toy_hand(n_around=36, n_along=45), {"back": BACK})


def test_triangles_too_thin_to_tell_anything_are_refused():
    mesh = plane(21)
    points = np.array(mesh.points)
    points[210:231, 1] = points[189:210, 1] + 1e-7
    with pytest.raises(MeshError, match="too thin"):
        pigment_map(polydata(points, faces_of(mesh)), {0: [1.0], 440: [0.0]})
