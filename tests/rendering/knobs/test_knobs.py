"""Every knob: its levels are settings of a plan, the last of them the reference's."""

import dataclasses

import numpy as np
import pytest
from planned_scenes import RATES, SCENES, folds, hand, mapped

from skinviz import Camera, Plan, TorranceSparrow
from skinviz.rendering.knobs import KNOBS, sampling
from skinviz.rendering.plan import SPECTRA
from skinviz.rendering.stage import stage_of
from skinviz.rendering.work import work_of
from skinviz.surface.dispersion import dispersion

NAMES = [knob.name for knob in KNOBS]
SETTINGS = {f.name for f in dataclasses.fields(Plan)} - {"tolerance", "findings"}
LARGE = Camera([0.2, 1, 0.1], [0, 0, 1], (1024, 1024))


@pytest.fixture(scope="module")
def works(model):
    """What scenes of each kind ask for."""
    scenes = {
        "uniform": hand(model, camera=LARGE),
        "mapped": mapped(model, camera=LARGE),
        "bounce": hand(model, camera=LARGE, interreflection="diffuse"),
        "both": folds(model, pigmented=True, interreflection="diffuse"),
        "dispersion": hand(
            model, camera=LARGE, surface=TorranceSparrow(n=dispersion("epidermis"))
        ),
    }
    return {name: work_of(stage_of(scene)) for name, scene in scenes.items()}


def levels_of(knob, works):
    """A knob's levels wherever it has the most of them."""
    return max((knob.levels(work) for work in works.values()), key=len)


def named(name):
    return KNOBS[NAMES.index(name)]


# Every knob ---------------------------------------------------------------------


def test_knobs_have_names_of_their_own():
    assert len(set(NAMES)) == len(NAMES)


def test_every_setting_of_a_plan_is_one_knobs(works):
    owned = [set(levels_of(knob, works)[-1]) for knob in KNOBS]
    assert set.union(*owned) == SETTINGS
    assert sum(map(len, owned)) == len(SETTINGS)


@pytest.mark.parametrize("knob", KNOBS, ids=NAMES)
def test_the_last_level_is_the_references(knob, works):
    for work in works.values():
        for name, value in knob.levels(work)[-1].items():
            assert getattr(Plan(), name) == value


@pytest.mark.parametrize("knob", KNOBS, ids=NAMES)
def test_levels_are_settings_that_differ(knob, works):
    levels = levels_of(knob, works)
    plans = [Plan().replace(**level) for level in levels]
    assert len(set(plans)) == len(plans)
    assert len({frozenset(level) for level in levels}) == 1


@pytest.mark.parametrize("knob", KNOBS, ids=NAMES)
def test_levels_are_told_apart_and_what_they_leave_out(knob, works):
    *cheap, exact = levels_of(knob, works)
    told = [knob.told(Plan().replace(**level)) for level in (*cheap, exact)]
    assert len(set(told)) == len(told)
    assert all(told)
    assert all(knob.beyond(Plan().replace(**level)) for level in cheap)
    assert knob.beyond(Plan().replace(**exact)) == ""


@pytest.mark.parametrize("knob", KNOBS, ids=NAMES)
def test_costs_are_times(knob, works):
    for work in works.values():
        for level in knob.levels(work):
            cost = knob.cost(Plan().replace(**level), work, RATES)
            assert 0 <= cost < np.inf


@pytest.mark.parametrize("knob", KNOBS, ids=NAMES)
def test_costs_scale_with_the_machine(knob, works):
    slow = type(RATES)(**{k: 3 * v for k, v in dataclasses.asdict(RATES).items()})
    for work in works.values():
        for level in knob.levels(work):
            own = Plan().replace(**level)
            cost = knob.cost(own, work, RATES)
            assert knob.cost(own, work, slow) == pytest.approx(3 * cost, rel=1e-12)


