"""Cast shadows: exact borders, the law of distance, no acne and no leaks."""

import dataclasses

import numpy as np
import pytest
from pixels import places_in_mm

from meshes import joined, moved, plane, pose, sphere, toy_hand, tube
from skinviz import Camera, DirectionalLight, Plan, PointLight, render, shade
from skinviz.rendering import trace
from skinviz.rendering.stage import stage_of

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]
ONE = Plan(samples=1)


def luminance(scene, plan=ONE):
    return render(scene, plan).xyz[..., 1].astype(float)


def floor(scene, *others, size=100.0, n=3):
    """The scene with a floor at z = 0 and other things, seen straight from above."""
    return scene.replace(
        mesh=joined(plane(n, size), *others),
        camera=Camera(Z, UP, (60, 60), target=[0, 0, 0], height=80.0),
    )


def plate(side, place, turn=(0.0, 0.0, 0.0)):
    return moved(plane(2, side), pose(turn, place))


# Borders ------------------------------------------------------------------------


@pytest.mark.parametrize("turned_over", [False, True])
@pytest.mark.parametrize("degrees", [30, 55])
def test_the_shadow_of_a_plate_in_parallel_light_is_the_plate_moved(
    white, degrees, turned_over
):
    # It throws the same shadow whichever side it turns to the light.
    height, side = 12.0, 9.0
    flip = (np.pi, 0, 0) if turned_over else (0, 0, 0)
    tangent = np.tan(np.deg2rad(degrees))
    light = DirectionalLight([tangent, 0, 1])
    scene = floor(white, plate(side, (20, 3, height), flip)).replace(lights=(light,))
    picture = render(scene, ONE)
    x, y, _ = np.moveaxis(places_in_mm(picture.view, ONE.cells[0]), -1, 0)
    past = np.maximum(np.abs(x - 20 + height * tangent), np.abs(y - 3)) - side / 2
    on_plate = np.maximum(np.abs(x - 20), np.abs(y - 3)) < side / 2 + 1e-3
    on_floor = ~on_plate & (np.abs(past) > 1e-3)
    lit = picture.xyz[..., 1] > 0
    np.testing.assert_array_equal(lit[on_floor], past[on_floor] > 0)
    assert (past[on_floor] < 0).sum() > 20
    np.testing.assert_allclose(
        picture.xyz[on_floor & lit][:, 1], np.cos(np.deg2rad(degrees)), rtol=1e-6
    )


def test_the_shadow_of_a_plate_in_near_light_is_its_projection(white):
    height, side, position = 12.0, 9.0, np.array([25.0, -10, 50])
    scene = floor(white, plate(side, (6, 3, height))).replace(
        lights=(PointLight(position),)
    )
    picture = render(scene, ONE)
    places = places_in_mm(picture.view, ONE.cells[0])
    # Where the way to the light crosses the height of the plate.
    crossing = places + (height / position[2]) * (position - places)
    past = np.abs(crossing[..., :2] - [6, 3]).max(axis=-1) - side / 2
    on_plate = np.abs(places[..., :2] - [6, 3]).max(axis=-1) < side / 2 + 1e-3
    on_floor = ~on_plate & (np.abs(past) > 1e-3)
    lit = picture.xyz[..., 1] > 0
    np.testing.assert_array_equal(lit[on_floor], past[on_floor] > 0)
    assert (past[on_floor] < 0).sum() > 20


def test_half_covered_pixels_have_half_the_light(white):
    # The edge of the shadow through pixels of 16 samples: its share is what is dark.
    half = moved(plane(2, 200.0), pose(shift=(100 + 0.4, 0, 12)))
    scene = floor(white, half).replace(lights=(DirectionalLight([1, 0, 1]),))
    picture = render(scene)
    x = np.stack(
        [places_in_mm(picture.view, cell)[..., 0] for cell in picture.plan.cells]
    )
    over = x > 0.4
    shadow = (x > 0.4 - 12) & ~over
    expected = np.where(shadow, 0, np.sqrt(0.5)).mean(axis=0)
    np.testing.assert_allclose(picture.xyz[..., 1], expected, atol=1e-6)
    assert ((expected > 0.01) & (expected < 0.7)).any()


def test_without_shadows_nothing_is_hidden(white):
    scene = floor(white, plate(9.0, (0, 0, 12)))
    lit = luminance(
        scene.replace(lights=(DirectionalLight([1, 0, 1]),)), Plan(1, False)
    )
    np.testing.assert_allclose(lit, np.sqrt(0.5), rtol=1e-6)


