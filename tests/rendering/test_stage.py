"""Stages that go on from others: what stays is the same, what changes is as if new."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from meshes import joined, sphere, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    geometry_of,
)
from skinviz.rendering import stage as stages
from skinviz.rendering.imager import image_of
from skinviz.rendering.lighting import spectra_of
from skinviz.rendering.stage import stage_of

UP = [0.0, 1.0, 0.0]
LIGHTS = (DirectionalLight([-0.4, 0.2, 1], "A"), PointLight([30, 20, 60], "D65", 0.3))
MOVED = (DirectionalLight([0.5, 0.1, 1], "A"), PointLight([-20, 9, 50], "D65", 0.3))
PLAN = Plan(2, bounce_rays=16, spectrum="16")


@pytest.fixture(params=["uniform", "mapped", "bouncing"])
def scene(request, matt):
    """A glossy wave with a ball's shadow on it, in each way that light is computed."""
    mesh = joined(wave(11), sphere(8, 1, centre=(2, -3, 12)))
    rng = np.random.default_rng(7)
    shape = (3,) if request.param == "uniform" else (mesh.n_points, 3)
    return matt.replace(
        mesh=mesh,
        skin=Skin(matt.skin.model, rng.uniform(0.001, 0.1, shape)),
        surface=TorranceSparrow(),
        lights=LIGHTS,
        camera=Camera([0.2, -0.3, 1], UP, (21, 17), distance=250.0),
        interreflection="diffuse" if request.param == "bouncing" else "none",
    )


@pytest.fixture
def stage(scene):
    """A stage whose light has been computed."""
    stage = stage_of(scene, PLAN)
    _ = stage.colours, stage.bands
    return stage


def same_picture(one, other):
    """Whether two stages have one picture."""
    a, b = image_of(one), image_of(other)
    assert_allclose(a.xyz, b.xyz, rtol=1e-6, atol=1e-9)
    assert_array_equal(a.covered, b.covered)
    assert_array_equal(a.rays, b.rays)


# Another plan -------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes",
    [
        {"samples": 4},
        {"refine": 8.0},
        {"shading": "vertices"},
        {"reflectance": "table"},
        {"reflectance": "vertices", "arithmetic": "single"},
        {"tolerance": 1.0},
    ],
)
def test_what_light_does_not_depend_on_leaves_it_as_it_is(scene, stage, changes):
    other = stage.replanned(**changes)
    assert other.plan == PLAN.replace(**changes)
    assert other.colours is stage.colours
    assert other.bands is stage.bands
    assert other.sight is stage.sight
    same_picture(other, stage_of(scene, PLAN.replace(**changes)))


@pytest.mark.parametrize(
    "changes",
    [
        {"spectrum": "31"},
        {"specular": "none"},
        {"specular": "constant"},
        {"basis": "points"},
        {"samples": 1, "spectrum": "scene"},
    ],
)
def test_what_light_depends_on_is_computed_anew(scene, stage, changes):
    other = stage.replanned(**changes)
    assert other.colours is not stage.colours
    assert other.sight is stage.sight
    assert other.geometry is stage.geometry
    same_picture(other, stage_of(scene, PLAN.replace(**changes)))


def test_rays_between_parts_change_light_only_where_it_bounces(scene, stage):
    other = stage.replanned(bounce_rays=32)
    assert (other.colours is stage.colours) == (scene.interreflection == "none")
    same_picture(other, stage_of(scene, PLAN.replace(bounce_rays=32)))


def test_shadows_are_left_out_as_if_new(scene, stage):
    other = stage.replanned(shadows=False)
    same_picture(other, stage_of(scene, PLAN.replace(shadows=False)))
    if scene.interreflection == "none":
        assert other.colours is stage.colours


def test_no_light_is_computed_before_it_is_asked_for(scene, monkeypatch):
    asked = []

    def counted(*given):
        asked.append(given)
        return spectra_of(*given)

    monkeypatch.setattr(stages, "spectra_of", counted)
    stage = stage_of(scene, PLAN).replanned(samples=4)
    stage.replanned(spectrum="31")
    assert not asked
    _ = stage.colours, stage.colours
    assert len(asked) == 1
    _ = stage.relit(MOVED).colours
    assert len(asked) == 1


def test_replanning_leaves_the_stage_it_came_from(stage):
    before, colours = stage.plan, stage.colours
    stage.replanned(spectrum="31", specular="none")
    assert stage.plan is before
    assert stage.colours is colours


# Other lights -------------------------------------------------------------------


def test_lights_that_move_keep_their_spectra(scene, stage):
    other = stage.relit(MOVED)
    assert other.colours.spectra is stage.colours.spectra
    assert other.colours.lighting.indices is stage.colours.lighting.indices
    assert other.sight is stage.sight
    assert other.scene.lights == MOVED
    same_picture(other, stage_of(scene.replace(lights=MOVED), PLAN))


@pytest.mark.parametrize(
    "lights",
    [
        (DirectionalLight([-0.4, 0.2, 1], "D65"), LIGHTS[1]),
        (LIGHTS[0], dataclasses.replace(LIGHTS[1], strength=0.6)),
        LIGHTS[:1],
        (*LIGHTS, DirectionalLight([0, 0, 1], "A")),
        LIGHTS[::-1],
    ],
)
def test_other_lamps_have_other_spectra(scene, stage, lights):
    other = stage.relit(lights)
    assert other.colours.spectra is not stage.colours.spectra
    same_picture(other, stage_of(scene.replace(lights=lights), PLAN))


def test_a_stage_without_light_can_be_relit(scene):
    other = stage_of(scene, PLAN).relit(MOVED)
    same_picture(other, stage_of(scene.replace(lights=MOVED), PLAN))


def test_bands_follow_the_lights(scene, stage):
    expected = stage_of(scene.replace(lights=MOVED), PLAN).bands
    found = stage.relit(MOVED).bands
    assert_array_equal(found.lighting.lights, expected.lighting.lights)
    assert_allclose(found.fields.values, expected.fields.values, rtol=1e-12)


# Which vertices -----------------------------------------------------------------


def test_light_is_wanted_where_the_eye_may_see(scene):
    stage = stage_of(scene)
    assert_array_equal(stage.wanted, stage.sight.seen)
    assert stage_of(scene, whole=True).wanted.all()
    assert not stage.wanted.all()


def test_light_wanted_elsewhere_is_that_of_the_whole_there(scene):
    whole = stage_of(scene, PLAN, whole=True)
    wanted = np.arange(scene.mesh.n_points) % 3 == 0
    some = whole.only_at(wanted)
    assert some.wanted is wanted
    found, expected = some.colours.fields, whole.colours.fields
    light, every = (f.values @ f.spectra for f in (found, expected))
    assert_allclose(light[wanted], every[wanted], rtol=1e-6, atol=1e-9)
    assert not light[~wanted].any()


def test_a_geometry_at_hand_is_used(scene):
    geometry = geometry_of(scene.mesh)
    assert stage_of(scene, geometry=geometry).geometry is geometry
    assert stage_of(scene).plan == Plan()
