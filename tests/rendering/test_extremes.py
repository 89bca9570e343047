"""The extremes of PHYSICS.md section 10: right, or one clear error; never NaN."""

import dataclasses
import itertools
import json
import warnings

import numpy as np
import pytest

from meshes import faces_of, joined, moved, plane, polydata, pose, sphere, tube
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    geometry_of,
    plan,
    render,
    shade,
    skin_model,
)
from skinviz.errors import ArgumentError, MeshError, SceneWarning
from skinviz.rendering.spectral import light_spectra, white_xyz
from skinviz.rendering.tolerance import compare
from skinviz.skin.coefficients import load_coefficients
from skinviz.spectra.illuminants import Illuminant, line_lamp

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]
PLAN = Plan(4)


@pytest.fixture
def scene(matt):
    """A ball on a sheet beside a tube, with edges of all kinds."""
    mesh = joined(
        sphere(12, 2, centre=(0, 0, 11)),
        plane(9),
        moved(tube(3, 20, 8, 2), pose((0.4, 0.1, 0), (14, -5, 2))),
    )
    return matt.replace(
        mesh=mesh,
        surface=TorranceSparrow(),
        camera=Camera([0.2, -0.5, 1], UP, (24, 24)),
        lights=(DirectionalLight([0.4, 0.3, 1]),),
    )


def assert_sound(scene, plan=PLAN):
    """Render and shade it: finite, not negative, and colours are the spectra's."""
    picture = render(scene, plan)
    spectra = picture.radiance()
    vertices = np.asarray(shade(scene, plan).point_data["radiance"])
    for light in (picture.xyz, spectra, vertices):
        assert np.isfinite(light).all()
        assert (light >= 0).all()
    return picture


# Surfaces -----------------------------------------------------------------------


@pytest.mark.parametrize("masking", ["v-cavity", "none"])
@pytest.mark.parametrize("gamma", [1e-4, 0.01, 0.3, np.pi / 2])
def test_every_lobe_gives_light(scene, gamma, masking):
    dull = TorranceSparrow(specular_scale=0)
    for n, scale in itertools.product((1.0, 1.4, 3.0), (0.0, 1.0)):
        surface = TorranceSparrow(
            gamma=gamma, n=n, specular_scale=scale, masking=masking
        )
        picture = assert_sound(scene.replace(surface=surface))
        if n == 1 or scale == 0:
            matt = render(scene.replace(surface=dull), PLAN)
            np.testing.assert_allclose(picture.xyz, matt.xyz, rtol=1e-6)


@pytest.mark.parametrize(
    "direction",
    [
        Z,
        [1, 0, 0],
        [1, 0, 1e-6],
        [1, 0, -1e-6],
        [1e-9, -1, 1e-9],
        [0.2, -0.5, 1],  # from the eye
        [-0.2, 0.5, -1],  # against it
        [0.2 + 1e-9, -0.5, 1],
    ],
)
@pytest.mark.parametrize("distance", [np.inf, 80.0])
def test_every_direction_of_light_gives_light(scene, direction, distance):
    near = dataclasses.replace(scene.camera, distance=distance)
    both = (DirectionalLight(direction), DirectionalLight(Z, strength=1e-3))
    for lights in (both, both[::-1]):
        picture = assert_sound(scene.replace(lights=lights, camera=near))
        assert picture.xyz.any()


@pytest.mark.parametrize(
    "view", [[1, 0, 0.001], [1, 0, 0], [0, 1, 1e-9], [0.3, 0.4, 1e-3], [-1, 0, -1e-6]]
)
def test_every_grazing_view_gives_light(scene, view):
    assert_sound(scene.replace(camera=Camera(view, Z, (24, 24))))


# Light --------------------------------------------------------------------------


@pytest.mark.parametrize("power", [1e-30, 1.0, 1e30, 1e-300, 1e300])
def test_the_unit_of_an_illuminant_is_nothing(scene, power):
    nm = np.arange(380.0, 781, 5)
    shape = 1 + np.sin(nm / 30)
    plain, scaled = (
        render(scene.replace(lights=(DirectionalLight(Z, lamp),)), PLAN)
        for lamp in (
            Illuminant("a lamp", nm, shape),
            Illuminant("the lamp", nm, power * shape),
        )
    )
    np.testing.assert_allclose(scaled.radiance(), plain.radiance(), rtol=1e-6)


