"""Light between parts of a mesh: closed forms of form factors, and what stays 0."""

import dataclasses

import numpy as np
import pytest
from pixels import places_in_mm

from meshes import (
    faces_of,
    joined,
    moved,
    plane,
    polydata,
    pose,
    sphere,
    toy_hand,
    wave,
)
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    render,
    shade,
    vertex_spectrum,
)
from skinviz.errors import ArgumentError
from skinviz.rendering.bounce import gather
from skinviz.rendering.geometry import geometry_of
from skinviz.rendering.spectral import light_spectra
from skinviz.rendering.stage import stage_of
from skinviz.spectra.colorimetry import colour_matching_functions
from skinviz.surface.torrance_sparrow import TorranceSparrow

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]


def turned_over(mesh):
    return polydata(np.asarray(mesh.points), faces_of(mesh)[:, ::-1])


def form_factor(points, normal, corners):
    """The share of the light that leaves points which meets a polygon, by Lambert.

    Its edges' angles times the cosines of their planes, which are above the horizon.
    """
    total = np.zeros(len(points))
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        u, v = a - points, b - points
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        v /= np.linalg.norm(v, axis=1, keepdims=True)
        across = np.cross(u, v)
        sine = np.linalg.norm(across, axis=1)
        angle = np.arctan2(sine, (u * v).sum(axis=1))
        total += angle * (across @ normal) / np.where(sine > 0, sine, 1)
    return np.abs(total) / (2 * np.pi)


def diffuse(scene, **changes):
    return scene.replace(interreflection="diffuse", **changes)


def luminance(scene, plan=None):
    """Y of every vertex."""
    shaded = shade(scene, plan)
    radiance = np.asarray(shaded.point_data["radiance"], dtype=float)
    return 5 * radiance @ colour_matching_functions(scene.wavelengths)[:, 1]


# Form factors -------------------------------------------------------------------


@pytest.fixture
def corner(white):
    """A floor before a wall, each lit at 45°; they do not share points."""
    wall = moved(plane(9, 40.0), pose((0, np.pi / 2, 0), (-21, 0, 20)))
    mesh = joined(plane(9, 40.0), wall)
    return white.replace(mesh=mesh, lights=(DirectionalLight([1, 0, 1]),))


WALL = np.array([[-21.0, -20, 0], [-21, 20, 0], [-21, 20, 40], [-21, -20, 40]])


@pytest.mark.parametrize(("n_rays", "worst"), [(64, 0.04), (1024, 5e-3), (16384, 1e-3)])
def test_a_floor_before_a_wall_gains_the_walls_form_factor(corner, n_rays, worst):
    lit = luminance(diffuse(corner), Plan(bounce_rays=n_rays))[:81]
    points = np.asarray(corner.mesh.points)[:81]
    expected = np.sqrt(0.5) * (1 + form_factor(points, np.array(Z), WALL))
    np.testing.assert_allclose(lit, expected, atol=worst * np.sqrt(0.5))
    assert expected.max() > 1.3 * np.sqrt(0.5)


def test_bounced_light_is_the_product_of_both_reflectances(matt, corner):
    # α² E R R': of the part that throws it and of the part that is met.
    skin = Skin(matt.skin.model, [0.02, 0.003, 0.001])
    scene = corner.replace(skin=skin, diffuse_scale=0.7)
    extra = np.asarray(shade(diffuse(scene)).point_data["radiance"], dtype=float)
    extra -= np.asarray(shade(scene).point_data["radiance"])
    body = skin.model.diffuse(skin.values, scene.wavelengths)
    one = corner.replace(skin=Skin(corner.skin.model, [1.0]))
    factor = luminance(diffuse(one)) / luminance(one) - 1
    expected = (0.7 * body) ** 2 * light_spectra(scene)[0] * np.sqrt(0.5)
    np.testing.assert_allclose(
        extra, factor[:, None] * expected, rtol=1e-4, atol=1e-6 * extra.max()
    )


