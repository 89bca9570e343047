"""The measured trade of speed for accuracy: what is tried, timed and compared."""

import numpy as np
import pytest

from meshes import sphere
from skinviz import (
    Camera,
    DirectionalLight,
    Illuminant,
    Plan,
    Skin,
    TorranceSparrow,
    geometry_of,
    render,
)
from skinviz.errors import ArgumentError
from skinviz.rendering.knobs import KNOBS
from skinviz.rendering.spectral import light_spectra, white_xyz
from skinviz.rendering.stage import stage_of
from skinviz.rendering.tolerance import compare
from skinviz.rendering.tradeoff import front, tradeoff
from skinviz.rendering.ways import (
    GROUPS,
    ONE_KNOB,
    PLAIN,
    PLAIN_WAY,
    REFERENCE,
    TOLERANCE,
    UNIFORM,
    Way,
    ways,
)
from skinviz.rendering.work import work_of

FEW_ROWS = 8  # a picture so high has its spectra compared in every row


@pytest.fixture
def ball(matt):
    """A glossy ball in a picture of few rows."""
    return matt.replace(
        mesh=sphere(40, 2),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([0.4, 0.3, 1]),),
        camera=Camera([0, 0, 1], [0, 1, 0], (24, FEW_ROWS), height=50.0),
    )


@pytest.fixture
def mapped(ball):
    rng = np.random.default_rng(3)
    values = rng.uniform(0.004, 0.05, (ball.mesh.n_points, 3))
    return ball.replace(skin=Skin(ball.skin.model, values))


TRIED = [
    Way(REFERENCE, "everything", Plan()),
    Way(PLAIN_WAY, "plain", PLAIN),
    Way(UNIFORM, "4", Plan(samples=4)),
    Way(ONE_KNOB, "specular: none", Plan(specular="none")),
    Way(TOLERANCE, "4 again", Plan(samples=4, tolerance=100.0), 100.0, 7.0),
    Way(TOLERANCE, "too tight", Plan(samples=1, tolerance=1e-9), 1e-9, 7.0),
]


# Ways ---------------------------------------------------------------------------


@pytest.mark.parametrize("interreflection", ["none", "diffuse"])
def test_every_cheaper_level_of_every_knob_is_tried_alone(mapped, interreflection):
    scene = mapped.replace(interreflection=interreflection)
    found = ways(scene, (1.0,))
    alone = {way.plan for way in found if way.group == ONE_KNOB}
    work = work_of(stage_of(scene))
    levels = [level for knob in KNOBS for level in knob.levels(work)[:-1]]
    assert alone == {Plan(**level) for level in levels}
    fields = {name for level in levels for name in level}
    assert fields == {
        *("spectrum", "reflectance", "arithmetic", "shadows", "specular", "shading"),
        *("samples", "refine"),
        *(("bounce_rays",) if interreflection == "diffuse" else ()),
    }


def test_ways_begin_with_the_reference_and_repeat_only_plans(ball):
    found = ways(ball, (0.5, 5.0))
    assert found[0].plan == Plan()
    assert {way.group for way in found} <= set(GROUPS)
    others = [way.setting for way in found if way.group != TOLERANCE]
    assert len(others) == len(set(others))
    planned = [way for way in found if way.group == TOLERANCE]
    assert [way.plan.tolerance for way in planned] == [0.5, 5.0]
    assert all(way.planning > 0 for way in planned)
    samples = {way.plan.samples for way in found if way.group == UNIFORM}
    assert samples == {1, 2, 4, 8}


# Measures -----------------------------------------------------------------------


def test_differences_are_those_of_the_pictures(ball):
    trades = tradeoff(ball, TRIED)
    assert [trade.way for trade in trades] == TRIED
    reference, white = render(ball, Plan()), white_xyz(ball)
    spectra = reference.radiance().astype(float)
    filled = (reference.covered == 16) & (reference.xyz[..., 1] > 0)
    E = light_spectra(ball)[0]
    for trade in trades:
        own = render(ball, trade.way.plan)
        assert trade.difference == compare(
            own.xyz, reference.xyz, reference.covered, white
        )
        off = (own.radiance().astype(float) - spectra)[filled]
        np.testing.assert_allclose(
            trade.spectral_rmse,
            np.sqrt(np.mean(off**2)) / np.sqrt(np.mean(E**2)),
            rtol=1e-9,
        )
        assert trade.ms > 0
    first = trades[0]
    assert (first.difference.most_filled, first.spectral_rmse) == (0, 0)
    assert trades[3].spectral_rmse > 0.001


