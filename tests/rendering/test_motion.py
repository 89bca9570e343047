"""A scene may be moved, turned and made larger: its picture stays."""

import dataclasses

import numpy as np
import pytest

from meshes import faces_of, joined, moved, polydata, pose, sphere, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    TorranceSparrow,
    render,
)

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]

MOTIONS = {
    "turn": pose((0.4, -1.1, 0.7)),
    "upside down": pose((np.pi, 0, 0)),
    "shift": pose(shift=(-500, 200, 900)),
    "far": pose((1.2, 0.3, -2.2), (1e6, -2e6, 5e5)),
}


def carried(scene, motion, scale=1.0):
    """The scene after a motion of everything in it."""
    turn = motion[:3, :3]

    def place(x):
        return scale * (turn @ np.asarray(x) + motion[:3, 3])

    lights = tuple(
        dataclasses.replace(light, position=place(light.position))
        if isinstance(light, PointLight)
        else dataclasses.replace(light, direction=turn @ light.direction)
        for light in scene.lights
    )
    camera = scene.camera
    camera = Camera(
        turn @ camera.direction,
        turn @ camera.up,
        camera.size,
        distance=camera.distance * scale,
        target=None if camera.target is None else place(camera.target),
        height=None if camera.height is None else camera.height * scale,
    )
    mesh = moved(scene.mesh, motion)
    mesh = polydata(scale * np.asarray(mesh.points), faces_of(mesh))
    return scene.replace(mesh=mesh, lights=lights, camera=camera)


def assert_same_picture(one, other):
    """Demand equal light, but where a ray grazes an edge of mesh or shadow."""
    same = one.covered == other.covered
    assert same.mean() > 0.995
    close = np.isclose(one.xyz, other.xyz, rtol=1e-5, atol=1e-6).all(axis=-1)
    assert close.mean() > 0.98
    np.testing.assert_allclose(one.xyz.sum(), other.xyz.sum(), rtol=1e-4)


@pytest.fixture
def still_life(matt):
    """Things that throw shadows on each other, in perspective."""
    mesh = joined(
        sphere(15, 3, centre=(5, 4, 18)), wave(), sphere(6, 2, centre=(-9, -8, 9))
    )
    return matt.replace(
        surface=TorranceSparrow(),
        mesh=mesh,
        lights=(DirectionalLight([-0.5, 0.4, 1]), PointLight([-20, 30, 60], "A")),
        camera=Camera([0.2, -0.6, 1], UP, (40, 40), distance=200.0),
    )


@pytest.mark.parametrize("name", MOTIONS)
def test_pictures_move_with_the_scene(still_life, name):
    for scene in (still_life, still_life.replace(camera=Camera(Z, UP, (40, 40)))):
        one = render(scene)
        assert_same_picture(one, render(carried(scene, MOTIONS[name])))


@pytest.mark.parametrize("scale", [1e-5, 1e-3, 1e3, 1e6])
def test_pictures_scale_with_the_scene(still_life, scale):
    one = render(still_life)
    other = render(carried(still_life, np.eye(4), scale))
    assert_same_picture(one, other)


@pytest.mark.parametrize("name", MOTIONS)
def test_unshadowed_light_inside_the_silhouette_moves_to_1e_6(still_life, name):
    plan = Plan(samples=1, shadows=False)
    scene = still_life.replace(mesh=wave())
    one, other = render(scene, plan), render(carried(scene, MOTIONS[name]), plan)
    seen = (one.covered & other.covered) > 0
    assert seen.sum() > 500
    np.testing.assert_allclose(
        one.radiance()[seen], other.radiance()[seen], rtol=2e-6, atol=1e-9
    )
