"""Small scenes, each with something that a plan may or may not leave out.

And the rates of one machine, so that plans do not depend on who makes them.
"""

import numpy as np

from meshes import joined, plane, sphere, toy_hand, wave
from skinviz import (
    Camera,
    DirectionalLight,
    PointLight,
    Scene,
    Skin,
    TorranceSparrow,
)
from skinviz.rendering.rates import Rates
from skinviz.spectra.illuminants import line_lamp
from skinviz.surface.dispersion import dispersion

RATES = Rates(
    ray=270.0,
    shadow=170.0,
    point=10.0,
    index=13.0,
    band=70.0,
    mix=0.5,
    look=150.0,
    blend=5.0,
    bounce=310.0,
)
"""Of a machine with two slow processors. [ns]"""

UP, FINGERS = [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
MERCURY = line_lamp([[404.7, 0.2], [435.8, 0.3], [546.1, 1.0], [578.0, 0.4]])
BACK = [0.2, 1.0, 0.1]  # from where the back of the hand is seen


def hand(model, **changes):
    """A mitten of even skin, seen from its back and lit from aside."""
    scene = Scene(
        mesh=toy_hand(),
        skin=Skin(model, [0.1, 0.005, 0.005]),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([-1, 0.8, 0.4]),),
        camera=Camera(BACK, FINGERS, (176, 176)),
    )
    return scene.replace(**changes)


def pigments(mesh, noise=0.0):
    """Pigments that vary smoothly over some mm, and from vertex to vertex."""
    x, y, z = np.asarray(mesh.points).T / 25
    rng = np.random.default_rng(3)
    values = np.stack(
        [
            0.14 + 0.08 * np.sin(2 * x + 1) * np.cos(3 * z),
            0.006 + 0.004 * np.cos(3 * y + z),
            0.004 + 0.003 * np.sin(2 * x - z),
        ],
        axis=1,
    )
    return values * np.exp(noise * rng.normal(size=values.shape))


def mapped(model, noise=0.0, **changes):
    """The mitten with a map of pigments."""
    mesh = toy_hand()
    own = {"camera": Camera(BACK, FINGERS, (88, 88)), **changes}
    return hand(model, mesh=mesh, skin=Skin(model, pigments(mesh, noise)), **own)


def folds(model, *, pigmented=False, **changes):
    """A ball over a wave of skin, which throw light and shadow on each other."""
    n, ball = (13, 1) if pigmented else (21, 2)
    mesh = joined(wave(n), sphere(8, ball, centre=(2, -3, 9)))
    skin = Skin(model, pigments(mesh) if pigmented else [0.05, 0.004, 0.005])
    own = {
        "camera": Camera([0.2, -0.3, 1], UP, (152, 152)),
        "lights": (DirectionalLight([-0.8, 0.2, 1]),),
        **changes,
    }
    return hand(model, mesh=mesh, skin=skin, **own)


SCENES = {
    "hand": hand,
    "headlight": lambda m: hand(
        m,
        lights=(DirectionalLight(BACK),),
        surface=TorranceSparrow(specular_scale=0.0),
    ),
    "narrow highlight": lambda m: hand(m, surface=TorranceSparrow(gamma=0.05)),
    "grazing": lambda m: hand(m, lights=(DirectionalLight([-1, 0.08, 0.1], "A"),)),
    "crescent": lambda m: hand(m, lights=(DirectionalLight([-1, -0.9, 0.1]),)),
    "two lamps": lambda m: hand(
        m,
        lights=(
            DirectionalLight([-1, 0.8, 0.4], "A"),
            PointLight([150, 200, 60], "FL11", 0.5),
        ),
        camera=Camera(BACK, FINGERS, (176, 176), distance=500.0),
    ),
    "laser": lambda m: hand(
        m, lights=(DirectionalLight([-1, 0.8, 0.4], line_lamp([[580.0, 1.0]])),)
    ),
    "dispersion": lambda m: hand(
        m, surface=TorranceSparrow(n=dispersion("epidermis"), gamma=0.2)
    ),
    "part": lambda m: hand(
        m, camera=Camera(BACK, FINGERS, (160, 176), target=[20, 0, 90], height=70.0)
    ),
    "bounce": lambda m: folds(m, interreflection="diffuse"),
    "over-exposed": lambda m: folds(m, exposure=6.0),
    "map": mapped,
    "rough map": lambda m: mapped(m, noise=0.3),
    "map, mercury": lambda m: mapped(
        m, lights=(DirectionalLight([-1, 0.8, 0.4], MERCURY),)
    ),
    "map, bounce": lambda m: folds(
        m,
        pigmented=True,
        interreflection="diffuse",
        camera=Camera([0.2, -0.3, 1], UP, (56, 56)),
    ),
    "few pixels": lambda m: hand(m, camera=Camera(BACK, FINGERS, (36, 36))),
}
"""Scenes by name, made of a model of skin."""


def under_a_roof(model):
    """A plate in the shadow of another, with a border of light."""
    mesh = joined(plane(9), plane(5, 24.0))
    points = np.array(mesh.points)
    points[81:, 2] += 12.0
    mesh.points = points
    return hand(
        model,
        mesh=mesh,
        camera=Camera([0.7, 0, 1], UP, (176, 176)),
        lights=(DirectionalLight([-0.5, 0, 1]),),
    )
