"""Distances along surfaces whose geodesics are known in closed form."""

import numpy as np

from meshes import joined, plane, sphere, tube
from skinviz.scan.topology import polydata
from skinviz.scene.geodesics import surface_of


def test_on_a_sphere_it_is_the_great_circle():
    mesh = sphere(40.0, 4)
    points = np.asarray(mesh.points) / 40
    found = surface_of(mesh).distances([7])[0]
    true = 40 * np.arccos(np.clip(points @ points[7], -1, 1))
    assert np.abs(found - true).max() < 0.03 * true.max()


def test_round_a_tube_it_goes_round_not_through():
    mesh = tube(20.0, 100.0)
    found = surface_of(mesh).distances([0])[0]
    away = np.asarray(mesh.points) - np.array([-20.0, 0, 0])
    opposite = np.argmin(np.linalg.norm(away, axis=1))
    np.testing.assert_allclose(found[opposite], 20 * np.pi, rtol=0.05)


def test_another_piece_is_infinitely_far():
    mesh = joined(plane(), sphere(5.0, 2, (0, 0, 30)))
    found = surface_of(mesh).distances([3])[0]
    assert np.isfinite(found[: plane().n_points]).all()
    assert np.isinf(found[plane().n_points :]).all()
    assert found[3] == 0


def test_flat_triangles_and_stray_points_do_no_harm():
    good = plane()
    points = np.concatenate([np.asarray(good.points), [[0, 0, 99.0]]])
    faces = np.concatenate([good.regular_faces, [[0, 1, 1], [2, 3, 4]]])
    surface = surface_of(polydata(points, faces))
    found = surface.distances([3, len(points) - 1])
    np.testing.assert_allclose(found[0, :-1], surface_of(good).distances([3])[0])
    assert found[1, -1] == 0
    assert np.isinf(found[1, :-1]).all()