def test_the_wall_throws_its_own_reflectance(corner):
    # A black wall gives nothing; a white floor gives to the black wall what is lost.
    values = np.ones((corner.mesh.n_points, 1))
    values[81:] = 0.25
    mapped = corner.replace(skin=Skin(corner.skin.model, values))
    gain = luminance(diffuse(mapped)) - luminance(mapped)
    whole = luminance(diffuse(corner)) - luminance(corner)
    np.testing.assert_allclose(gain[:81], 0.25 * whole[:81], rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(gain[81:], 0.25 * whole[81:], rtol=1e-5, atol=1e-7)


# Cavities -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def cavity():
    """The inside of a sphere."""
    return turned_over(sphere(40, 3))


def test_in_a_closed_cavity_all_light_is_met_again(cavity):
    geometry = geometry_of(cavity)
    leaving = np.tile([1.0, 0.3], (cavity.n_points, 1))
    np.testing.assert_allclose(gather(geometry, leaving, 64), leaving, rtol=1e-9)


@pytest.mark.parametrize(("n_rays", "worst"), [(64, 0.05), (1024, 0.01), (4096, 4e-3)])
def test_every_point_of_a_sphere_sees_all_of_it_alike(cavity, n_rays, worst):
    # Form factors inside a sphere are its areas: gathered is the mean over the sphere.
    unit = np.asarray(cavity.points) / 40
    geometry = dataclasses.replace(geometry_of(cavity), normals=-unit)
    x, y, z = unit.T
    leaving = np.stack([1 + z, z**2, (x * y) ** 2, x**4 + y / 2 + 1], axis=1)
    expected = [1, 1 / 3, 1 / 15, 6 / 5]
    gathered = gather(geometry, leaving, n_rays)
    np.testing.assert_allclose(gathered, np.tile(expected, (len(x), 1)), atol=worst)


def test_a_lit_cavity_gains_alpha_squared_r_squared(white, cavity):
    # A light in the middle lights all alike; a plate outside moves the centroid off it.
    plate = moved(plane(2, 10.0), pose(shift=(0, 0, 60)))
    mesh = joined(cavity, plate)
    scene = white.replace(
        mesh=mesh,
        lights=(PointLight([0, 0, 0]),),
        skin=Skin(white.skin.model, [0.5]),
        diffuse_scale=0.8,
    )
    inside = slice(0, cavity.n_points)
    direct = luminance(scene)[inside]
    np.testing.assert_allclose(direct, direct.mean(), rtol=1e-3)
    both = luminance(diffuse(scene), Plan(bounce_rays=256))[inside]
    np.testing.assert_allclose(both, direct * (1 + 0.8 * 0.5), rtol=2e-3)


# What stays ---------------------------------------------------------------------


@pytest.mark.parametrize("subdivisions", [0, 1, 2, 3])
def test_a_convex_thing_lights_itself_not_at_all(white, subdivisions):
    scene = diffuse(white, mesh=sphere(40, subdivisions))
    fields = stage_of(scene).bands.fields
    assert not fields.values.any()
    mapped = scene.replace(
        skin=Skin(white.skin.model, np.linspace(0, 1, scene.mesh.n_points)[:, None])
    )
    assert not stage_of(mapped).bands.fields.values.any()


def test_a_convex_thing_looks_the_same_with_and_without(matt):
    scene = matt.replace(
        mesh=sphere(40, 2),
        surface=TorranceSparrow(),
        camera=Camera([0.3, 0.1, 1], UP, (24, 24)),
        lights=(DirectionalLight([1, 1, 1]), PointLight([0, 90, 30], "A")),
    )
    for skin in (matt.skin, Skin(matt.skin.model, np.full((162, 3), 0.01))):
        one = render(scene.replace(skin=skin), Plan(4))
        other = render(diffuse(scene, skin=skin), Plan(4))
        np.testing.assert_allclose(one.xyz, other.xyz, rtol=2e-7)


def test_a_flat_thing_lights_itself_not_at_all(white):
    assert not stage_of(diffuse(white, mesh=plane(17))).bands.fields.values.any()


def test_the_inside_of_a_mesh_throws_no_light(white):
    # A plate under another whose upper side alone is skin.
    roof = moved(plane(5, 60.0), pose(shift=(0, 0, 10)))
    scene = diffuse(white, mesh=joined(plane(5), roof))
    assert not stage_of(scene).bands.fields.values.any()


def test_without_interreflection_there_are_no_fields(white):
    fields = stage_of(white).bands.fields
    assert fields.values.shape == (white.mesh.n_points, 0)
    assert fields.spectra.shape == (0, white.wavelengths.size)


# Identities ---------------------------------------------------------------------


@pytest.fixture
def valley(matt):
    """Skin that lights itself: two balls over a sheet, two lights of other colours."""
    mesh = joined(
        wave(17, height=4.0), sphere(7, 2, centre=(4, 4, 9)), sphere(5, 2, (-8, -6, 7))
    )
    return diffuse(
        matt,
        mesh=mesh,
        camera=Camera([0.2, -0.3, 1], UP, (24, 24)),
        lights=(DirectionalLight([0.6, 0.3, 1]), PointLight([-30, 20, 60], "A", 0.5)),
    )


def test_equal_pigments_everywhere_are_uniform_pigments(valley):
    valley = valley.replace(diffuse_scale=0.6)
    values = np.tile(valley.skin.values, (valley.mesh.n_points, 1))
    mapped = valley.replace(skin=Skin(valley.skin.model, values))
    one, each = (np.asarray(shade(s).point_data["radiance"]) for s in (valley, mapped))
    np.testing.assert_allclose(one, each, rtol=1e-6, atol=1e-6 * one.max())
    one, each = render(valley, Plan(4)), render(mapped, Plan(4))
    np.testing.assert_allclose(one.xyz, each.xyz, rtol=1e-6, atol=1e-6 * one.xyz.max())


def test_bounced_light_adds(valley):
    both = np.asarray(shade(valley).point_data["radiance"], dtype=float)
    first, second = (
        np.asarray(shade(valley.replace(lights=(light,))).point_data["radiance"])
        for light in valley.lights
    )
    np.testing.assert_allclose(
        both, first + 0.5 * second, rtol=1e-6, atol=1e-7 * both.max()
    )


@pytest.mark.parametrize("mapped", [False, True])
def test_bounced_light_only_brightens_and_is_never_negative(valley, mapped):
    rng = np.random.default_rng(2)
    n = valley.mesh.n_points
    values = rng.uniform(0, 1, (n, 3)) ** 8 if mapped else valley.skin.values
    scene = valley.replace(skin=Skin(valley.skin.model, values))
    with_bounce = np.asarray(shade(scene).point_data["radiance"], dtype=float)
    without = shade(scene.replace(interreflection="none")).point_data["radiance"]
    assert (with_bounce >= 0).all()
    assert (with_bounce >= np.asarray(without) * (1 - 1e-6)).all()
    assert (with_bounce > 1.01 * np.asarray(without)).any()
    picture = render(scene, Plan(4))
    assert (picture.xyz >= 0).all()
    assert (picture.radiance() >= 0).all()


def test_unlit_skin_that_nothing_lights_is_black_not_negative(matt):
    # Elsewhere light is gathered in so many colours that their parts leave rounding.
    mesh = toy_hand(80.0, 24, 30)
    values = np.random.default_rng(3).uniform(0, 1, (mesh.n_points, 3)) ** 6
    scene = diffuse(
        matt,
        mesh=mesh,
        skin=Skin(matt.skin.model, values),
        lights=(DirectionalLight([0, 0.3, 1]),),
        camera=Camera([0, -1, 0], Z, (24, 24)),
    )
    plan = Plan(1, bounce_rays=64)
    radiance = np.asarray(shade(scene, plan).point_data["radiance"])
    assert radiance.min() == 0
    assert (render(scene, plan).radiance() >= 0).all()
    for vertex in np.flatnonzero((radiance == 0).all(axis=1))[:20]:
        assert (vertex_spectrum(scene, int(vertex)).diffuse >= 0).all()


def test_more_rays_come_nearer(valley):
    stages = [stage_of(valley, Plan(bounce_rays=n)) for n in (16, 128, 1024, 16384)]
    *rough, fine = (stage.bands.fields.values for stage in stages)
    errors = [np.sqrt(((field - fine) ** 2).mean()) for field in rough]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]
    assert errors[-1] < 0.02 * fine.max()


