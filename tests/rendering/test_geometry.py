"""Meshes made ready: what is kept of them, what is refused; size is nothing."""

import numpy as np
import pytest
import pyvista as pv
from tolerances import ROUNDING

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
)
from skinviz import Camera, Plan, geometry_of, render, shade
from skinviz.errors import MeshError
from skinviz.scan.topology import arrays


def with_points(mesh, points):
    """The mesh with more points, which no triangle uses."""
    return polydata(np.concatenate([mesh.points, points]), faces_of(mesh))


def with_faces(mesh, faces):
    """The mesh with more faces."""
    return polydata(np.asarray(mesh.points), np.concatenate([faces_of(mesh), faces]))


# Coordinates --------------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-300, 1e-3, 1.0, 1e6, 1e300])
def test_a_mesh_fills_a_cube_of_side_2_whatever_its_size(size):
    mesh = moved(cube(3.0), pose((0.3, 0.2, 0.1), (50, -20, 3)))
    points = np.asarray(mesh.points) * size
    geometry = geometry_of(polydata(points, arrays(mesh.triangulate())[1]))
    low, high = geometry.points.min(axis=0), geometry.points.max(axis=0)
    np.testing.assert_allclose(high, -low, rtol=1e-12)
    assert high.max() == pytest.approx(1, rel=ROUNDING)
    np.testing.assert_allclose(geometry.in_mm, points, rtol=1e-12, atol=0)


def test_homogeneous_points_keep_their_place():
    geometry = geometry_of(moved(sphere(40, 1), pose(shift=(7, -3, 500))))
    point = np.array([1.0, 2, 490])
    inside = geometry.within(np.array([*point, 1.0]))
    np.testing.assert_allclose(
        geometry.centre + geometry.scale * inside[:3], point, rtol=ROUNDING
    )
    direction = np.array([0.6, 0, 0.8, 0])
    np.testing.assert_array_equal(geometry.within(direction), direction)


def test_the_centroid_is_that_of_the_surface_not_of_the_points():
    fine, coarse = plane(21, 20.0), moved(plane(2, 20.0), pose(shift=(60, 0, 9)))
    geometry = geometry_of(joined(fine, coarse))
    centroid = geometry.centre + geometry.scale * geometry.centroid
    np.testing.assert_allclose(centroid, [30, 0, 4.5], rtol=1e-12, atol=1e-12)


def test_normals_are_the_means_of_their_triangles_by_area():
    normals = geometry_of(tetrahedron()).normals
    third = -1 / np.sqrt(3)
    np.testing.assert_allclose(normals[0], [third] * 3, rtol=ROUNDING)
    # Of twice the areas there: (0, 0, -1), (0, -1, 0) and (1, 1, 1).
    np.testing.assert_allclose(normals[1], [1, 0, 0], rtol=ROUNDING, atol=1e-15)


# Inside and outside -------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e5])
def test_a_closed_surface_goes_round_what_is_inside_once(size):
    geometry = geometry_of(moved(sphere(size, 2), pose((1, 2, 3), (size, 0, 0))))
    rng = np.random.default_rng(0)
    for direction in rng.normal(size=(20, 3)):
        unit = direction / np.linalg.norm(direction)
        assert geometry.winding(0.9 * unit) == pytest.approx(1, abs=1e-12)
        assert geometry.winding(1.1 * unit) == pytest.approx(0, abs=1e-12)


def test_an_inside_out_surface_goes_round_the_other_way():
    mesh = sphere(40, 1)
    turned = polydata(np.asarray(mesh.points), faces_of(mesh)[:, ::-1])
    assert geometry_of(turned).winding(np.zeros(3)) == pytest.approx(-1, abs=1e-12)


def test_an_open_surface_goes_round_by_the_solid_angle_that_it_fills():
    # From the middle of a cube one of its faces fills a sixth of the sphere.
    face = moved(plane(2, 2.0), pose(shift=(0, 0, 1)))
    geometry = geometry_of(face)
    centre = (np.zeros(3) - geometry.centre) / geometry.scale
    assert abs(geometry.winding(centre)) == pytest.approx(1 / 6, rel=1e-12)


# Size and place -----------------------------------------------------------------


def picture(scene, mesh):
    camera = Camera([0.3, 0.2, 1], [0, 1, 0], (24, 24))
    return render(scene.replace(mesh=mesh, camera=camera), Plan(samples=4))


