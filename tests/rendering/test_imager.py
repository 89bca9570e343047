"""The light of pixels: closed forms, and the identities that its parts obey."""

import dataclasses

import numpy as np
import pytest
from pixels import places_in_mm, sample_places

from meshes import faces_of, joined, moved, plane, polydata, pose, sphere, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    geometry_of,
    render,
    shade,
)
from skinviz.rendering import painter, trace
from skinviz.rendering.spectral import light_spectra
from skinviz.rendering.stage import stage_of

FLOAT32 = 2.0**-23
"""Radiance is kept as float32; a product of two rounds twice."""

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]

TWO_LIGHTS = (
    DirectionalLight([0.3, 0.2, 1]),
    PointLight([60, 30, 90], "A", 0.7),
)


def glossy(scene, **changes):
    return scene.replace(surface=TorranceSparrow(), **changes)


# Closed forms -------------------------------------------------------------------


@pytest.mark.parametrize("reflectance", [0.0, 0.18, 1.0])
@pytest.mark.parametrize("alpha", [0.3, 1.0])
def test_a_facing_plate_is_its_reflectance_times_the_light(white, reflectance, alpha):
    scene = white.replace(
        skin=Skin(white.skin.model, [reflectance]),
        diffuse_scale=alpha,
        camera=Camera(Z, UP, (6, 5), height=10.0),
        mesh=moved(plane(), pose(shift=(0.1, 0.2, 3))),
    )
    if reflectance == 0:
        with pytest.warns(UserWarning, match="absorbs"):
            picture = render(scene)
    else:
        picture = render(scene)
    expected = alpha * reflectance * light_spectra(scene)[0]
    np.testing.assert_allclose(
        picture.radiance(),
        np.broadcast_to(expected, (5, 6, 61)),
        rtol=3 * FLOAT32,
    )
    np.testing.assert_allclose(picture.xyz[..., 1], alpha * reflectance, rtol=FLOAT32)
    assert (picture.coverage == 1).all()


@pytest.mark.parametrize("degrees", [0, 30, 60, 85, 89.9])
def test_a_plate_darkens_as_the_cosine(white, degrees):
    angle = np.deg2rad(degrees)
    light = DirectionalLight([np.sin(angle), 0, np.cos(angle)])
    camera = Camera([0.2, 0.1, 1], UP, (4, 4), height=8.0)
    picture = render(white.replace(lights=(light,), camera=camera))
    np.testing.assert_allclose(picture.xyz[..., 1], np.cos(angle), rtol=1e-6)


def test_a_convex_white_thing_in_uniform_light_is_white_everywhere(white):
    # Over all directions the mean of max(N·L, 0) is 1/4.
    n = 600
    height = 1 - 2 * (np.arange(n) + 0.5) / n
    turn = np.arange(n) * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), height], 1)
    scene = white.replace(
        mesh=sphere(40, 2),
        camera=Camera([0.3, 0.5, 1], UP, (16, 16)),
        lights=tuple(DirectionalLight(d) for d in directions),
        exposure=4 / n,
    )
    picture = render(scene, Plan(samples=1))
    seen = picture.covered > 0
    assert seen.sum() > 100
    # A spiral of n points integrates a kink to about 1/n.
    np.testing.assert_allclose(picture.xyz[seen][:, 1], 1, atol=2 / n)
    white_light = light_spectra(scene).sum(axis=0) / 4
    np.testing.assert_allclose(
        picture.radiance()[seen], np.tile(white_light, (seen.sum(), 1)), rtol=2 / n
    )


# The analytic sphere ------------------------------------------------------------


def caps(radius, directions, half_width, n):
    """Square pieces of a sphere about directions, each of n × n points."""
    t = np.linspace(-half_width, half_width, n)
    pieces = []
    for direction in directions:
        w = np.asarray(direction) / np.linalg.norm(direction)
        u = np.cross(w, [0.3, 0.9, 0.1])
        u /= np.linalg.norm(u)
        v = np.cross(w, u)
        x, y = (c.ravel()[:, None] for c in np.meshgrid(t, t))
        points = w + x * u + y * v
        points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
        pieces.append(polydata(points, faces_of(plane(n))))
    return joined(*pieces)


