"""What controls show of a state, and what they make of it."""

import dataclasses

import numpy as np
import pytest

from skinviz.errors import ArgumentError
from skinviz.view.viewer.controls import (
    CONTROLS,
    PRESETS,
    control_values,
    saturation_of,
    weight_controls,
    with_preset,
    with_saturation,
    with_weight,
)
from skinviz.view.viewer.state import Look, ViewState


@pytest.fixture
def own(opened):
    return opened.own


def test_weights_are_marked_with_the_fits_interval(own):
    controls = weight_controls(own)
    assert [one["name"] for one in controls] == list(own.fit.parameters)
    for one, value, (low, high) in zip(
        controls, own.fit.values, own.fit.interval, strict=True
    ):
        assert one["from"] <= value < one["to"]
        assert one["low"] * one["to"] == pytest.approx(max(low, 0))
        assert one["high"] * one["to"] == pytest.approx(high)
        assert 0 <= one["low"] < one["high"] <= 1


def test_parameters_with_bounds_on_both_sides_have_them_as_ends(opened):
    """The extended model has some that may be negative."""
    people = dataclasses.replace(opened.samples, options={"model": "extended"})
    sample = people.sample("China/186", "cheek")
    for one, parameter, value in zip(
        weight_controls(sample),
        sample.skin.model.parameters,
        sample.skin.values,
        strict=True,
    ):
        assert one["from"] == parameter.lower
        assert one["from"] <= value <= one["to"] <= parameter.upper
        assert 0 <= one["low"] <= one["high"] <= 1
    state = with_weight(ViewState(), sample, 4, -0.5)
    assert state.look.weights[4] == -0.5


def test_a_weight_is_set_alone(own):
    state = with_weight(ViewState(), own, 1, 0.02)
    expected = own.fit.values.copy()
    expected[1] = 0.02
    np.testing.assert_allclose(state.look.weights, expected)


def test_a_weight_that_is_as_fitted_changes_nothing(own):
    state = ViewState()
    assert with_weight(state, own, 0, float(own.fit.values[0])) is state
    share = saturation_of(own, Look())
    assert with_saturation(state, own, share) is state


def test_saturation_keeps_the_blood(own):
    state = with_saturation(ViewState(), own, 0.25)
    _, oxy, deoxy = state.look.weights
    assert oxy + deoxy == pytest.approx(float(own.fit.blood_fraction))
    assert oxy / (oxy + deoxy) == pytest.approx(0.25)
    assert saturation_of(own, state.look) == pytest.approx(0.25)


def test_without_blood_there_is_no_saturation(own):
    look = Look(weights=(0.1, 0.0, 0.0))
    assert saturation_of(own, look) is None
    state = ViewState(looks=(look,))
    assert with_saturation(state, own, 0.5) is state


def test_a_weight_that_the_model_has_not_is_refused(own):
    with pytest.raises(ArgumentError):
        with_weight(ViewState(), own, 5, 0.1)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_light_and_view(name):
    state = with_preset(ViewState(), name)
    assert name == f"{state.light[0]:g}/{state.view[0]:g}"


def test_unknown_presets_are_refused():
    with pytest.raises(ArgumentError):
        with_preset(ViewState(), "90/90")


def test_controls_read_back_what_they_set():
    values = {
        "illuminant": "A",
        "light_angle": 33,
        "light_tilt": -5,
        "view_angle": 120,
        "view_tilt": 7,
        "width": 0.3,
        "index": "1.5",
        "specular_scale": 0.4,
        "stops": 1.5,
        "adapted": True,
        "tolerance_log": 0.35,
        "hands": 2,
        "active": 1,
        "difference": True,
    }
    assert set(values) == set(CONTROLS)
    state = ViewState()
    for name, value in values.items():
        state = CONTROLS[name][1](state, value)
    assert control_values(state) == values
