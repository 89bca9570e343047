"""Outlines: wherever the rays of a pixel may differ, and on convex things only there.

The oracle is the rays themselves: all sixteen of every pixel.
"""

import numpy as np
import pytest

from meshes import (
    cube,
    faces_of,
    joined,
    moved,
    plane,
    polydata,
    pose,
    sphere,
    tetrahedron,
    toy_hand,
    tube,
    without_faces,
)
from skinviz import Camera, Plan, geometry_of
from skinviz.rendering import trace
from skinviz.rendering.outlines import edges_of, facing_triangles, outline_pixels
from skinviz.rendering.sight import Sight

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]


def sight_of(mesh, camera):
    geometry = geometry_of(mesh)
    return Sight(geometry, camera.view(geometry.in_mm))


def hits_of(sight):
    """How many of each pixel's sixteen rays meet the mesh (h, w), and which faces.

    The faces are (h, w, 16), -1 where a ray meets none, or the back of one.
    """
    width, height = sight.view.size
    hits = trace.cast(sight, Plan().cells, np.arange(width * height))
    faces = np.full(width * height * 16, -1)
    faces[hits.rays] = hits.triangles
    return hits.covered.reshape(height, width), faces.reshape(height, width, 16)


def holed_sphere():
    """A sphere without a quarter of its faces, here and there."""
    ball = sphere(40, 3)
    return without_faces(ball, np.random.default_rng(3).random(ball.n_faces) < 0.25)


def fan():
    """Five triangles about one edge, which is no manifold."""
    turn = 2 * np.pi * np.arange(5) / 5 + 0.1
    rim = np.stack([20 * np.cos(turn), 20 * np.sin(turn), 3 * turn], axis=1)
    points = np.concatenate([[[0.0, 0, -25], [0.0, 0, 25]], rim])
    return polydata(points, [[0, 1, 2 + i] for i in range(5)])


def triangle():
    return polydata(np.array([[0.0, 0, 0], [31, 7, 4], [9, 26, -5]]), [[0, 1, 2]])


def slivers():
    """Triangles thinner than a pixel, at all angles."""
    rng = np.random.default_rng(2)
    start, way = rng.uniform(-40, 40, (60, 3)), rng.normal(0, 20, (60, 3))
    corners = np.stack([start, start + way, start + way / 2 + 0.05], axis=1)
    return polydata(corners.reshape(-1, 3), np.arange(180).reshape(60, 3))


MESHES = {
    "sphere": lambda: sphere(40, 3),
    "coarse": lambda: sphere(40, 0),
    "tube": tube,
    "hand": toy_hand,
    "holes": holed_sphere,
    "fan": fan,
    "triangle": triangle,
    "plane": plane,
    "slivers": slivers,
    "two": lambda: joined(sphere(30, 2), sphere(20, 2, (10, 25, 40))),
    "shell": lambda: joined(holed_sphere(), sphere(25, 2)),
}


def cameras(extent, rng):
    """Far and near, of the whole and of parts, some of them past the mesh's rim."""
    direction, up = rng.normal(size=(2, 3))
    some = rng.uniform(-0.6, 0.6, 3) * extent
    yield Camera(direction, up, (48, 37))
    yield Camera(direction, up, (37, 48), distance=2.5 * extent)
    yield Camera(direction, up, (40, 40), target=some, height=0.4 * extent)
    yield Camera(
        *(direction, up, (40, 40), 2.2 * extent), target=some, height=0.3 * extent
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", MESHES)
def test_every_pixel_filled_in_part_is_marked(name, seed):
    rng = np.random.default_rng([seed, *name.encode()])
    mesh = moved(MESHES[name](), pose(rng.uniform(-3, 3, 3), rng.uniform(-50, 50, 3)))
    points = np.asarray(mesh.points)
    points = points - points.mean(axis=0)
    mesh = polydata(points, faces_of(mesh))
    extent = np.linalg.norm(points, axis=1).max()
    partly = 0
    for camera in cameras(extent, rng):
        sight = sight_of(mesh, camera)
        covered, _ = hits_of(sight)
        edge = (covered > 0) & (covered < 16)
        assert sight.outlines[edge].all()
        partly += edge.sum()
    assert partly > 20


def hang_together(faces, met):
    """Whether the faces met (k,) hang together by the corners of some faces (m, 3)."""
    reached, size = set(faces[met[0]].tolist()), 0
    while len(reached) > size:
        size = len(reached)
        touched = np.isin(faces, list(reached)).any(axis=1)
        reached |= set(faces[touched].ravel().tolist())
    return np.isin(faces[met], list(reached)).any(axis=1).all()


@pytest.mark.parametrize("name", ["hand", "two", "shell"])
def test_every_pixel_that_sees_two_sheets_is_marked(name):
    # Sheets: what hangs together of the faces that reach into the pixel.
    mesh = MESHES[name]()
    sight = sight_of(mesh, Camera([1, -0.2, -1.5], [0.1, 1, 0], (40, 40)))
    _, met = hits_of(sight)
    faces = sight.geometry.faces
    corners = sight.places[faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    sheets = 0
    for row, column in np.argwhere((met >= 0).all(axis=2)):
        place = np.array([column, row])
        here = (
            sight.front & (low <= place + 1).all(axis=1) & (high >= place).all(axis=1)
        )
        own = np.unique(np.searchsorted(np.flatnonzero(here), met[row, column]))
        if not hang_together(faces[here], own):
            assert sight.outlines[row, column]
            sheets += 1
    assert sheets > 5


def test_with_the_eye_among_the_points_all_is_marked():
    camera = Camera([0.2, 0.3, 1], UP, (30, 20), distance=10.0, height=9.0)
    sight = sight_of(sphere(40, 1), camera)
    assert sight.outlines.shape == (20, 30)
    assert sight.outlines.all()


def test_a_view_past_the_mesh_has_no_outlines():
    camera = Camera(Z, UP, (20, 20), target=[900, 0, 0], height=10.0)
    assert not sight_of(sphere(40, 1), camera).outlines.any()


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (50, 1)])
def test_narrow_pictures_are_marked_too(size):
    sight = sight_of(tetrahedron(), Camera([0.3, 0.2, 1], UP, size))
    covered, _ = hits_of(sight)
    edge = (covered > 0) & (covered < 16)
    assert edge.any()
    assert sight.outlines[edge].all()