def on_sphere(radius, view, cell):
    """Points (h, w, 3) where an orthographic picture's samples meet a sphere at 0.

    NaN where they pass it by.
    """
    plane_points = places_in_mm(view, cell)
    along = plane_points @ view.direction
    aside = plane_points - along[..., None] * view.direction
    with np.errstate(invalid="ignore"):
        depth = np.sqrt(radius**2 - (aside**2).sum(axis=-1))
    return aside + depth[..., None] * view.direction


def shaded_sphere(scene, normals):
    """Radiance (..., bands) of white glossy skin by the surface's own closed form."""
    E = light_spectra(scene)[0]
    L, V = scene.lights[0].direction, scene.camera.direction
    diffuse = np.maximum(normals @ L, 0)
    gloss = scene.surface.evaluate(normals, L, V)
    return (diffuse + gloss)[..., None] * E


def test_a_sphere_is_shaded_as_the_sphere_to_1e_6(white):
    # Pieces of a sphere, so fine (h²/8 = 4e-8) that its facets do not show.
    radius = 40.0
    centres = [
        [0, 0, 1],
        [0.7, 0, 0.7],
        [-0.5, 0.4, 0.8],
        [0.2, -0.8, 0.5],
        [0, 0.9, 0.4],
    ]
    mesh = caps(radius, centres, half_width=0.05, n=181)
    scene = glossy(
        white,
        mesh=mesh,
        lights=(DirectionalLight([0.5, 0.3, 1]),),
        camera=Camera(Z, UP, (150, 150), target=[0, 0, 0], height=82.0),
    )
    plan = Plan(samples=1)
    picture = render(scene, plan)
    points = on_sphere(radius, picture.view, plan.cells[0])
    # Normals of a piece's last rows lack neighbours: compared are those inside.
    unit = points / radius
    centred = np.array(centres) / np.linalg.norm(centres, axis=1, keepdims=True)
    inside = (unit @ centred.T > np.cos(0.045)).any(axis=-1)
    assert (picture.covered[inside] == 1).all()
    assert inside.sum() > 80
    expected = shaded_sphere(scene, unit[inside])
    np.testing.assert_allclose(
        picture.radiance()[inside], expected, rtol=0, atol=1e-6 * expected.max()
    )
    np.testing.assert_allclose(picture.radiance()[inside], expected, rtol=1e-5)


def with_exact_normals(ball):
    """A sphere's geometry whose normals are its radii, not its facets' means."""
    return dataclasses.replace(geometry_of(ball), normals=np.asarray(ball.points) / 40)


def test_a_sphere_comes_nearer_to_the_sphere_as_its_edges_squared(white):
    errors = []
    for subdivisions in (2, 3, 4, 5):
        mesh = sphere(40, subdivisions)
        scene = white.replace(
            mesh=mesh,
            lights=(DirectionalLight([0.5, 0.3, 1]),),
            camera=Camera(Z, UP, (40, 40), target=[0, 0, 0], height=70.0),
        )
        plan = Plan(samples=1)
        picture = render(scene, plan, geometry=with_exact_normals(mesh))
        normals = on_sphere(40.0, picture.view, plan.cells[0]) / 40
        seen = normals[..., 2] > 0.5
        lit = np.maximum(normals[seen] @ scene.lights[0].direction, 0)
        errors.append(np.sqrt(((picture.xyz[seen][:, 1] - lit) ** 2).mean()))
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, atol=0.3)
    assert errors[-1] < 2e-4


