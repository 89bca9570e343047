"""Edges of things: no dark rims, and as much of a pixel as the thing covers."""

import dataclasses

import numpy as np
import pytest
from pixels import places_in_mm

from meshes import polydata, sphere
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    TorranceSparrow,
    geometry_of,
    render,
)

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]


SIDE_LIGHTS = [[1.0, 0, 0], [-0.6, 0.8, 0], [1, 0.2, -0.3], [0.1, -1, -0.5]]


def cosine_on_a_sphere(picture, light):
    """The mean over each pixel's samples (h, w) of max(N·L, 0) on a sphere of 40 mm.

    NaN where a sample passes the sphere.
    """
    seen = []
    for cell in picture.plan.cells:
        places = places_in_mm(picture.view, cell)
        with np.errstate(invalid="ignore"):
            places[..., 2] = np.sqrt(40**2 - places[..., 0] ** 2 - places[..., 1] ** 2)
        seen.append(np.maximum(places @ light / 40, 0))
    return np.mean(seen, axis=0)


@pytest.mark.parametrize("direction", SIDE_LIGHTS)
@pytest.mark.parametrize("subdivisions", [0, 1, 2, 3])
def test_no_rim_is_darker_than_the_sphere(white, subdivisions, direction):
    # A facet is nearer to the picture's plane than the sphere above it, so with the
    # radius for a normal it faces light from aside or behind more than the sphere does.
    mesh = sphere(40, subdivisions)
    light = DirectionalLight(direction)
    camera = Camera(Z, UP, (48, 48), target=[0, 0, 0], height=84.0)
    radii = dataclasses.replace(geometry_of(mesh), normals=np.asarray(mesh.points) / 40)
    picture = render(
        white.replace(mesh=mesh, camera=camera, lights=(light,)), geometry=radii
    )
    whole = picture.covered == 16
    least = cosine_on_a_sphere(picture, light.direction)
    assert np.count_nonzero(least[whole] > 0.3) > 20
    assert (picture.xyz[whole][:, 1] >= least[whole] - 1e-6).all()


def test_rims_lit_from_the_eye_are_as_dark_as_the_cosine_says_and_no_darker(white):
    camera = Camera(Z, UP, (96, 96), target=[0, 0, 0], height=84.0)
    picture = render(white.replace(mesh=sphere(40, 4), camera=camera))
    whole = picture.covered == 16
    cosine = cosine_on_a_sphere(picture, np.array(Z))[whole]
    assert cosine.min() < 0.2
    # Facets lie up to h²/8 deep: at the rim that is √(2 h²/8) of the cosine.
    np.testing.assert_allclose(picture.xyz[whole][:, 1], cosine, atol=0.03)
    assert (picture.xyz[whole] > 0).all()


def test_gloss_makes_no_dark_or_blinding_rims(white):
    dull = white.replace(mesh=sphere(40, 2), camera=Camera(Z, UP, (64, 64)))
    shiny = dull.replace(surface=TorranceSparrow())
    for direction in (Z, *SIDE_LIGHTS[:2]):
        lights = (DirectionalLight(direction),)
        bright = render(shiny.replace(lights=lights)).xyz
        plain = render(dull.replace(lights=lights)).xyz
        assert (bright >= plain).all()
        assert bright.max() < 3


def test_coverage_sums_to_the_area_of_a_disc(white):
    picture = render(
        white.replace(mesh=sphere(40, 5), camera=Camera(Z, UP, (100, 100)))
    )
    area = picture.coverage.astype(float).sum() * picture.view.pixel**2
    assert area == pytest.approx(np.pi * 40**2, rel=1e-3)


@pytest.mark.parametrize("samples", [1, 2, 4, 8, 16])
def test_coverage_sums_to_the_area_of_a_triangle(white, samples):
    corners = np.array([[0.0, 0, 0], [31, 7, 0], [9, 26, 0]])
    scene = white.replace(
        mesh=polydata(corners, [[0, 1, 2]]), camera=Camera(Z, UP, (80, 60))
    )
    picture = render(scene, Plan(samples))
    area = picture.coverage.astype(float).sum() * picture.view.pixel**2
    assert area == pytest.approx((31 * 26 - 7 * 9) / 2, rel=0.01)
    # All of what is covered is lit, none of the rest: a pixel's light is its share.
    np.testing.assert_allclose(picture.xyz[..., 1], picture.coverage, rtol=1e-6)


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (7, 1), (300, 2)])
def test_pictures_of_any_shape_show_the_whole_mesh(white, size):
    picture = render(white.replace(camera=Camera(Z, UP, size)))
    assert picture.xyz.shape == (size[1], size[0], 3)
    assert picture.radiance().shape == (size[1], size[0], 61)
    area = picture.coverage.astype(float).sum() * picture.view.pixel**2
    assert area == pytest.approx(40.0**2, rel=0.35)
    assert np.isfinite(picture.xyz).all()