def test_shadows_are_cast_before_light_is_thrown(white):
    # A wall that a roof shades has nothing to throw on the floor.
    wall = moved(plane(9, 40.0), pose((0, np.pi / 2, 0), (-21, 0, 20)))
    roof = moved(plane(2, 400.0), pose(shift=(0, 0, 90)))
    scene = diffuse(white, mesh=joined(plane(9), wall, roof))
    scene = scene.replace(lights=(DirectionalLight([0.3, 0, 1]),))
    assert not luminance(scene)[:162].any()
    # Nor where the eye's own shadows are left out: all of it is direct light then.
    direct = luminance(scene.replace(interreflection="none"), Plan(shadows=False))
    both = luminance(scene, Plan(shadows=False))
    np.testing.assert_allclose(both[:81], direct[:81], atol=1e-12)
    open_scene = scene.replace(mesh=joined(plane(9), wall))
    assert luminance(open_scene)[:81].max() > 1


def test_vertices_and_pixels_gain_alike(corner):
    scene = diffuse(
        corner, camera=Camera(Z, UP, (16, 16), target=[0, 0, 0], height=32.0)
    )
    plan = Plan(1)
    picture = render(scene, plan)
    places = places_in_mm(picture.view, plan.cells[0])
    from scipy.interpolate import LinearNDInterpolator

    on_floor = LinearNDInterpolator(
        np.asarray(corner.mesh.points)[:81, :2], luminance(scene)[:81]
    )
    # Triangles of a square may be cut along its other diagonal.
    expected = on_floor(places[..., 0], places[..., 1])
    np.testing.assert_allclose(picture.xyz[..., 1], expected, rtol=0.02)


