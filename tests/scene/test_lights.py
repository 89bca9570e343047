"""Lights: what they are as homogeneous points, and what is no light."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolerances import ROUNDING

from skinviz import DirectionalLight, PointLight
from skinviz.errors import ArgumentError
from skinviz.spectra.illuminants import Illuminant, cie_illuminant

Z = [0.0, 0.0, 1.0]
LAMP = Illuminant("my lamp", [380, 780], [1, 2])


@given(st.lists(st.floats(-1e150, 1e150), min_size=3, max_size=3).filter(any))
def test_far_lights_are_directions_of_length_one(direction):
    light = DirectionalLight(direction)
    *at, near = light.homogeneous
    assert near == 0
    np.testing.assert_allclose(np.linalg.norm(at), 1, rtol=ROUNDING)
    largest = np.abs(direction).max()
    np.testing.assert_allclose(
        np.cross(at, np.array(direction) / largest), 0, atol=1e-14
    )


def test_near_lights_stay_where_they_are():
    light = PointLight([1, -2, 3e8])
    np.testing.assert_array_equal(light.homogeneous, [1, -2, 3e8, 1])
    assert light.position.dtype == np.float64


@pytest.mark.parametrize("kind", [DirectionalLight, PointLight])
@pytest.mark.parametrize(
    ("illuminant", "name"),
    [("D65", "D65"), ("f2", "FL2"), ("3200 K", "black body 3200 K"), (LAMP, "my lamp")],
)
def test_a_lights_spectrum_is_named_or_measured(kind, illuminant, name):
    light = kind(Z, illuminant)
    assert light.spectrum.name == name
    assert light.spectrum is light.spectrum  # read once
    assert (light.spectrum.spd([450, 550.0]) > 0).all()


def test_a_named_light_is_the_cies():
    light = PointLight(Z, "A")
    nm = np.arange(400.0, 701, 5)
    np.testing.assert_array_equal(light.spectrum.spd(nm), cie_illuminant("A").spd(nm))


@pytest.mark.parametrize("kind", [DirectionalLight, PointLight])
@pytest.mark.parametrize("strength", [0, -1, 1e-31, 1e31, np.nan, np.inf, "1", True])
def test_impossible_strengths_are_refused(kind, strength):
    with pytest.raises(ArgumentError, match="light strength"):
        kind(Z, strength=strength)


@pytest.mark.parametrize("kind", [DirectionalLight, PointLight])
@pytest.mark.parametrize("illuminant", ["D66", "", None, 5, "10 K", "1e9 K"])
def test_unknown_illuminants_are_refused_when_the_light_is_made(kind, illuminant):
    with pytest.raises(ArgumentError):
        kind(Z, illuminant)


def test_the_message_lists_the_nearest_names():
    with pytest.raises(ArgumentError, match=r"'D66'.*did you mean 'D65'"):
        PointLight(Z, "D66")


@pytest.mark.parametrize(
    "position",
    [[0, 0], [0, 0, np.nan], [0, np.inf, 0], [2e9, 0, 0], [[1, 2, 3]], "here", None],
)
def test_impossible_positions_are_refused(position):
    with pytest.raises(ArgumentError, match="light position"):
        PointLight(position)


def test_a_too_far_position_says_what_to_give_instead():
    with pytest.raises(ArgumentError, match=r"1e\+09 mm.*direction"):
        PointLight([0, 0, 1e12])


def test_places_are_told_in_words():
    assert DirectionalLight([0, 3, 4]).place == "from [0.0, 0.6, 0.8]"
    assert PointLight([1, 2.00001, 3]).place == "at [1.0, 2.0, 3.0] mm"


@pytest.mark.parametrize("light", [DirectionalLight(Z), PointLight(Z)])
def test_lights_are_frozen_and_changed_by_replacing(light):
    with pytest.raises(dataclasses.FrozenInstanceError):
        light.strength = 2.0
    other = dataclasses.replace(light, illuminant="A", strength=3)
    assert (light.spectrum.name, other.spectrum.name) == ("D65", "A")
