"""Prices by a pilot are bounds on what a setting changes in the whole picture."""

import numpy as np
import pytest
from planned_scenes import SCENES

from skinviz import Plan, render
from skinviz.rendering.pilot import pilot_of
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.stage import stage_of
from skinviz.rendering.tolerance import compare
from skinviz.rendering.trial import Trial
from skinviz.spectra.illuminants import Illuminant

# Of mapped skin a sum over fewer wavelengths, so that references are quick.
BASE = Plan(bounce_rays=64, spectrum="16")

SETTINGS = {
    "shadows": {"shadows": False},
    "specular": {"specular": "none"},
    "index": {"specular": "constant"},
    "shading": {"shading": "vertices"},
    "one ray": {"samples": 1, "refine": 1e6},
    "refined": {"samples": 1, "refine": 8.0},
    "finely refined": {"samples": 4, "refine": 2.0},
}


@pytest.fixture(
    scope="module",
    params=["hand", "two lamps", "dispersion", "bounce", "map", "few pixels"],
)
def trial(request, model):
    stage = stage_of(SCENES[request.param](model), BASE)
    return Trial(pilot_of(stage), stage, stage)


@pytest.fixture(scope="module")
def reference(trial):
    return render(trial.stage.scene, BASE)


def in_the_picture(trial, reference, setting):
    """What a setting changes in the whole picture."""
    picture = render(trial.stage.scene, BASE.replace(**setting))
    white = white_xyz(trial.stage.scene)
    return compare(picture.xyz, reference.xyz, reference.covered, white)


def price(trial, setting):
    if "samples" in setting:
        return trial.sampling_difference(setting)
    return trial.difference(setting)


@pytest.mark.parametrize("name", SETTINGS)
def test_prices_bound_what_changes_in_the_picture(trial, reference, name):
    found = in_the_picture(trial, reference, SETTINGS[name])
    bound = price(trial, SETTINGS[name])
    if trial.pilot.complete:
        assert bound == pytest.approx(found.most_filled, rel=1e-3, abs=1e-3)
    elif np.isfinite(bound):
        assert bound >= found.filled * (1 - 1e-3) - 1e-4
        assert bound <= found.most_filled * (1 + 1e-3) + 1e-4


def test_what_changes_nothing_costs_nothing(trial):
    assert trial.difference({}) == 0
    assert trial.sampling_difference({"samples": 16, "refine": None}) == 0
    assert trial.edge_difference({}) == 0


def test_refining_more_never_changes_more(trial):
    prices = [
        trial.sampling_difference({"samples": 1, "refine": refine})
        for refine in (64.0, 16.0, 4.0, 1.0)
    ]
    assert prices == sorted(prices, reverse=True)


def test_edges_change_as_they_do_in_the_picture(trial):
    # The edges' share of the tolerance is two at least.
    picture = render(trial.stage.scene, BASE.replace(specular="none"))
    reference = render(trial.stage.scene, BASE)
    white = white_xyz(trial.stage.scene)
    found = compare(picture.xyz, reference.xyz, reference.covered, white)
    own = trial.edge_difference({"specular": "none"})
    assert own <= 1.2 * found.most_edge
    if found.edge > 2.5:
        assert own > 2


@pytest.mark.parametrize("name", ["shadows", "specular", "shading"])
def test_edges_are_priced_by_what_changes_at_edges(trial, reference, name):
    found = in_the_picture(trial, reference, SETTINGS[name])
    price = trial.edge_difference(SETTINGS[name])
    assert price <= found.most_edge * (1 + 1e-3) + 1e-4
    if found.n_edge < 700:  # all are looked at
        assert price >= found.edge * (1 - 1e-3) - 1e-4


def test_edges_do_not_mind_the_sampling(trial):
    assert trial.edge_difference({"samples": 1, "refine": 64.0}) == 0


def test_a_trial_goes_on_with_what_the_base_alone_decides(trial):
    truth = trial.truth
    other = trial.stage.replanned(specular="none")
    later = trial.after(other)
    assert later.truth is truth
    assert later.stage is other
    assert later.base is trial.base
    # And what was decided counts: nothing more changes by the same setting.
    again = later.difference({"specular": "none"})
    assert again == pytest.approx(trial.difference({"specular": "none"}), rel=1e-9)
    assert later.difference({}) == again


def test_fewer_wavelengths_are_priced_against_every_nanometre(model):
    scene = SCENES["map"](model)
    stage = stage_of(scene, Plan())
    own = Trial(pilot_of(stage), stage, stage)
    prices = {
        name: own.body_difference({"spectrum": name})
        for name in ("6 nodes", "10 nodes", "16", "31", "1 nm")
    }
    assert prices["1 nm"] == pytest.approx(0, abs=1e-4)
    assert prices["31"] < prices["16"]
    assert prices["10 nodes"] < prices["6 nodes"]
    exact, coarse = (render(scene, Plan(1, spectrum=s)) for s in ("1 nm", "6 nodes"))
    full = np.where(exact.covered == 1, 16, 0)
    found = compare(coarse.xyz, exact.xyz, full, white_xyz(scene))
    assert found.filled * 0.999 <= prices["6 nodes"] <= 2 * found.most_filled


def test_bands_that_a_lamp_does_not_cover_are_no_choice(model):
    scene = SCENES["map"](model)
    low = Illuminant("low", [400.0, 450.0], [1.0, 1.0])
    high = Illuminant("high", [600.0, 650.0], [1.0, 1.0])
    light = scene.lights[0]
    lights = tuple(type(light)(light.direction, lamp) for lamp in (low, high))
    stage = stage_of(scene.replace(lights=lights), Plan())
    own = Trial(pilot_of(stage), stage, stage)
    assert own.body_difference({"spectrum": "16"}) == np.inf
    assert own.body_difference({"spectrum": "10 nodes"}) < 5


@pytest.mark.parametrize("n", [0, 16, 64, 256])
def test_fewer_rays_between_parts_change_more(model, n):
    stage = stage_of(SCENES["bounce"](model), Plan())
    own = Trial(pilot_of(stage), stage, stage)
    few, more = (
        own.bounce_difference({"bounce_rays": 0}),
        own.bounce_difference({"bounce_rays": n}),
    )
    assert (more < few) == (n > 0)
