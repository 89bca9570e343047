"""A fit as JSON: every number there, and none where it is not known."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skinviz import ArgumentError, fit_skin, skin_model
from skinviz.skin.report import FIT_FORMAT, fit_to_dict

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="cheek", specular="included")
LABELS = ["A", "B", "dark"]


@pytest.fixture(scope="module")
def fit():
    """Two skins, one of them with bands missing, and a refused spectrum."""
    data = MODEL.measured([[0.1, 0.01, 0.005], [0.2, 0.0, 0.0], [0.1, 0.1, 0.1]], NM)
    data += np.random.default_rng(1).normal(0, 1e-3, data.shape)
    data[1, :5] = np.nan
    data[2] = np.nan
    return fit_skin(data, NM, MODEL)


def reread(fit, labels):
    """Return the report after a journey through strict JSON."""
    return json.loads(json.dumps(fit_to_dict(fit, labels), allow_nan=False))


def test_json_brings_every_number_back(fit):
    told = reread(fit, LABELS)
    assert told == fit_to_dict(fit, LABELS)
    assert [entry["label"] for entry in told["fits"]] == LABELS
    for i, entry in enumerate(told["fits"][:2]):
        for k, name in enumerate(fit.parameters):
            weight = entry["parameters"][name]
            assert weight["value"] == fit.values[i, k]
            assert [weight["lower"], weight["upper"]] == fit.interval[i, k].tolist()
        assert entry["status"] == fit.status[i]
        assert entry["sse"] == fit.sse[i]
        assert entry["rmse"] == fit.rmse[i]
        assert entry["delta_e_2000"] == fit.delta_e[i]
        assert entry["blood_fraction"] == fit.blood_fraction[i]
        saturation = entry["oxygen_saturation"]
        bounds = [saturation["lower"], saturation["upper"]]
        assert bounds == fit.oxygen_saturation_interval[i].tolist()


def test_sse_is_told_as_61_bands(fit):
    told = reread(fit, LABELS)["fits"]
    assert [entry["n_bands"] for entry in told] == [31, 26, 0]
    assert_allclose(told[0]["sse_61"], fit.sse[0] * 61 / 31)
    assert_allclose(told[1]["sse_61"], fit.sse[1] * 61 / 26)


def test_what_is_not_known_is_none(fit):
    refused = reread(fit, LABELS)["fits"][2]
    assert refused["status"] == "refused"
    unknown = {"value": None, "lower": None, "upper": None}
    assert refused["parameters"] == dict.fromkeys(fit.parameters, unknown)
    assert refused["oxygen_saturation"] == unknown
    for name in ("blood_fraction", "sse", "sse_61", "rmse", "delta_e_2000"):
        assert refused[name] is None


def test_the_report_makes_the_model_anew(fit):
    told = reread(fit, LABELS)
    assert told["format"] == FIT_FORMAT
    again = skin_model(
        told["model"],
        thickness=tuple(told["thickness_mm"]),
        specular=told["specular"],
        coefficients=told["coefficients"],
    )
    assert again.description == MODEL.description


def test_endless_skin_is_told_in_json_too():
    model = skin_model(thickness=(0.03, np.inf), specular="excluded")
    data = model.measured([0.1, 0.01, 0.005], NM)
    told = reread(fit_skin(data, NM, model), ["endless"])
    assert told["thickness_mm"][0] == 0.03


def test_a_grid_of_spectra_is_told_in_order():
    data = MODEL.measured(np.linspace(0.01, 0.1, 18).reshape(2, 3, 3), NM)
    grid = fit_skin(data, NM, MODEL)
    told = reread(grid, [str(i) for i in range(6)])["fits"]
    values = [entry["parameters"]["w_m"]["value"] for entry in told]
    assert values == grid.values[..., 0].ravel().tolist()


@pytest.mark.parametrize("labels", [["A"], ["A", "B", "C", "D"]])
def test_every_spectrum_needs_a_label(fit, labels):
    with pytest.raises(ArgumentError, match="label"):
        fit_to_dict(fit, labels)
