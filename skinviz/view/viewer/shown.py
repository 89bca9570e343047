"""From a state to the scenes that it shows."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.scene.camera import Camera
from skinviz.scene.lights import DirectionalLight, Light, PointLight
from skinviz.scene.scene import Scene
from skinviz.surface.models import surface_model, surface_parameters
from skinviz.surface.surface import Surface
from skinviz.view.viewer.opened import WIDTHS, Opened, as_shown, centroid
from skinviz.view.viewer.samples import Sample
from skinviz.view.viewer.state import Look, ViewState
from skinviz.view.viewer.turning import eye, towards

Array = NDArray[np.float64]
Size = tuple[int, int]

_SURFACE = ("surface", "width", "index", "specular_scale")


def sample_of(opened: Opened, look: Look) -> Sample:
    """Return whose skin a hand has."""
    if not look.person:
        return opened.own
    return opened.samples.sample(look.person, look.site)


def scenes_of(
    opened: Opened, state: ViewState, samples: tuple[Sample, ...], size: Size
) -> tuple[Scene, ...]:
    """Return the scene of each hand that is shown, alike but for the skin.

    Parameters
    ----------
    opened : Opened
        What was opened.
    state : ViewState
        What is shown of it.
    samples : tuple of Sample
        Of each hand, from :func:`sample_of`.
    size : (int, int)
        Of each picture. [pixels]
    """
    scene = opened.scene.replace(
        surface=surface_of(opened, state),
        lights=(_light(opened, state), *opened.scene.lights[1:]),
        camera=camera_of(opened, state, size),
        exposure=state.exposure,
        white=state.white,
    )
    return tuple(
        scene.replace(skin=as_shown(sample, look.weights))
        for sample, look in zip(samples, state.looks, strict=True)
    )


def camera_of(opened: Opened, state: ViewState, size: Size) -> Camera:
    """Return the viewer: what the scene's camera frames, turned, zoomed and shifted."""
    given = dataclasses.replace(opened.scene.camera, size=size)
    framed = given.view(opened.geometry.in_mm)
    if _is_initial(opened, state, ("view", "zoom", "shift")):
        return given
    direction, up = eye(opened.frame, state.view)
    x, y = state.shift
    return dataclasses.replace(
        given,
        direction=direction,
        up=up,
        target=framed.target + x * np.cross(up, direction) + y * up,
        height=framed.pixel * size[1] / state.zoom,
    )


def surface_of(opened: Opened, state: ViewState) -> Surface:
    """Return the surface."""
    if _is_initial(opened, state, _SURFACE):
        return opened.scene.surface
    known = surface_parameters(state.surface)
    own = opened.scene.surface
    said: dict[str, Any] = {
        WIDTHS.get(state.surface, ""): state.width,
        "n": index_value(state.index),
        "specular_scale": state.specular_scale,
        "masking": getattr(own, "masking", "v-cavity"),
    }
    return surface_model(state.surface, **{k: said[k] for k in said if k in known})


def _light(opened: Opened, state: ViewState) -> Light:
    """Return the first light, turned and with its lamp changed."""
    light = opened.scene.lights[0]
    if state.illuminant:
        light = dataclasses.replace(light, illuminant=state.illuminant)
    if _is_initial(opened, state, ("light",)):
        return light
    direction = towards(opened.frame, *state.light)
    if isinstance(light, DirectionalLight):
        return dataclasses.replace(light, direction=direction)
    middle = centroid(opened.geometry)
    distance = float(np.linalg.norm(light.position - middle))
    return PointLight(middle + distance * direction, light.illuminant, light.strength)


def _is_initial(opened: Opened, state: ViewState, names: tuple[str, ...]) -> bool:
    """Return whether attributes are as at first: then the scene's own are exact."""
    return all(getattr(state, n) == getattr(opened.initial, n) for n in names)


def index_value(text: str) -> float | str:
    """Return a refractive index, or the name of a tissue that disperses."""
    try:
        return float(text)
    except ValueError:
        return text
