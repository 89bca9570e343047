"""A view held still shows what a rendering of one ray a pixel shows."""

import dataclasses

import numpy as np
import pytest

from meshes import sphere, tube, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Relief,
    Scene,
    Skin,
    TorranceSparrow,
    render,
)
from skinviz.rendering import trace
from skinviz.rendering.geometry import geometry_of
from skinviz.rendering.held import ONE_RAY, hold, seen_point
from skinviz.rendering.plan import cells

SIZE = (56, 44)


@pytest.fixture(params=["sphere", "open tube", "near", "mapped", "relief"])
def scene(request, model):
    """A ball, a tube whose inside shows, a near viewer, a map, and furrows."""
    mesh = (
        tube(n_around=24, n_along=6) if request.param == "open tube" else sphere(40, 3)
    )
    values = np.array([0.1, 0.005, 0.005])
    if request.param == "mapped":
        values = values * np.linspace(0.5, 2, mesh.n_points)[:, None]
    distance = 200.0 if request.param == "near" else np.inf
    return Scene(
        mesh=mesh,
        skin=Skin(model, values),
        surface=TorranceSparrow(),
        lights=(
            DirectionalLight([0.2, 0.4, 1.0]),
            DirectionalLight([1, 0, 0], "A", 0.3),
        ),
        camera=Camera([0.2, 0.5, 1.0], [0, 1, 0], SIZE, distance=distance),
        relief=Relief(200.0, 6.0) if request.param == "relief" else Relief(),
    )


@pytest.fixture
def held(scene):
    return hold(geometry_of(scene.mesh), scene.camera, scene.relief)


def test_it_shows_what_one_ray_a_pixel_shows(scene, held):
    rendered = render(scene, ONE_RAY)
    np.testing.assert_array_equal(held.rgb(held.stage(scene)), rendered.rgb)


def test_light_that_moves_needs_no_new_rays(scene, held):
    moved = scene.replace(lights=(DirectionalLight([-1.0, 0.3, 0.5], "F11"),))
    rendered = render(moved, ONE_RAY)
    np.testing.assert_array_equal(held.rgb(held.stage(moved)), rendered.rgb)


def test_skin_that_changes_casts_no_shadow_rays(scene, held, monkeypatch):
    """And it shows what it should, also after the light has moved and come back."""
    held.rgb(held.stage(scene))
    asked = []
    monkeypatch.setattr(trace, "visibility_of", lambda *given: asked.append(given))
    other = scene.replace(skin=Skin(scene.skin.model, 2 * scene.skin.values))
    shown = held.rgb(held.stage(other))
    assert not asked
    monkeypatch.undo()
    np.testing.assert_array_equal(shown, render(other, ONE_RAY).rgb)
    moved = scene.replace(lights=(DirectionalLight([-1.0, 0.3, 0.5]),))
    held.rgb(held.stage(moved))
    np.testing.assert_array_equal(held.rgb(held.stage(other)), shown)


def test_a_point_has_the_light_of_its_pixel(scene, held):
    rendered = render(scene, ONE_RAY)
    stage = held.stage(scene)
    pixels = np.concatenate(held.pixels)
    for pixel in pixels[:: max(1, pixels.size // 12)]:
        row, column = divmod(int(pixel), SIZE[0])
        point = held.point(column + 0.9, row + 0.1)
        seen = seen_point(stage, point)
        np.testing.assert_allclose(seen.xyz, rendered.xyz[row, column], rtol=2e-5)
        parts = seen.spectrum.diffuse + seen.spectrum.specular
        radiance = rendered.radiance((column, row))
        np.testing.assert_allclose(parts, radiance, rtol=2e-5, atol=1e-9)


def test_a_point_lies_on_the_mesh(scene, held):
    point = held.point(SIZE[0] / 2, SIZE[1] / 2)
    _, nearest = scene.mesh.find_closest_cell(point, return_closest_point=True)
    assert np.linalg.norm(nearest - point) < 1e-3


def test_nothing_is_seen_beside_the_mesh(scene, held):
    covered = np.zeros(SIZE[::-1], bool)
    covered.ravel()[np.concatenate(held.pixels)] = True
    row, column = np.argwhere(~covered)[0]
    assert held.point(column, row) is None
    assert held.point(-1, 0) is None
    assert held.point(SIZE[0], 0) is None


def test_what_is_hidden_has_no_light(scene):
    held = hold(geometry_of(scene.mesh), scene.camera)
    middle = SIZE[0] / 2, SIZE[1] / 2
    point = held.point(*middle)
    behind = dataclasses.replace(
        scene.camera, direction=-scene.camera.direction, distance=np.inf
    )
    other = hold(geometry_of(scene.mesh), behind)
    assert seen_point(held.stage(scene), point) is not None
    assert seen_point(other.stage(scene.replace(camera=behind)), point) is None


def test_a_view_of_nothing_is_its_background(scene):
    away = dataclasses.replace(
        scene.camera, target=[1e4, 0.0, 0.0], height=10.0, distance=np.inf
    )
    held = hold(geometry_of(scene.mesh), away)
    assert (held.rgb(held.stage(scene)) == scene.background).all()


def test_the_one_ray_is_the_reference_grids_first():
    assert len(cells(ONE_RAY.samples)) == 1


def test_shadows_are_cast(model):
    """Of a wavy sheet lit low, some is dark that faces the light."""
    scene = Scene(
        mesh=wave(33, height=6.0),
        skin=Skin(model, [0.1, 0.005, 0.005]),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([1, 0, 0.15]),),
        camera=Camera([0, 0, 1], [0, 1, 0], SIZE),
    )
    held = hold(geometry_of(scene.mesh), scene.camera)
    lit = held.rgb(held.stage(scene, ONE_RAY.replace(shadows=False)))
    assert held.rgb(held.stage(scene)).sum() < lit.sum()