def test_a_laser_lights_one_band(scene):
    nm = np.array([380.0, 544, 545, 546, 780])
    laser = Illuminant("laser", nm, [0, 0, 1, 0, 0])
    picture = assert_sound(scene.replace(lights=(DirectionalLight(Z, laser),)))
    lit = picture.radiance().any(axis=(0, 1))
    assert picture.wavelengths[lit].tolist() == [545.0]
    assert picture.xyz[..., 1].max() > 0.1


def test_light_that_no_eye_sees_has_no_scale(scene):
    ultraviolet = Illuminant("lamp", [300.0, 370], [1, 1])
    dark = scene.replace(lights=(DirectionalLight(Z, ultraviolet),))
    for chosen in (None, PLAN, Plan(spectrum="scene")):
        with pytest.raises(ArgumentError, match="lamp"):
            render(dark, chosen)


@pytest.mark.parametrize("bands", [[550.0], [400.0], [700.0], [380, 780], [449.9, 450]])
def test_any_bands_give_light(scene, bands):
    picture = assert_sound(scene.replace(wavelengths=bands))
    assert picture.radiance().shape[-1] == len(bands)
    assert picture.xyz.any()


@pytest.mark.parametrize("exposure", [1e-30, 1e-10, 1e10, 1e30])
def test_any_exposure_gives_light(scene, exposure):
    one, other = render(scene, PLAN), assert_sound(scene.replace(exposure=exposure))
    np.testing.assert_allclose(other.xyz / np.float64(exposure), one.xyz, rtol=1e-5)
    assert other.rgb.shape == one.rgb.shape


@pytest.mark.parametrize(
    ("exposure", "strengths"),
    [
        (1.0, (1e-30, 1e30)),
        (1e30, (1.0, 1e5)),
        (1e30, (1.0, 1e14)),
        (1e30, (1e-30, 1e30)),
        (1e-30, (1e30, 1e-30)),
        (1e-30, (1e-30, 1e30)),
    ],
)
def test_any_strengths_give_light_or_one_clear_error(scene, exposure, strengths):
    lights = (
        DirectionalLight([0.4, 0.3, 1], "A", strengths[0]),
        PointLight([20, 30, 90], "D65", strengths[1]),
    )
    extreme = scene.replace(lights=lights, exposure=exposure)
    peak = exposure * max(1, strengths[1] / strengths[0])
    if peak < 1e36:
        assert_sound(extreme)
        return
    for compute in (render, shade):
        with pytest.raises(ArgumentError, match="more than float32 holds; lower the"):
            compute(extreme, PLAN)


@pytest.mark.parametrize("gap", [1e-9, 1e-6, 1e-3, 1.0])
def test_a_light_that_all_but_touches_gives_light_or_one_clear_error(scene, gap):
    lights = (DirectionalLight(Z), PointLight([0, 0, 23 + gap]))
    camera = Camera([0.2, -0.5, 1], UP, (24, 24), target=[0, 0, 23], height=3.0)
    try:
        picture = assert_sound(scene.replace(lights=lights, camera=camera))
    except ArgumentError as error:
        assert "more than float32 holds" in str(error)  # noqa: PT017 - either is right
    else:
        assert picture.xyz.any()


@pytest.mark.parametrize("alpha", [0.0, 1e-6, 1.0, 1e6])
def test_the_diffuse_scale_only_scales_the_diffuse_part(scene, alpha):
    picture = assert_sound(scene.replace(diffuse_scale=alpha))
    gloss = render(scene.replace(diffuse_scale=0.0), PLAN).xyz.astype(float)
    body = render(scene, PLAN).xyz - gloss
    np.testing.assert_allclose(
        picture.xyz, gloss + alpha * body, rtol=1e-5, atol=1e-6 * max(alpha, 1)
    )


# Skin ---------------------------------------------------------------------------