# Not more than need be ----------------------------------------------------------


@pytest.mark.parametrize("distance", [np.inf, 150.0])
@pytest.mark.parametrize("subdivisions", [1, 3, 5])
def test_a_closed_convex_mesh_marks_only_its_rim(subdivisions, distance):
    camera = Camera([0.3, -0.2, 1], UP, (90, 80), distance=distance)
    sight = sight_of(sphere(40, subdivisions), camera)
    covered, _ = hits_of(sight)
    # Next to a marked pixel there is one that some rays miss.
    missed = np.pad(covered < 16, 1, constant_values=True)
    near = np.zeros_like(covered, dtype=bool)
    for row in range(3):
        for column in range(3):
            near |= missed[row : row + 80, column : column + 90]
    assert near[sight.outlines].all()
    found = np.pad(covered > 0, 1)
    around = np.zeros_like(near)
    for row in range(3):
        for column in range(3):
            around |= found[row : row + 80, column : column + 90]
    assert around[sight.outlines].all()
    assert sight.outlines.sum() < 700


def test_a_cube_seen_face_on_marks_its_square():
    sight = sight_of(cube(30.0).triangulate(), Camera(Z, UP, (60, 60)))
    # From the middle of its square no pixel is marked, though edges cross there.
    assert not sight.outlines[10:50, 10:50].any()
    assert 150 < sight.outlines.sum() < 300


def test_an_edge_marks_the_pixels_that_a_line_goes_through():
    # A slow line: many points, each in a pixel.
    rng = np.random.default_rng(5)
    for _ in range(200):
        ends = rng.uniform(-15, 45, (2, 2))
        edges = np.array([[0, 1, 0, -1]], dtype=np.int32)
        marked = outline_pixels(ends, edges, np.array([True]), (30, 25))
        steps = np.linspace(0, 1, 4000)[:, None]
        line = ends[0] + steps * (ends[1] - ends[0])
        crossed = np.zeros((25, 30), dtype=bool)
        column, row = np.floor(line).astype(int).T
        inside = (column >= 0) & (column < 30) & (row >= 0) & (row < 25)
        crossed[row[inside], column[inside]] = True
        assert marked[crossed].all()
        # And no further than a margin from the line.
        rows, columns = np.nonzero(marked & ~crossed)
        for r, c in zip(rows, columns, strict=True):
            away = np.maximum(np.abs(line - [c + 0.5, r + 0.5]) - 0.5, 0).max(axis=1)
            assert away.min() < 0.06


# Edges --------------------------------------------------------------------------


def slow_edges(faces):
    """Each edge with its triangles, by a dictionary."""
    found = {}
    for f, face in enumerate(faces.tolist()):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            found.setdefault((min(a, b), max(a, b)), []).append(f)
    rows = []
    for (low, high), own in found.items():
        pairs = zip(own[::2], [*own[1::2], -1], strict=False)
        rows += [(low, high, f, g) for f, g in pairs]
    return sorted(rows)


@pytest.mark.parametrize("name", MESHES)
def test_edges_are_those_of_a_dictionary(name):
    mesh = MESHES[name]()
    faces = faces_of(mesh).astype(np.int32)
    found = edges_of(faces, mesh.n_points)
    assert sorted(map(tuple, found.tolist())) == slow_edges(faces)


@pytest.mark.parametrize("seed", range(8))
def test_edges_of_any_triangles_are_those_of_a_dictionary(seed):
    # Few vertices and many triangles: edges of up to ten, triangles twice over.
    rng = np.random.default_rng(seed)
    corners = [rng.permutation(7)[:3] for _ in range(4 * seed)]
    faces = np.array(corners, dtype=np.int32).reshape(-1, 3)
    found = edges_of(faces, 7)
    assert sorted(map(tuple, found.tolist())) == slow_edges(faces)


def test_a_closed_mesh_has_three_edges_for_two_faces():
    ball = sphere(40, 3)
    edges = edges_of(faces_of(ball).astype(np.int32), ball.n_points)
    assert len(edges) == 3 * ball.n_faces // 2
    assert (edges[:, 3] >= 0).all()


# Facing -------------------------------------------------------------------------


@pytest.mark.parametrize("w", [0.0, 1.0])
def test_faces_that_face_the_eye_are_seen_from_outside(w):
    mesh = sphere(40, 2)
    points, faces = np.asarray(mesh.points), faces_of(mesh)
    eye = np.array([120.0, -40.0, 70.0])
    a, b, c = points[faces].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    expected = ((eye - w * a) * across).sum(axis=1) > 0
    faces = faces.astype(np.int32)
    found = facing_triangles(points, faces, np.array([*eye, w]))
    np.testing.assert_array_equal(found, expected)
    turned = facing_triangles(points, faces[:, ::-1].copy(), np.array([*eye, w]))
    np.testing.assert_array_equal(turned, ~expected)


def test_triangles_without_an_area_face_nobody():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 0, 3], [0, 1, 3]], dtype=np.int32)
    for z, last in ((1.0, True), (-1.0, False)):
        found = facing_triangles(points, faces, np.array([0, 0, z, 0.0]))
        assert found.tolist() == [False, False, last]