def test_motion_does_not_change_what_is_gathered_by_much(valley):
    mesh = toy_hand(80.0, 24, 30)
    motion = pose((0.5, 1, -2), (9, 8, 7))
    geometry = geometry_of(mesh)
    rng = np.random.default_rng(1)
    leaving = rng.uniform(0, 1, (mesh.n_points, 1))
    here = gather(geometry, leaving, 1024)
    there = gather(geometry_of(moved(mesh, motion)), leaving, 1024)
    np.testing.assert_allclose(here, there, atol=0.02)


# Extremes -----------------------------------------------------------------------


@pytest.mark.parametrize("mapped", [False, True])
@pytest.mark.parametrize("exposure", [1e-30, 1e30])
def test_any_exposure_gives_light_or_one_clear_error(valley, exposure, mapped):
    values = valley.skin.values
    if mapped:
        values = np.tile(values, (valley.mesh.n_points, 1))
    scene = valley.replace(skin=Skin(valley.skin.model, values))
    one, other = (
        render(scene, Plan(1)),
        render(scene.replace(exposure=exposure), Plan(1)),
    )
    np.testing.assert_allclose(
        other.xyz / np.float64(exposure), one.xyz, rtol=1e-5, atol=1e-7
    )
    first, second = scene.lights
    bright = dataclasses.replace(second, strength=1e30)
    with pytest.raises(ArgumentError, match="more than float32 holds"):
        render(scene.replace(exposure=1e30, lights=(first, bright)), Plan(1))


def test_light_that_does_not_reach_the_mesh_is_not_thrown(valley):
    dark = valley.replace(lights=(DirectionalLight([0, 0, -1]),), mesh=wave(9))
    with pytest.warns(UserWarning, match="behind"):
        assert not render(dark, Plan(1)).xyz.any()
