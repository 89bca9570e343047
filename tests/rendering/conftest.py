"""Scenes on which eq. (10) has a closed form, and an independent colour library."""

import warnings
from dataclasses import dataclass

import numpy as np
import pytest
from planned_scenes import RATES

from meshes import plane
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    Scene,
    Skin,
    TorranceSparrow,
    skin_model,
)
from skinviz.rendering import planner
from skinviz.rendering.shade import shade, vertex_xyz
from skinviz.rendering.stage import stage_of
from skinviz.skin.model import Parameter
from skinviz.spectra.display import SRGB


@dataclass(frozen=True)
class Painted:
    """A stand-in for a skin model: grey of a reflectance that is its parameter."""

    parameters: tuple[Parameter, ...] = (Parameter("reflectance", "1", 0, 1, "grey"),)
    name: str = "painted"
    limits: tuple[float, float] = (380.0, 780.0)

    @property
    def description(self):
        return {"model": self.name}

    def checked(self, values):
        return np.asarray(values, dtype=np.float64)

    def diffuse(self, values, wavelengths):
        return np.broadcast_to(
            np.asarray(values), (*np.shape(values)[:-1], len(wavelengths))
        )


@pytest.fixture(scope="session")
def colour():
    """The colour-science package; its import warns of what it lacks."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    return colour


@pytest.fixture(scope="session")
def model():
    return skin_model(site="cheek", specular="included")


@pytest.fixture
def matt(model):
    """A Lambertian square of skin, lit and seen along its normal."""
    return Scene(
        mesh=plane(),
        skin=Skin(model, [0.1, 0.005, 0.005]),
        surface=TorranceSparrow(specular_scale=0.0),
        lights=(DirectionalLight([0, 0, 1]),),
        camera=Camera([0, 0, 1], [0, 1, 0], (32, 24)),
    )


@pytest.fixture
def white(matt):
    """The perfect diffuser in the place of the skin."""
    return matt.replace(skin=Skin(Painted(), [1.0]))


@pytest.fixture(scope="module")
def steady():
    """The rates of one machine, on any."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planner, "machine_rates", lambda: RATES)
        patch.setattr(planner, "processors", lambda: 2)
        yield RATES


@pytest.fixture
def xyz_of():
    """Shade a scene and give the XYZ that its colours are made of, with the mesh."""

    def run(scene):
        # Summed over the bands of the radiance itself.
        plan = Plan(spectrum="scene")
        mesh, stage = shade(scene, plan), stage_of(scene, plan, whole=True)
        linear = SRGB.linear(vertex_xyz(stage))
        np.testing.assert_array_equal(mesh.point_data["rgb"], SRGB.encode8(linear)[0])
        return vertex_xyz(stage), mesh

    return run
