"""A model, a mesh and a scene that tests change one thing of."""

import pytest

from meshes import plane
from skinviz import Camera, DirectionalLight, Scene, Skin, TorranceSparrow, skin_model


@pytest.fixture(scope="session")
def model():
    return skin_model(site="back of hand", specular="included")


@pytest.fixture
def scene(model):
    return Scene(
        mesh=plane(),
        skin=Skin(model, [0.1, 0.005, 0.005]),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([0, 0, 1]),),
        camera=Camera([0, 0, 1], [0, 1, 0], (32, 24)),
    )