@pytest.mark.parametrize("mapped", [False, True])
@pytest.mark.parametrize(
    "weights", [(0, 0, 0), (1e-12,) * 3, (1e12,) * 3, (0, 1e12, 0)]
)
def test_any_pigments_give_light(scene, weights, mapped):
    values = np.array(weights, dtype=float)
    if mapped:
        values = np.tile(values, (scene.mesh.n_points, 1))
        values[::3] = 0.01
    picture = assert_sound(scene.replace(skin=Skin(scene.skin.model, values)))
    assert picture.xyz.any()


def test_pigments_that_are_no_numbers_never_come_to_a_picture(scene):
    for bad in (np.nan, np.inf, -1.0):
        with pytest.raises(ArgumentError):
            Skin(scene.skin.model, [0.1, bad, 0.1])


# Views --------------------------------------------------------------------------


@pytest.mark.parametrize("height", [1e-6, 1e-3, 1.0, 1e3, 1e9])
@pytest.mark.parametrize("distance", [np.inf, 1e9, 100.0])
def test_any_magnification_gives_a_picture(scene, height, distance):
    camera = Camera(
        [0.01, 0.02, 1], UP, (16, 16), distance, target=[0.3, 0.2, 23], height=height
    )
    near = scene.replace(camera=camera)
    if height < 1e6:
        picture = assert_sound(near)
        if height < 10:
            assert (picture.coverage == 1).all()
            assert (picture.xyz > 0).all()
        return
    with pytest.warns(UserWarning, match=r"empty|black"):
        render(near, PLAN)


def test_far_views_come_to_parallel_rays(scene):
    parallel = render(scene, PLAN)
    camera = dataclasses.replace(scene.camera, distance=1e9)
    far = render(scene.replace(camera=camera), PLAN)
    same = np.isclose(far.xyz, parallel.xyz, rtol=1e-4, atol=1e-6).all(axis=-1)
    assert same.mean() > 0.99


def test_the_light_of_a_picture_is_what_its_lights_give(scene):
    # Y of the perfect diffuser that faces light 1 is the exposure, whatever the rest.
    E = light_spectra(scene.replace(exposure=7.0))
    assert E.shape == (1, scene.wavelengths.size)
    assert (E > 0).all()


# The plan -----------------------------------------------------------------------
#
# Every entry once more as users ask for it: by a tolerance, here of 1. The reference
# is right by the tests above and beside this file; a planned picture must keep to it.


@pytest.fixture
def large(scene):
    """The same things in a picture for which planning pays."""
    return scene.replace(camera=dataclasses.replace(scene.camera, size=(160, 160)))


def assert_kept(scene, tolerance=1.0):
    """Plan and render it: sound, told as JSON, and as near the reference as asked."""
    geometry = geometry_of(scene.mesh)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # a black picture is right too
        picture = render(scene, tolerance=tolerance, geometry=geometry)
        reference = render(scene, Plan(), geometry=geometry)
    # A sample of rows: all the spectra would take longer than the rest.
    rows = [(0, y, picture.size[0], y + 1) for y in range(picture.size[1])[::40]]
    for light in (picture.xyz, *(picture.radiance(row) for row in rows)):
        assert np.isfinite(light).all()
        assert (light >= 0).all()
    assert (picture.coverage.sum() > 0) == (reference.coverage.sum() > 0)
    json.dumps(picture.metadata, allow_nan=False)
    assert "nan" not in picture.plan.explain()
    off = compare(picture.xyz, reference.xyz, reference.covered, white_xyz(scene))
    assert off.kept(tolerance), off
    return picture


MAPPED = (112, 112)  # pixels, for which planning pays where skin is mapped


def mapped(skin, n_points, every):
    """The skin's weights at each vertex, others at every third one."""
    values = np.tile(np.asarray(skin.values, dtype=float), (n_points, 1))
    values[::3] = every
    return Skin(skin.model, values)


def test_planning_pays_on_the_scene_of_these_tests(large):
    assert assert_kept(large).plan.samples < 16


@pytest.mark.parametrize(
    "weights", [(0, 0, 0), (1e-12,) * 3, (1e12,) * 3, (0, 1e12, 0)]
)
def test_plans_keep_any_pigments(large, weights):
    skin = Skin(large.skin.model, weights)
    assert assert_kept(large.replace(skin=skin)).xyz.any()