@pytest.mark.parametrize("distance", [np.inf, 150.0])
def test_with_exact_normals_every_pixel_is_exact(white, distance):
    # On facets whose corners have a sphere's normals, the normal is the point itself.
    mesh = sphere(40, 2)
    geometry = with_exact_normals(mesh)
    camera = Camera([0.2, 0.4, 1], UP, (32, 32), distance=distance)
    scene = glossy(white, mesh=mesh, camera=camera)
    plan = Plan(samples=1, shadows=False)
    picture = render(scene, plan, geometry=geometry)
    stage = stage_of(scene, plan, geometry)
    # The facet's point is found anew: by the plane through the corners.
    hits = trace.cast(stage.sight, plan.cells, np.arange(32 * 32))
    corners = np.asarray(mesh.points)[faces_of(mesh)[hits.triangles]]
    a, b, c = corners.transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    row, column = np.divmod(hits.pixels, 32)
    view = picture.view
    flat = np.stack([column, row], 1) + plan.cells[0] - 16
    place = (
        view.target
        + view.pixel * flat[:, :1] * view.right
        - view.pixel * flat[:, 1:] * view.up
    )
    if np.isinf(distance):
        away = np.tile(-view.direction, (len(place), 1))
    else:
        away = place - (view.target + distance * view.direction)
    t = ((a - place) * across).sum(1) / (away * across).sum(1)
    points = place + t[:, None] * away
    inner = hits.weights.min(axis=0) > 1e-6
    found = (geometry.centre + geometry.scale * hits.points.T)[inner]
    np.testing.assert_allclose(found, points[inner], rtol=0, atol=40e-12)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    V = -away / np.linalg.norm(away, axis=1, keepdims=True)
    if np.isfinite(distance):
        V = view.target + distance * view.direction - points
        V /= np.linalg.norm(V, axis=1, keepdims=True)
    L = scene.lights[0].direction
    lit = np.maximum(normals @ L, 0) + scene.surface.evaluate(normals, L, V)
    expected = lit[:, None] * light_spectra(scene)[0]
    got = picture.radiance().reshape(-1, 61)[hits.pixels]
    np.testing.assert_allclose(got[inner], expected[inner], rtol=1e-6, atol=1e-12)


# Sums and factors ---------------------------------------------------------------


@pytest.fixture(params=["uniform", "mapped"])
def skin(request, matt):
    """Pigments that are the same everywhere, or differ at each vertex of a sphere."""
    n = sphere(40, 2).n_points
    rng = np.random.default_rng(4)
    shape = (3,) if request.param == "uniform" else (n, 3)
    return Skin(matt.skin.model, rng.uniform(0.001, 0.1, shape))


@pytest.fixture
def ball(matt, skin):
    """A glossy sphere of skin under two lights, one of them near."""
    return glossy(
        matt,
        mesh=sphere(40, 2),
        skin=skin,
        lights=TWO_LIGHTS,
        camera=Camera([0.4, 0.1, 1], UP, (20, 16), distance=300.0),
    )


def test_light_adds(ball):
    both = render(ball).radiance().astype(float)
    alone = [render(ball.replace(lights=(light,))).radiance() for light in TWO_LIGHTS]
    np.testing.assert_allclose(
        both, alone[0] + 0.7 * alone[1], rtol=1e-6, atol=1e-7 * both.max()
    )


@pytest.mark.parametrize("strength", [1e-6, 1e6])
def test_radiance_is_linear_in_a_lights_strength(ball, strength):
    first, second = TWO_LIGHTS
    stronger = dataclasses.replace(second, strength=strength)
    alone = render(ball.replace(lights=(first,))).radiance().astype(float)
    one = render(ball.replace(lights=(first, second))).radiance() - alone
    more = render(ball.replace(lights=(first, stronger))).radiance() - alone
    np.testing.assert_allclose(
        more / strength,
        one / 0.7,
        rtol=0,
        atol=4 * FLOAT32 * (alone.max() / min(strength, 1) + one.max()),
    )


def test_light_of_one_strength_only_sets_the_scale(ball):
    pictures = [
        render(ball.replace(lights=(dataclasses.replace(TWO_LIGHTS[1], strength=s),)))
        for s in (1e-30, 1.0, 1e30)
    ]
    for picture in pictures[1:]:
        np.testing.assert_array_equal(picture.xyz, pictures[0].xyz)


def test_radiance_is_linear_in_the_exposure(ball):
    one, other = (
        render(scene, Plan()) for scene in (ball, ball.replace(exposure=2.0**40))
    )
    np.testing.assert_array_equal(other.radiance(), 2.0**40 * one.radiance())
    np.testing.assert_array_equal(other.xyz, np.float32(2.0**40) * one.xyz)


