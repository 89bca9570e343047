"""The curves beside the hand are the spectra behind it."""

import dataclasses
import json

import numpy as np

from skinviz import DirectionalLight, Skin, line_lamp
from skinviz.view.viewer.curves import (
    VISIBLE,
    illuminant_chart,
    radiance_chart,
    reflectance_chart,
)
from skinviz.view.viewer.pictures import Darkroom
from skinviz.view.viewer.readings import readings_of

SIZE = (60, 48)


def named(chart):
    return {trace["name"]: np.array(trace["y"]) for trace in chart["data"]}


def test_reflectance_is_measured_fitted_and_by_layers(opened, darkroom):
    shown = darkroom.quick(opened.initial, SIZE)
    chart = reflectance_chart(shown)
    curves = named(chart)
    assert list(curves) == ["measured", "fitted", "R<sub>e</sub>", "R<sub>d</sub>"]
    np.testing.assert_allclose(curves["measured"], opened.own.measured, atol=1e-6)
    at = chart["data"][1]["x"]
    fit = opened.own.fit
    np.testing.assert_allclose(
        curves["fitted"], fit.model.measured(fit.values, at), atol=1e-6
    )
    assert chart["layout"]["xaxis"]["range"] == list(VISIBLE)
    assert min(at) == 400
    assert max(at) == 700


def test_bands_that_were_not_measured_are_gaps(opened):
    measured = opened.own.measured.copy()
    measured[3] = np.nan
    own = dataclasses.replace(opened.own, measured=measured)
    shown = Darkroom(dataclasses.replace(opened, own=own)).quick(opened.initial, SIZE)
    chart = reflectance_chart(shown)
    assert chart["data"][0]["y"][3] is None
    assert np.isfinite(chart["layout"]["yaxis"]["range"]).all()
    json.dumps(chart, allow_nan=False)


def test_of_mapped_skin_the_mean_is_drawn(opened):
    values = opened.scene.skin.values * np.linspace(0.5, 1.5, 642)[:, None]
    mapped = opened.scene.replace(skin=Skin(opened.scene.skin.model, values))
    own = dataclasses.replace(opened.own, skin=mapped.skin)
    held = dataclasses.replace(opened, scene=mapped, own=own)
    curves = named(reflectance_chart(Darkroom(held).quick(held.initial, SIZE)))
    expected = opened.scene.skin.model.measured(
        opened.scene.skin.values, np.arange(400.0, 701.0, 5.0)
    )
    np.testing.assert_allclose(curves["mean"], expected, atol=1e-6)


def test_weights_that_are_set_are_not_called_fitted(opened, darkroom):
    state = opened.initial.with_look(weights=(0.3, 0.01, 0.01))
    assert "set" in named(reflectance_chart(darkroom.quick(state, SIZE)))


def test_the_radiance_of_a_point_is_the_sum_of_its_parts(marked):
    shown = marked(SIZE, (31, 22), (22, 30))
    curves = named(radiance_chart(readings_of(shown)))
    for name in "AB":
        parts = curves[f"{name} diffuse"] + curves[f"{name} specular"]
        np.testing.assert_allclose(curves[name], parts, atol=3e-6)


def test_without_points_there_is_no_radiance():
    assert radiance_chart(())["data"] == []
    assert radiance_chart((None,))["data"] == []


def test_lamps_are_drawn_to_1_and_lines_as_spikes(opened):
    (curve,) = illuminant_chart(opened.scene)["data"]
    assert max(curve["y"]) == 1
    laser = DirectionalLight([0, 0, 1], line_lamp([(532.0, 1.0)]))
    (spike,) = illuminant_chart(opened.scene.replace(lights=(laser,)))["data"]
    assert spike["x"] == [532.0] * 3
    assert spike["y"] == [0, 1, 0]