@pytest.mark.parametrize("name", ["bounce", "shadows", "specular", "arithmetic"])
def test_exact_levels_cost_more(name, works):
    knob = named(name)
    plan = Plan(reflectance="table", shading="points")
    for work in works.values():
        costs = [
            knob.cost(plan.replace(**level), work, RATES) for level in knob.levels(work)
        ]
        assert costs == sorted(costs)
        assert len(set(costs)) == len(costs)


def test_finer_sums_over_wavelengths_cost_more_where_the_model_is_asked(works):
    finest = [name for name in SPECTRA if name != "scene"]
    for name in ("mapped", "both"):
        costs = [
            sum(k.cost(Plan(spectrum=s), works[name], RATES) for k in KNOBS)
            for s in finest
        ]
        assert costs == sorted(costs)


def test_shares_of_the_tolerance_leave_some_for_the_rest():
    shares = [knob.share for knob in KNOBS if knob.share is not None]
    assert all(0 < share < 1 for share in shares)
    assert sum(shares) < 1


def test_what_is_judged_by_itself_is_decided_first():
    # For the others are judged together with all that was decided before.
    judged = [knob.share is None for knob in KNOBS if knob.measure is not None]
    assert judged == sorted(judged)
    assert KNOBS[-1] is sampling.KNOB


# Where there is a choice --------------------------------------------------------


@pytest.mark.parametrize("name", ["spectrum", "reflectance", "arithmetic"])
def test_uniform_skin_leaves_no_choice_of_its_reflectance(name, works):
    knob = named(name)
    for kind in ("uniform", "bounce", "dispersion"):
        assert len(knob.levels(works[kind])) == 1
    for kind in ("mapped", "both"):
        assert len(knob.levels(works[kind])) > 1


def test_bounces_are_a_choice_only_where_they_are_declared(works):
    choices = {kind: len(named("bounce").levels(work)) for kind, work in works.items()}
    assert {kind for kind, n in choices.items() if n > 1} == {"bounce", "both"}
    for kind in ("uniform", "mapped"):
        assert named("bounce").cost(Plan(), works[kind], RATES) == 0


def test_one_index_is_a_choice_only_where_there_are_more(works):
    for kind, work in works.items():
        names = [level["specular"] for level in named("specular").levels(work)]
        assert ("constant" in names) == (kind == "dispersion")


# Work ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", SCENES)
def test_rays_are_those_of_the_pixels_that_may_show_the_mesh(model, name):
    stage = stage_of(SCENES[name](model))
    work = work_of(stage)
    block, marked = stage.sight.blocks
    width, height = stage.sight.view.size
    may = np.kron(marked, np.ones((block, block), bool))[:height, :width].sum()
    assert may <= work.pixels <= width * height
    assert work.outlined == stage.sight.outlines.sum()
    for samples in (1, 4, 16):
        assert work.rays(Plan(samples)) == samples * work.pixels
    assert work.rays(Plan(16, refine=2.0)) == work.rays(Plan())


def test_refined_pixels_are_counted_once_they_are_known(works):
    work = works["uniform"]
    few = work.pixels - work.outlined
    work.rough[2, 4.0] = 0.25
    expected = 2 * few + 16 * (work.outlined + 0.25 * work.share * few)
    assert work.rays(Plan(2, refine=4.0)) == pytest.approx(expected)
    assert work.points(Plan(2, refine=4.0)) == pytest.approx(work.share * expected)
    assert work.rays(Plan(2, refine=1e6)) == 2 * few + 16 * work.outlined


def test_work_knows_its_scene(works, model):
    kinds = {
        kind: (work.mapped, work.bounces, work.lights) for kind, work in works.items()
    }
    assert kinds["uniform"] == (False, False, 1)
    assert kinds["both"] == (True, True, 1)
    two = work_of(stage_of(SCENES["two lamps"](model)))
    assert two.lights == 2
    assert works["uniform"].vertices == works["uniform"].stage.sight.seen.sum()