def test_each_samples_light_counts_the_same(ball, monkeypatch):
    # Sixteen pictures of one sample in each cell have the picture of 16 as their mean.
    whole = render(ball)
    parts = []
    for cell in Plan().cells:
        monkeypatch.setattr(painter, "cells", lambda _, cell=cell: cell[None])
        one = render(ball, Plan(samples=1))
        parts.append((one.radiance(), one.xyz, one.covered))
    light, colours, hit = (
        np.array(part, float).sum(axis=0) for part in zip(*parts, strict=True)
    )
    np.testing.assert_array_equal(hit, whole.covered)
    monkeypatch.undo()
    np.testing.assert_allclose(whole.radiance(), light / 16, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(whole.xyz, colours / 16, rtol=1e-6, atol=1e-12)


# Pigments -----------------------------------------------------------------------


def test_equal_pigments_everywhere_are_uniform_pigments(matt):
    mesh = sphere(40, 2)
    uniform = glossy(matt, mesh=mesh, lights=TWO_LIGHTS, camera=Camera(Z, UP, (20, 20)))
    mapped = uniform.replace(
        skin=Skin(matt.skin.model, np.tile(matt.skin.values, (mesh.n_points, 1)))
    )
    one, each = render(uniform, Plan()), render(mapped, Plan())
    np.testing.assert_allclose(one.radiance(), each.radiance(), rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(one.xyz, each.xyz, rtol=1e-6, atol=1e-12)
    np.testing.assert_array_equal(one.covered, each.covered)


def test_pigments_are_interpolated_over_triangles(white):
    # Reflectance that rises linearly over a plate does so in every pixel.
    mesh = plane(3)
    x = np.asarray(mesh.points)[:, 0]
    plan = Plan(samples=1)
    scene = white.replace(
        mesh=mesh,
        skin=Skin(white.skin.model, (0.5 + x / 100)[:, None]),
        camera=Camera(Z, UP, (32, 8), height=9.0),
    )
    picture = render(scene, plan)
    places = places_in_mm(picture.view, plan.cells[0])
    np.testing.assert_allclose(
        picture.xyz[..., 1], 0.5 + places[..., 0] / 100, rtol=1e-6
    )


# Vertices -----------------------------------------------------------------------


@pytest.mark.parametrize("mapped", [False, True])
@pytest.mark.parametrize("shadows", [False, True])
def test_a_pixel_whose_sample_is_a_vertex_has_its_light(matt, shadows, mapped):
    n, spacing = 33, 1.25
    low = wave(n)
    roof = moved(plane(2, 12.0), pose(shift=(3.1, -4.2, 10)))
    mesh = joined(low, roof)
    rng = np.random.default_rng(6)
    values = rng.uniform(0.001, 0.1, (mesh.n_points, 3) if mapped else 3)
    plan = Plan(samples=1, shadows=shadows)
    # Pixels as wide as the grid's spacing, shifted so that samples fall on its points.
    shift = (plan.cells[0] - 0.5) * spacing * [-1, 1]
    scene = glossy(
        matt,
        mesh=mesh,
        skin=Skin(matt.skin.model, values),
        lights=(DirectionalLight([-0.9, 0.2, 1]), PointLight([40, 90, 80], "A")),
        camera=Camera(Z, UP, (31, 31), target=[*shift, 0], height=31 * spacing),
    )
    picture, shaded = render(scene, plan), shade(scene, plan)
    expected = np.asarray(shaded.point_data["radiance"])[: n * n]
    expected = expected.reshape(n, n, 61)[::-1][1:-1, 1:-1]  # row 0 is the highest y
    z = np.asarray(mesh.points)[: n * n]
    at = picture.view.project(z).reshape(n, n, 2)[::-1][1:-1, 1:-1]
    columns, rows = sample_places((31, 31), plan.cells[0])
    np.testing.assert_allclose(at, np.stack([columns, rows], axis=-1), atol=1e-9)
    # The roof is over some of them; the border of its shadow may be either.
    under = np.abs(z[:, :2] - [3.1, -4.2]).max(axis=1) < 6.01
    free = ~under.reshape(n, n)[::-1][1:-1, 1:-1]
    close = np.isclose(picture.radiance(), expected, rtol=1e-6, atol=1e-9).all(axis=-1)
    assert free.sum() > 800
    assert (close | ~free).mean() > (0.99 if shadows else 0.999999)
    dark = np.asarray(shade(scene, Plan(1)).point_data["radiance"])
    lit = np.asarray(shade(scene, Plan(1, shadows=False)).point_data["radiance"])
    assert (dark != lit).any()
