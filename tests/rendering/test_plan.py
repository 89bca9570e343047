"""Plans: the fixed grid of samples, its subsets, and what is no plan."""

import dataclasses
import json

import numpy as np
import pytest

from skinviz import Plan
from skinviz.errors import ArgumentError
from skinviz.rendering.finding import Finding
from skinviz.rendering.plan import SAMPLES

NAMED = ("spectrum", "reflectance", "specular", "shading", "basis", "arithmetic")


def test_sixteen_samples_are_the_middles_of_a_grid_of_4_by_4():
    middles = (np.arange(4) + 0.5) / 4
    grid = {(x, y) for x in middles for y in middles}
    assert {tuple(cell) for cell in Plan().cells} == grid
    assert Plan().cells.shape == (16, 2)


@pytest.mark.parametrize("samples", SAMPLES)
def test_fewer_samples_are_the_first_of_more(samples):
    np.testing.assert_array_equal(Plan(samples).cells, Plan(16).cells[:samples])
    assert len({tuple(cell) for cell in Plan(samples).cells}) == samples


@pytest.mark.parametrize("samples", SAMPLES[1:])
def test_samples_are_centred_in_their_pixel(samples):
    np.testing.assert_array_equal(Plan(samples).cells.mean(axis=0), [0.5, 0.5])


def test_one_sample_is_as_near_to_the_middle_as_any_of_the_grid():
    off = np.abs(Plan().cells - 0.5).sum(axis=1)
    assert np.abs(Plan(1).cells[0] - 0.5).sum() == off.min()


@pytest.mark.parametrize("samples", SAMPLES[2:])
def test_every_row_and_column_of_the_grid_has_as_many_samples(samples):
    for axis in np.floor(4 * Plan(samples).cells).astype(int).T:
        assert np.bincount(axis).tolist() == [samples // 4] * 4


@pytest.mark.parametrize(("samples", "worst"), [(2, 0.4375), (4, 0.25), (8, 0.125)])
def test_fewer_samples_find_nearly_the_share_that_sixteen_do(samples, worst):
    # Of a pixel that an edge at any angle crosses anywhere.
    rng = np.random.default_rng(0)
    turn, place = rng.uniform(0, 2 * np.pi, 20000), rng.uniform(-0.7, 0.7, 20000)
    across = np.stack([np.cos(turn), np.sin(turn)], axis=1)

    def share(cells):
        return (across @ (cells - 0.5).T < place[:, None]).mean(axis=1)

    off = np.abs(share(Plan(samples).cells) - share(Plan().cells))
    assert off.max() <= worst


def test_plans_are_frozen_and_say_what_they_are_as_json():
    plan = Plan(np.int64(4), np.bool(False), np.float64(64))
    assert plan == Plan(4, False, 64)
    told = json.loads(json.dumps(dataclasses.asdict(plan)))
    assert told | {"samples": 4, "shadows": False, "bounce_rays": 64} == told
    assert told["findings"] == []
    with pytest.raises(dataclasses.FrozenInstanceError):
        plan.samples = 8


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        *(
            ({"samples": samples}, "samples must be")
            for samples in (0, 3, 32, -1, 1.5, np.nan, np.inf, True, "16", None, [4])
        ),
        ({"samples": 5}, "one of 1, 2, 4, 8, 16; got 5"),
        *(
            ({"bounce_rays": rays}, "bounce_rays must be")
            for rays in (-1, 1, 15, 65537, 100.5, np.nan, "many", None, True)
        ),
        *(({name: "best"}, name) for name in NAMED),
        *(({"refine": limit}, "refine must be") for limit in (-1, np.nan, "much")),
        *(({"shadows": shadows}, "shadows must be") for shadows in ("no", 1, None)),
    ],
)
def test_what_is_no_plan_is_refused_by_name(arguments, told):
    with pytest.raises(ArgumentError, match=told):
        Plan(**arguments)


def test_what_could_not_be_told_of_a_level_is_none_that_json_can_hold():
    finding = Finding("shadows", "cast", refused="none", refused_delta_e=np.inf)
    assert finding.refused_delta_e is None
    told = json.dumps(dataclasses.asdict(Plan(findings=(finding,))), allow_nan=False)
    assert json.loads(told)["findings"][0]["refused"] == "none"
    assert "none" in Plan(tolerance=1.0, findings=(finding,)).explain()