def test_what_plans_were_made_for_is_kept_or_not(ball):
    trades = tradeoff(ball, TRIED)
    assert [trade.kept for trade in trades] == [None] * 4 + [True, False]


def test_equal_pictures_are_measured_once(ball):
    trades = tradeoff(ball, TRIED)
    assert trades[2].ms == trades[4].ms
    assert trades[4].way.planning == 7.0


def test_the_front_is_of_ways_that_keep_their_edges(ball):
    whole = ball.replace(camera=Camera([0, 0, 1], [0, 1, 0], (24, 24)))
    trades = tradeoff(whole, TRIED[:3])
    assert trades[0].edges_kept
    assert trades[0].on_front
    plain = trades[1]
    assert plain.difference.most_edge > max(2, plain.difference.most_filled)
    assert not plain.edges_kept
    assert not plain.on_front


def test_progress_is_told_way_by_way(ball):
    told = []
    tradeoff(ball, TRIED[:3], geometry=geometry_of(ball.mesh), advance=told.append)
    assert told == [1, 1, 1]


def test_mapped_skin_with_light_between_parts_is_measured(mapped):
    scene = mapped.replace(interreflection="diffuse")
    tried = [
        TRIED[0],
        Way(ONE_KNOB, "spectrum: 6 nodes", Plan(spectrum="6 nodes")),
        Way(ONE_KNOB, "bounce: none", Plan(bounce_rays=0)),
    ]
    _, nodes, dark = tradeoff(scene, tried)
    assert 0 < nodes.difference.most_filled < 1
    assert nodes.spectral_rmse == 0  # spectra are always on the scene's bands
    assert dark.difference.most_filled == 0  # a ball throws no light on itself


# What cannot be had -------------------------------------------------------------


def test_levels_that_cannot_be_had_are_told(mapped):
    narrow = DirectionalLight([0, 0, 1], Illuminant("narrow", [450.0, 650.0], [1, 1]))
    tried = [TRIED[0], Way(ONE_KNOB, "spectrum", Plan(spectrum="scene")), TRIED[2]]
    first, bands, four = tradeoff(mapped.replace(lights=(narrow,)), tried)
    assert (bands.ms, bands.difference, bands.spectral_rmse) == (None, None, None)
    assert "450 to 650 nm" in bands.note
    assert not bands.on_front
    assert bands.kept is None
    for trade in (first, four):  # whose colours can be had, but not their spectra
        assert trade.difference is not None
        assert trade.spectral_rmse is None
        assert "450 to 650 nm" in trade.note


@pytest.mark.parametrize("direction", [[0, 0, -1], [0.01, 0, -1]])
def test_a_black_picture_has_nothing_to_trade(ball, direction):
    with pytest.raises(ArgumentError, match=r"no light to compare: .*behind"):
        tradeoff(ball.replace(lights=(DirectionalLight(direction),)), TRIED)


# The front ----------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_the_front_is_what_nothing_beats(seed):
    rng = np.random.default_rng(seed)
    cost, error = rng.integers(0, 6, (2, 25)).astype(float)
    cost[rng.integers(0, 25, 3)] = np.nan
    error[rng.integers(0, 25, 3)] = np.nan
    on_it = front(cost, error)
    for i in range(25):
        beaten = ((cost <= cost[i]) & (error < error[i])) | (
            (cost < cost[i]) & (error <= error[i])
        )
        fit = np.isfinite(cost[i]) and np.isfinite(error[i]) and not beaten.any()
        assert on_it[i] == fit


def test_there_is_no_front_of_nothing():
    assert front([], []).size == 0
    assert not front([np.nan, 1.0], [1.0, np.nan]).any()