@pytest.mark.parametrize("weights", [(0, 0, 0), (1e-12,) * 3, (1e12,) * 3])
def test_plans_keep_any_mapped_pigments(large, weights):
    camera = dataclasses.replace(large.camera, size=MAPPED)
    skin = mapped(large.skin, large.mesh.n_points, weights)
    picture = assert_kept(large.replace(skin=skin, camera=camera))
    assert picture.xyz.any()
    assert picture.plan.spectrum != "1 nm"


@pytest.mark.parametrize(
    "thickness",
    [*itertools.product((0.0, np.inf), repeat=2), (0.035, np.inf), (np.inf, 1.2)],
)
def test_plans_keep_any_thickness(large, thickness):
    model = skin_model(thickness=thickness, specular="included")
    picture = assert_kept(large.replace(skin=Skin(model, [0.1, 0.005, 0.005])))
    body = model.diffuse([0.1, 0.005, 0.005], large.wavelengths)
    if thickness == (0.0, 0.0):
        np.testing.assert_allclose(body, body[0], rtol=1e-12)  # of the white below
    assert picture.xyz.any()


@pytest.mark.parametrize(
    ("absorption", "scattering"), [*itertools.product((1e-16, 1.0, 1e16), repeat=2)]
)
def test_plans_keep_any_coefficients(large, absorption, scattering):
    table = load_coefficients("effective")
    ones = np.ones_like(table.wavelengths)
    K, S = absorption * ones, scattering * ones
    extreme = dataclasses.replace(
        table,
        **dict.fromkeys(("melanin", "oxyhaemoglobin", "deoxyhaemoglobin"), K),
        **dict.fromkeys(("epidermis", "dermis"), S),
    )
    model = skin_model(site="cheek", specular="included", coefficients=extreme)
    values = [1.0, 0.5, 0.5]
    body = model.diffuse(values, large.wavelengths)
    assert ((body >= 0) & (body <= 1)).all()
    assert_kept(large.replace(skin=Skin(model, values)))


@pytest.mark.parametrize(
    "direction", [Z, [1, 0, 0], [1, 0, 1e-6], [0.2, -0.5, 1], [-0.2, 0.5, -1]]
)
@pytest.mark.parametrize("view", [[0.2, -0.5, 1], Z, [1, 0, 0.001]])
def test_plans_keep_grazing_and_normal_light_and_views(large, direction, view):
    up = UP if view != [1, 0, 0.001] else Z
    camera = Camera(view, up, (160, 160))
    assert_kept(large.replace(lights=(DirectionalLight(direction),), camera=camera))


@pytest.mark.parametrize("masking", ["v-cavity", "none"])
@pytest.mark.parametrize("gamma", [1e-4, 0.01, np.pi / 2])
@pytest.mark.parametrize("n", [1.0, 1.4, 3.0])
def test_plans_keep_every_lobe(large, gamma, n, masking):
    surface = TorranceSparrow(gamma=gamma, n=n, masking=masking)
    assert_kept(large.replace(surface=surface))


NM = np.arange(380.0, 781, 5)
LAMPS = {
    "zeros": Illuminant("zeros", NM, np.where(np.abs(NM - 560) < 60, 1.0, 0.0)),
    "laser": line_lamp([(545.0, 1.0)]),
    "three lines": line_lamp([(436.0, 1.0), (546.1, 2.0), (611.0, 1e-3)]),
    "1e-30": Illuminant("faint", NM, np.full(NM.size, 1e-30)),
    "1e30": Illuminant("strong", NM, np.full(NM.size, 1e30)),
}


@pytest.mark.parametrize("lamp", LAMPS)
@pytest.mark.parametrize("map_", [False, True], ids=["uniform", "mapped"])
def test_plans_keep_every_illuminant(large, lamp, map_):
    lit = large.replace(lights=(DirectionalLight([0.4, 0.3, 1], LAMPS[lamp]),))
    if map_:
        camera = dataclasses.replace(large.camera, size=MAPPED)
        skin = mapped(large.skin, large.mesh.n_points, 0.01)
        lit = lit.replace(camera=camera, skin=skin)
    assert assert_kept(lit).xyz.any()