def test_shadows_only_take_light_away(matt):
    scene = matt.replace(
        mesh=toy_hand(80.0, 24, 30),
        camera=Camera([0, 1, 0], Z, (60, 60)),
        lights=(DirectionalLight([0.9, 0.4, 0.3]), PointLight([60, 40, 90], "A")),
    )
    dark, bright = render(scene).xyz, render(scene, Plan(shadows=False)).xyz
    assert (dark <= bright).all()
    assert (dark < 0.9 * bright).any()


# Distance -----------------------------------------------------------------------


@pytest.mark.parametrize("distance", [30.0, 200.0, 5000.0])
def test_near_light_falls_with_the_square_of_its_distance(white, distance):
    scene = floor(white)
    position = np.array([5.0, -3.0, distance])
    places = places_in_mm(
        scene.camera.view(np.asarray(scene.mesh.points)), ONE.cells[0]
    )
    towards = position - places
    squared = (towards**2).sum(axis=-1)
    at_centroid = (position**2).sum()
    expected = towards[..., 2] / np.sqrt(squared) * at_centroid / squared
    # Strength is that of a plate at the centroid that faces the light.
    got = luminance(scene.replace(lights=(PointLight(position),)))
    np.testing.assert_allclose(got, expected, rtol=1e-6)


def test_near_light_has_its_strength_at_the_centroid_of_the_surface(white):
    # Of plates of 400 and 100 mm², 50 mm apart, the centroid is 10 mm from the larger.
    mesh = joined(plane(2, 20.0), plate(10.0, (50, 0, 0)))
    position = np.array([10.0, 0, 30])
    scene = white.replace(
        mesh=mesh,
        lights=(PointLight(position),),
        camera=Camera(Z, UP, (5, 1), target=[0, 0, 0], height=1.0),
    )
    picture = render(scene, ONE)
    squared = ((position - places_in_mm(picture.view, ONE.cells[0])) ** 2).sum(axis=-1)
    expected = 30.0**2 / squared * 30 / np.sqrt(squared)
    np.testing.assert_allclose(picture.xyz[..., 1], expected, rtol=1e-6)


@pytest.mark.parametrize(("distance", "rtol"), [(1e6, 3e-4), (1e9, 3e-7)])
def test_near_light_from_far_is_far_light(white, distance, rtol):
    direction = np.array([0.6, 0, 0.8])
    scene = floor(white, plate(9.0, (10, 3, 12)), sphere(7, 3, centre=(-15, 8, 9)))
    scene = scene.replace(camera=Camera([0.3, 0.1, 1], UP, (60, 60)))
    near, far = (
        luminance(scene.replace(lights=(light,)))
        for light in (PointLight(distance * direction), DirectionalLight(direction))
    )
    same = np.isclose(near, far, rtol=rtol, atol=rtol)
    assert same.mean() > (0.995 if distance < 1e9 else 0.999)


def test_what_is_behind_a_light_does_not_hide_it(white):
    # Two plates that face each other with a light between them.
    roof = moved(plane(2, 100.0), pose((np.pi, 0, 0), (0, 0, 20)))
    scene = floor(white, roof)
    aside = Camera(
        [0, -1, 0.05], Z, (20, 4), target=[0, -50.5, 1], height=1.0, distance=200.0
    )
    scene = scene.replace(camera=aside)
    for position in ([0, 0, 9], [0, 0, 19.99], [20, 3, 0.5]):
        light = PointLight(position)
        lit = luminance(scene.replace(lights=(light,)))
        assert (lit > 0).any()
        seen = shade(scene.replace(lights=(light,)), ONE).point_data["radiance"]
        assert (np.asarray(seen) > 0).any(axis=1).all()
    above = PointLight([0, 0, 20.01])
    seen = shade(scene.replace(lights=(above,)), ONE).point_data["radiance"]
    assert not np.asarray(seen).any()


def test_a_light_on_the_skin_is_no_nan(white):
    for position in ([0.0, 0, 0], [3.7, 1.2, 0], [3.7, 1.2, 1e-12]):
        scene = floor(white, plate(9.0, (30, 0, 12)))
        lights = (DirectionalLight(Z), PointLight(position, strength=1e-3))
        lit = luminance(scene.replace(lights=lights))
        assert np.isfinite(lit).all()
        assert (lit >= 0).all()


# Terminators --------------------------------------------------------------------


def terminator(scene):
    """N·L at the points that face the light, and whether it is found to be seen."""
    stage = stage_of(scene, ONE)
    width, height = scene.camera.size
    hits = trace.cast(stage.sight, ONE.cells, np.arange(width * height))
    seen = trace.visibility(
        *(stage.geometry, stage.bands.lighting, hits.lifted, hits.normals, hits.facets)
    )[0]
    light = stage.bands.lighting.lights[0]
    towards = light[:3, None] - light[3] * hits.points
    cosine = (hits.normals * towards).sum(axis=0) / np.linalg.norm(towards, axis=0)
    return cosine, seen.astype(bool)