@pytest.mark.parametrize("power", [-600, -27, -10, 7, 20, 600])
def test_pictures_do_not_depend_on_the_unit(white, power):
    # By powers of 2 nothing rounds: the pictures are the same to the last bit.
    mesh = sphere(40, 2)
    scaled = polydata(np.asarray(mesh.points) * 2.0**power, faces_of(mesh))
    one, other = picture(white, mesh), picture(white, scaled)
    np.testing.assert_array_equal(one.xyz, other.xyz)
    np.testing.assert_array_equal(one.radiance(), other.radiance())


@pytest.mark.parametrize("shift", [1e3, 1e6])
def test_pictures_do_not_depend_on_the_place(white, shift):
    mesh = sphere(40, 2)
    far = moved(mesh, pose(shift=(shift, -2 * shift, 3 * shift)))
    one, other = picture(white, mesh), picture(white, far)
    np.testing.assert_array_equal(one.covered, other.covered)
    np.testing.assert_allclose(one.xyz, other.xyz, rtol=1e-6)


# What is broken -----------------------------------------------------------------


def test_points_without_triangles_change_nothing(white):
    mesh = sphere(40, 2)
    strays = with_points(
        mesh, [[1e3, 2e3, -50], [-1e300, 0, 1], [1e308, 1e308, -1e308]]
    )
    one, other = picture(white, mesh), picture(white, strays)
    np.testing.assert_array_equal(one.xyz, other.xyz)
    diffuse = {"interreflection": "diffuse"}
    np.testing.assert_array_equal(
        one.xyz, picture(white.replace(**diffuse), strays).xyz
    )


def test_points_without_triangles_have_no_colour(white):
    strays = with_points(plane(), [[1, 2, 3]])
    with pytest.raises(MeshError, match=r"vertex 81 belongs to no triangle .* clean"):
        shade(white.replace(mesh=strays))


def test_triangles_without_area_change_nothing(white):
    mesh = sphere(40, 2)
    empty = np.array([[0, 0, 0], [5, 5, 7], [8, 9, 8], [3, 3, 3]])
    one, other = picture(white, mesh), picture(white, with_faces(mesh, empty))
    np.testing.assert_array_equal(one.xyz, other.xyz)
    np.testing.assert_array_equal(one.covered, other.covered)


def test_needles_are_drawn_or_missed_but_never_nan(white):
    rng = np.random.default_rng(5)
    points = np.repeat(rng.uniform(-20, 20, (40, 1, 3)), 3, axis=1)
    points[:, 1] += rng.normal(0, 20, (40, 3))
    points[:, 2] = points[:, 1] + rng.normal(0, 1e-9, (40, 3))
    needles = polydata(points.reshape(-1, 3), np.arange(120).reshape(-1, 3))
    mesh = joined(needles, plane())
    seen = picture(white, mesh)
    assert np.isfinite(seen.xyz).all()
    assert np.isfinite(seen.radiance()).all()
    assert (seen.xyz >= 0).all()


@pytest.mark.parametrize(
    ("mesh", "told"),
    [
        (pv.PolyData(), "has no points"),
        (pv.PolyData(np.eye(3)), "no faces"),
        (polydata(np.diag([np.nan, 1, 1]), [[0, 1, 2]]), "point 0 is not finite"),
        (polydata(np.diag([1, np.inf, 1]), [[0, 1, 2]]), "not finite"),
        (with_points(plane(), [[np.nan, 0, 0]]), "point 81 is not finite"),
        (polydata(np.ones((3, 3)), [[0, 1, 2]]), "no extent"),
        (polydata(np.eye(3), [[0, 0, 0]]), "no extent"),
        (polydata(np.outer([0.0, 1, 2], [1, 2, 3]), [[0, 1, 2]]), "no triangle"),
        (polydata(np.eye(3), [[0, 0, 1], [2, 1, 2]]), "no triangle"),
    ],
    ids=[
        "empty",
        "points",
        "NaN",
        "infinite",
        "stray NaN",
        "a point",
        "one corner",
        "a line",
        "edges",
    ],
)
def test_what_has_no_surface_is_refused(mesh, told):
    with pytest.raises(MeshError, match=told):
        geometry_of(mesh)
