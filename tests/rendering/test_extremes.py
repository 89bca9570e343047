"""The extremes of PHYSICS.md section 10: right, or one clear error; never NaN."""

import dataclasses
import itertools

import numpy as np
import pytest

from meshes import joined, moved, plane, pose, sphere, tube
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    render,
    shade,
)
from skinviz.errors import ArgumentError
from skinviz.rendering.spectral import light_spectra
from skinviz.spectra.illuminants import Illuminant

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
    for plan in (None, PLAN, Plan(spectrum="scene")):
        with pytest.raises(ArgumentError, match="lamp"):
            render(dark, plan)


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