ROUND = {
    **{f"sphere {n}": sphere(40, n) for n in range(5)},
    "tube": moved(tube(20, 60, 12, 3), pose((0.4, 0.2, 0))),
    "far sphere": sphere(40, 2, centre=(1e5, -3e4, 7e4)),
    "small sphere": sphere(1e-4, 2),
}


@pytest.mark.parametrize("view", [Z, [0.3, 0.2, 1], [1, -1, 0.4]])
@pytest.mark.parametrize("light", [[1, 0.1, 0.2], [1, -0.3, 0], [0.2, 0.9, -0.4]])
@pytest.mark.parametrize("name", ROUND)
def test_a_round_thing_throws_no_shadow_on_its_own_lit_side(white, name, light, view):
    scene = white.replace(
        mesh=ROUND[name],
        camera=Camera(view, UP, (64, 64)),
        lights=(DirectionalLight(light),),
    )
    cosine, seen = terminator(scene)
    facing = cosine > 0
    assert facing.sum() > 100
    if name == "tube":  # open: light goes out through its ends and sides
        assert seen[facing].mean() > 0.99
    else:
        assert seen[facing].all()
    assert not seen[cosine < -1e-9].any()


@pytest.mark.parametrize("gap", [5.0, 40.0])
def test_a_round_thing_throws_no_shadow_on_its_own_side_of_a_near_light(white, gap):
    light = PointLight([40 + gap, 3, 5])
    for n in (2, 3, 4):
        scene = white.replace(
            mesh=sphere(40, n), camera=Camera(Z, UP, (64, 64)), lights=(light,)
        )
        cosine, seen = terminator(scene)
        # Within what a facet sinks beneath the sphere, nothing is sure.
        assert seen[cosine > 0.25 / 2**n].all()


@pytest.mark.parametrize("direction", [[0, 1, 0.01], [0.3, 1, 0.02], [1, 0.2, 1e-3]])
def test_a_plane_is_lit_evenly_by_grazing_light(white, direction):
    scene = white.replace(
        mesh=plane(33, 80.0),
        camera=Camera([0.2, 0.1, 1], UP, (64, 64)),
        lights=(DirectionalLight(direction),),
    )
    picture = render(scene, ONE)
    cosine = scene.lights[0].direction[2]
    seen = picture.covered > 0
    np.testing.assert_allclose(picture.xyz[seen][:, 1], cosine, rtol=1e-6)


def test_vertices_of_a_round_thing_are_lit_as_their_pixels(white):
    for n in (0, 1, 2, 3):
        scene = white.replace(
            mesh=sphere(40, n), lights=(DirectionalLight([0.3, -0.8, 0.2]),)
        )
        dark = np.asarray(shade(scene).point_data["radiance"])
        bright = np.asarray(shade(scene, Plan(shadows=False)).point_data["radiance"])
        np.testing.assert_array_equal(dark, bright)


# Leaks --------------------------------------------------------------------------


@pytest.mark.parametrize("subdivisions", [0, 1, 3])
def test_no_light_leaks_out_of_a_closed_surface(white, subdivisions):
    ball = sphere(30, subdivisions, centre=(0, 0, 35))
    scene = floor(white, ball)
    lights = (PointLight([2, 1, 33]),)
    scene = scene.replace(lights=lights, camera=Camera([0.3, 0.2, 1], UP, (64, 64)))
    with pytest.warns(UserWarning, match="inside the mesh"):
        assert not luminance(scene).any()


def test_no_light_leaks_through_the_edges_of_a_fine_roof(white):
    # A roof of thousands of triangles, right above a floor that it hides.
    roof = moved(plane(65, 60.0), pose((0.02, 0.01, 0.3), (0, 0, 2)))
    scene = white.replace(
        mesh=joined(plane(3, 20.0), roof),
        camera=Camera(
            [0, -1, 0.01], Z, (200, 4), target=[0, 0, 0], height=0.2, distance=29.0
        ),
        lights=(DirectionalLight([0.1, 0.05, 1]),),
    )
    stage = stage_of(scene)
    floor_only = stage_of(
        dataclasses.replace(scene, mesh=plane(3, 20.0)), geometry=None
    )
    n = 200 * 4
    hits = trace.cast(floor_only.sight, stage.plan.cells, np.arange(n))
    at = floor_only.geometry.centre[:, None] + floor_only.geometry.scale * hits.lifted
    lifted = (at - stage.geometry.centre[:, None]) / stage.geometry.scale
    seen = trace.visibility(
        *(stage.geometry, stage.bands.lighting, lifted, hits.normals, hits.facets)
    )
    assert hits.pixels.size > 1000
    assert not seen.any()
