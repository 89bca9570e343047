"""What is no hand-sized triangle mesh is refused before any work is done."""

import numpy as np
import pytest
import pyvista as pv

from meshes import cube, joined, plane, sphere, tetrahedron, toy_hand
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan.checks import require_hand_size, require_triangles, wrong_size
from skinviz.scan.scan import MILLIMETRES, Scan, scale_to_millimetres, transform
from skinviz.scan.topology import arrays, polydata


def test_arrays_of_a_triangle_mesh_come_unchanged():
    points, faces = require_triangles(tetrahedron(), "it")
    np.testing.assert_array_equal(points, tetrahedron().points)
    np.testing.assert_array_equal(faces, tetrahedron().regular_faces)


def test_polygons_come_as_triangles():
    points, faces = require_triangles(cube(), "it")
    assert (points.shape, faces.shape) == ((8, 3), (12, 3))


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (pv.PolyData(), "it has no points"),
        (pv.PolyData(np.zeros((5, 3))), "it has 5 points but no faces"),
        (pv.Line(), "but no faces"),
        (polydata(np.array([[0, 0, 0], [1, 0, 0], [0, np.inf, 0.0]]), [[0, 1, 2]]),
         r"it: point 2 is not finite \(1 in all\)"),
    ],
    ids=["empty", "points", "a line", "infinite"],
)  # fmt: skip
def test_what_is_no_triangle_mesh_is_told(mesh, message):
    with pytest.raises(MeshError, match=message):
        require_triangles(mesh, "it")


@pytest.mark.parametrize("size", [81, 200, 599])
def test_hands_of_every_size_are_let_through(size):
    points = np.array([[0.0, 0, 0], [size, 0, 0]])
    require_hand_size(points, "it")


@pytest.mark.parametrize("size", [0.0, 0.2, 79, 601, 2e5])
def test_what_is_no_hand_asks_for_the_unit(size):
    points = np.array([[0.0, 0, 0], [size, 0, 0]])
    with pytest.raises(MeshError, match=r"it is .* mm across.*unit"):
        require_hand_size(points, "it")


@pytest.mark.parametrize("true", MILLIMETRES)
@pytest.mark.parametrize("taken", MILLIMETRES)
def test_a_hand_in_a_wrong_unit_says_which_it_looks_like(true, taken):
    size = 220.0 / MILLIMETRES[true] * MILLIMETRES[taken]  # of a hand 190 mm long
    told = wrong_size(np.array([[0.0, 0, 0], [size, 0, 0]]))
    factor = MILLIMETRES[true] / MILLIMETRES[taken]
    if 80 <= size <= 600:
        assert told is None
    elif factor in (1000, 100, 25.4, 10, 2.54, 0.1, 1 / 25.4, 0.01, 1e6):
        names = {
            "mm": "millimetres",
            "cm": "centimetres",
            "m": "metres",
            "um": "micrometres",
            "inch": "inches",
        }
        # Micrometres read as millimetres are as much too long as millimetres read
        # as metres; the commoner mistake is named.
        if "um" not in (true, taken) or "m" in (true, taken):
            assert told.endswith(f"as if {names[true]} were read as {names[taken]}")
    else:
        assert "mm across" in told


def test_a_size_of_no_unit_names_none():
    told = wrong_size(np.array([[0.0, 0, 0], [1e-9, 0, 0]]))
    assert told.endswith("140 to 230 mm long")


def test_the_size_is_that_of_all_pieces():
    points, _ = arrays(joined(toy_hand(), sphere(10, 1, centre=(0, 0, 900))))
    with pytest.raises(MeshError, match="unit"):
        require_hand_size(points, "it")


@pytest.mark.parametrize("unit", MILLIMETRES)
def test_units_are_what_they_are(unit):
    metres = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "um": 1e-6, "inch": 0.0254}[unit]
    assert scale_to_millimetres(unit, "it") == pytest.approx(1000 * metres, rel=1e-15)


def test_no_unit_lists_the_choices():
    with pytest.raises(MeshError, match=r"it: .*unit= or --unit \(mm, cm, m, um, inch"):
        scale_to_millimetres(None, "it")
    with pytest.raises(ArgumentError, match="unknown unit of length 'MM'"):
        scale_to_millimetres("MM", "it")


def test_scans_compare_by_content_not_by_file():
    mesh = plane()
    assert Scan(mesh=mesh, source="a.ply") == Scan(mesh=mesh, source="b.ply")


def test_a_pose_moves_points_of_any_shape():
    motion = np.array([[0.0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]])
    grid = np.zeros((2, 5, 3))
    grid[..., 0] = 1
    np.testing.assert_array_equal(
        transform(motion, grid), np.broadcast_to([10.0, 21, 30], (2, 5, 3))
    )
