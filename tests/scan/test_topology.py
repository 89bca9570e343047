"""Connectivity and integrals on shapes that are known in closed form."""

import numpy as np
import pytest
import trimesh
from tolerances import ROUNDING

from meshes import cube, joined, moved, plane, pose, sphere, tetrahedron, tube
from skinviz.scan import topology

SHAPES = {
    "sphere": (sphere, 0, 2),
    "tetrahedron": (tetrahedron, 0, 2),
    "tube": (tube, 2, 0),
    "plane": (plane, 1, 1),
}
"""Shape, its boundary loops, its Euler number."""

SOMEWHERE = pose((0.4, -1.1, 2.0), (-500.0, 190.0, 300.0))


@pytest.mark.parametrize("name", SHAPES)
def test_euler_number_and_boundary_loops(name):
    make, n_loops, euler = SHAPES[name]
    points, faces = topology.arrays(make())
    edges, counts = topology.edge_counts(faces)
    assert len(points) - len(edges) + len(faces) == euler
    assert counts.sum() == 3 * len(faces)
    assert len(topology.boundary_loops(faces)) == n_loops
    assert topology.n_non_manifold_edges(faces) == 0


def test_edges_are_those_that_trimesh_finds():
    faces = np.random.default_rng(1).integers(0, 40, (200, 3))
    faces = faces[[len(set(f)) == 3 for f in faces.tolist()]]
    edges, counts = topology.edge_counts(faces)
    expected, n = np.unique(
        np.sort(trimesh.geometry.faces_to_edges(faces), axis=1),
        axis=0,
        return_counts=True,
    )
    np.testing.assert_array_equal(edges, expected)
    np.testing.assert_array_equal(counts, n)


def test_no_faces_have_no_edges_and_no_boundary():
    none = np.zeros((0, 3), dtype=np.int64)
    edges, counts = topology.edge_counts(none)
    assert edges.shape == (0, 2)
    assert counts.size == 0
    assert topology.boundary_loops(none) == []
    assert topology.n_non_manifold_edges(none) == 0


def test_three_faces_on_one_edge_are_not_manifold():
    fins = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert topology.n_non_manifold_edges(fins) == 1
    assert len(topology.boundary_edges(fins)) == 6


def test_loops_come_largest_first_and_are_the_rims():
    points, faces = topology.arrays(joined(tube(n_around=24), tube(10, 50, 60, 8)))
    loops = topology.boundary_loops(faces)
    assert [len(loop) for loop in loops] == [60, 60, 24, 24]
    assert {float(z) for loop in loops for z in points[loop, 2]} == {0.0, 50.0, 100.0}


def test_components_count_the_pieces():
    mesh = joined(sphere(), tube(), tetrahedron())
    points, faces = topology.arrays(mesh)
    labels = topology.face_components(len(points), faces)
    sizes = [sphere().n_cells, tube().n_cells, 4]
    np.testing.assert_array_equal(np.bincount(labels), sizes)
    assert np.unique(np.split(labels, np.cumsum(sizes))[0]).size == 1


def test_component_labels_skip_points_without_faces():
    faces = np.array([[5, 6, 7], [1, 2, 3]])
    labels = topology.face_components(9, faces)
    assert sorted(labels.tolist()) == [0, 1]


def test_compact_keeps_the_surface_and_drops_unused_points():
    points, faces = topology.arrays(sphere(subdivisions=1))
    padded = np.insert(points, [0, 7], np.nan, axis=0)
    moved_to = np.flatnonzero(np.isfinite(padded[:, 0]))
    got_points, got_faces = topology.compact(padded, moved_to[faces])
    np.testing.assert_array_equal(got_points, points)
    np.testing.assert_array_equal(got_faces, faces)


def test_volume_of_a_tetrahedron_is_a_sixth_wherever_it_lies():
    points, faces = topology.arrays(tetrahedron())
    assert topology.enclosed_volume(points, faces) == pytest.approx(
        1 / 6, rel=ROUNDING, abs=0
    )
    away, _ = topology.arrays(moved(tetrahedron(), SOMEWHERE))
    # 500 mm away the points themselves are rounded to 1e-13 mm.
    assert topology.enclosed_volume(away, faces) == pytest.approx(1 / 6, rel=2e-12)


def test_volume_changes_sign_with_the_orientation():
    points, faces = topology.arrays(sphere())
    inside_out = topology.enclosed_volume(points, faces[:, ::-1])
    assert inside_out == pytest.approx(
        -topology.enclosed_volume(points, faces), rel=ROUNDING, abs=0
    )


def test_volume_and_area_approach_the_spheres_as_the_square_of_the_edge():
    gaps = []
    for subdivisions in (2, 3, 4):
        points, faces = topology.arrays(sphere(40, subdivisions))
        volume = topology.enclosed_volume(points, faces)
        area = topology.face_areas(points, faces).sum()
        gaps.append([1 - volume / (4 / 3 * np.pi * 40**3), 1 - area / (np.pi * 80**2)])
    gaps = np.array(gaps)
    assert (gaps > 0).all()
    assert gaps[-1].max() < 0.003
    np.testing.assert_allclose(gaps[:-1] / gaps[1:], 4, rtol=0.05)


def test_area_and_volume_agree_with_trimesh():
    points, faces = topology.arrays(moved(sphere(subdivisions=2), SOMEWHERE))
    other = trimesh.Trimesh(points, faces, process=False)
    assert topology.face_areas(points, faces).sum() == pytest.approx(
        other.area, rel=1e-12
    )
    assert topology.enclosed_volume(points, faces) == pytest.approx(
        other.volume, rel=1e-9
    )


def test_vertex_normals_of_a_sphere_are_radial():
    points, faces = topology.arrays(sphere(40, 4, centre=(5, -3, 2)))
    normals = topology.vertex_normals(points, faces)
    radial = (points - [5, -3, 2]) / 40
    assert np.arccos((normals * radial).sum(axis=1).min()) < np.deg2rad(0.5)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=ROUNDING)


def test_vertex_normals_are_weighted_by_area():
    # Three faces of a cube's corner: one twice as large as the others.
    points = np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2]])
    normal = topology.vertex_normals(points, faces)[0]
    np.testing.assert_allclose(normal, -np.array([1, 2, 2]) / 3, rtol=ROUNDING)


def test_vertex_normals_turn_with_the_mesh():
    points, faces = topology.arrays(tube())
    away, _ = topology.arrays(moved(tube(), SOMEWHERE))
    np.testing.assert_allclose(
        topology.vertex_normals(away, faces),
        topology.vertex_normals(points, faces) @ SOMEWHERE[:3, :3].T,
        atol=1e-12,
    )


def test_a_point_without_area_has_normal_zero():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9], [2, 0, 0]])
    faces = np.array([[0, 1, 2], [1, 4, 4]])
    normals = topology.vertex_normals(points, faces)
    np.testing.assert_array_equal(normals[3:], 0)
    np.testing.assert_array_equal(normals[:3], [[0, 0, 1]] * 3)


def test_polydata_and_arrays_are_each_others_inverse():
    points, faces = topology.arrays(sphere(subdivisions=1))
    again = topology.arrays(topology.polydata(points, faces))
    np.testing.assert_array_equal(again[0], points)
    np.testing.assert_array_equal(again[1], faces)
    assert again[0].dtype == np.float64


def test_a_cube_of_triangles_has_its_area_and_volume():
    points, faces = topology.arrays(cube(3.0).triangulate())
    assert topology.face_areas(points, faces).sum() == pytest.approx(54, rel=1e-6)
    assert topology.enclosed_volume(points, faces) == pytest.approx(27, rel=1e-6)