def test_the_picture_of_a_laser_has_the_lasers_colour(large):
    laser = LAMPS["laser"]
    picture = assert_kept(large.replace(lights=(DirectionalLight(Z, laser),)))
    xyz = picture.xyz[picture.xyz[..., 1] > 0].astype(float)
    white = white_xyz(picture.scene)
    np.testing.assert_allclose(xyz / xyz[:, 1:2], np.tile(white, (len(xyz), 1)), 1e-5)


@pytest.mark.parametrize("bands", [[550.0], [449.9, 450]])
@pytest.mark.parametrize("interreflection", ["none", "diffuse"])
def test_plans_keep_one_band(large, bands, interreflection):
    scene = large.replace(wavelengths=bands, interreflection=interreflection)
    assert assert_kept(scene).radiance((80, 80)).shape == (len(bands),)


# The plan: meshes ---------------------------------------------------------------


def on_mesh(scene, mesh, **changes):
    """The scene with another mesh, all of which is seen from +z."""
    camera = Camera([0.1, 0.05, 1], UP, (160, 160))
    return scene.replace(mesh=mesh, camera=camera, **changes)


@pytest.mark.parametrize("interreflection", ["none", "diffuse"])
@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_plans_keep_a_mesh_of_one_triangle(large, size, interreflection):
    corners = size * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    scene = on_mesh(large, polydata(corners, np.array([[0, 1, 2]])))
    assert assert_kept(scene.replace(interreflection=interreflection)).xyz.any()


def test_triangles_without_area_change_no_picture(large):
    whole = sphere(40, 3)
    faces = faces_of(whole)
    empty = np.stack([faces[:90, 0], faces[:90, 0], faces[:90, 1]], axis=1)
    more = polydata(np.asarray(whole.points), np.concatenate([faces, empty]))
    assert_kept(on_mesh(large, more))
    one, other = (render(on_mesh(large, mesh), Plan()) for mesh in (whole, more))
    np.testing.assert_array_equal(other.covered, one.covered)
    np.testing.assert_allclose(other.xyz, one.xyz, rtol=1e-6)


def test_a_mesh_without_any_area_is_refused(large):
    line = polydata(
        np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]])
    )
    for compute in (render, plan):
        with pytest.raises(MeshError, match=r"no triangle .* has an area; clean it"):
            compute(on_mesh(large, line))


@pytest.mark.parametrize("place", [0.0, 1e9, -1e300])
def test_vertices_that_nothing_uses_change_no_picture(large, place):
    whole = sphere(40, 3)
    points = np.concatenate([whole.points, [[place, 0, 0]]])
    more = polydata(points, faces_of(whole))
    one, other = (assert_kept(on_mesh(large, mesh)) for mesh in (whole, more))
    np.testing.assert_array_equal(other.xyz, one.xyz)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("used", [True, False])
def test_vertices_that_are_no_numbers_are_refused(large, bad, used):
    whole = sphere(40, 3)
    points = np.array(whole.points)
    if used:
        points[5, 1] = bad
    else:
        points = np.concatenate([points, [[0, bad, 0]]])
    with pytest.raises(MeshError, match=r"is not finite .* remove such points"):
        render(on_mesh(large, polydata(points, faces_of(whole))))


@pytest.mark.parametrize("interreflection", ["none", "diffuse"])
@pytest.mark.parametrize("map_", [False, True], ids=["uniform", "mapped"])
def test_plans_keep_a_picture_of_one_pixel(large, map_, interreflection):
    camera = dataclasses.replace(large.camera, size=(1, 1))
    skin = mapped(large.skin, large.mesh.n_points, 0.01) if map_ else large.skin
    scene = large.replace(camera=camera, skin=skin, interreflection=interreflection)
    picture = assert_kept(scene)
    assert picture.rgb.shape == (1, 1, 3)
    assert picture.xyz.any()


@pytest.mark.slow
def test_ten_million_vertices_are_planned_and_rendered(large):
    n = 3163
    assert n**2 > 1e7
    scene = on_mesh(large, plane(n), skin=large.skin)
    picture = render(scene)
    assert (picture.coverage[40:120, 40:120] == 1).all()
    middle = picture.xyz[40:120, 40:120]
    few = render(scene.replace(mesh=plane(9)), Plan())  # the same square, coarsely
    np.testing.assert_allclose(middle, few.xyz[40:120, 40:120], rtol=1e-4)
