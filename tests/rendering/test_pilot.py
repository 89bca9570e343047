"""A pilot's pixels are what they are said to be, drawn evenly, always the same."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from meshes import joined, sphere, toy_hand, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    render,
)
from skinviz.rendering import contrasts
from skinviz.rendering.imager import contrast_white
from skinviz.rendering.painter import Painter
from skinviz.rendering.pilot import EDGES, FILLED, pilot_of, point_colours
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.stage import stage_of
from skinviz.rendering.tolerance import FEW, percentile_bound

UP = [0.0, 1.0, 0.0]
FLOAT32 = 2.0**-23


def hand(matt, size, **changes):
    return matt.replace(
        mesh=toy_hand(),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([-1, 0.6, 0.4]), PointLight([100, 200, 90], "A", 0.2)),
        camera=Camera([0.3, 1, 0.1], [0, 0, 1], size),
        **changes,
    )


def folds(matt, size, **changes):
    mesh = joined(wave(21), sphere(8, 2, centre=(2, -3, 12)))
    rng = np.random.default_rng(7)
    return matt.replace(
        mesh=mesh,
        skin=Skin(matt.skin.model, rng.uniform(0.001, 0.1, (mesh.n_points, 3))),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([-0.4, 0.2, 1]),),
        camera=Camera([0.2, -0.3, 1], UP, size, distance=250.0),
        **changes,
    )


SCENES = {
    "hand": lambda matt: hand(matt, (150, 170)),
    "folds": lambda matt: folds(matt, (140, 120)),
    "wide": lambda matt: hand(matt, (400, 60)),
    "few": lambda matt: folds(matt, (31, 27)),
    "tiny": lambda matt: folds(matt, (1, 1)),
}


@pytest.fixture(params=SCENES)
def scene(request, matt):
    return SCENES[request.param](matt)


@pytest.fixture
def pilot(scene):
    return pilot_of(stage_of(scene, Plan(spectrum="16")))


def full_trace(scene):
    """The whole picture, with all rays of every pixel."""
    return render(scene, Plan(spectrum="16"))


# What is drawn ------------------------------------------------------------------


def test_filled_pixels_are_filled_and_edges_are_edges(scene, pilot):
    covered = full_trace(scene).covered.ravel().astype(int)
    assert (covered[pilot.filled.pixels] == 16).all()
    edges = covered[pilot.edges.pixels]
    assert ((edges > 0) & (edges < 16)).all()


def test_pixels_are_drawn_once_and_in_order(pilot):
    for sample in (pilot.filled, pilot.edges):
        assert (np.diff(sample.pixels) > 0).all()
    assert not np.intersect1d(pilot.filled.pixels, pilot.edges.pixels).size


def test_no_more_are_drawn_than_are_wanted(pilot):
    assert pilot.filled.pixels.size <= 1.25 * FILLED + 1
    assert pilot.edges.pixels.size <= EDGES


def test_enough_are_drawn_for_a_bound_where_there_are_enough(scene, pilot):
    filled = int((full_trace(scene).covered == 16).sum())
    if filled >= 2 * FILLED:
        assert pilot.filled.pixels.size >= FEW
    elif not pilot.complete:
        assert pilot.filled.pixels.size >= 688  # the least that a bound needs


def test_a_complete_pilot_holds_all_filled_pixels(scene, pilot):
    filled = np.flatnonzero(full_trace(scene).covered == 16)
    assert pilot.complete >= (filled.size < FEW)
    if pilot.complete:
        assert_array_equal(pilot.filled.pixels, filled)


def test_enough_are_drawn_for_a_bound(pilot):
    n = int(pilot.weights.sum())
    assert np.isfinite(percentile_bound(np.zeros(n), pilot.population))


def test_the_population_is_how_many_are_filled(scene, pilot):
    covered = full_trace(scene).covered
    filled, seen = (covered == 16).sum(), (covered > 0).sum()
    assert 0.9 * filled <= pilot.population <= 1.1 * seen
    if pilot.complete:
        assert pilot.population == filled
        assert (pilot.weights == 1).all()


def test_dark_pixels_stand_for_as_many_as_there_are(matt):
    scene = hand(matt, (300, 300))
    scene = scene.replace(lights=(DirectionalLight([-1, 0.05, 0.1]),))
    pilot = pilot_of(stage_of(scene, Plan(spectrum="16")))
    dark = ~pilot.filled.colours(Painter(pilot.stage)).any(axis=(1, 2))
    picture = full_trace(scene)
    full = picture.covered == 16
    expected = 1 - picture.xyz[full].any(axis=1).mean()
    assert 0.3 < expected < 0.9
    assert dark.mean() < expected / 2  # few are traced, for there is nothing to see
    found = pilot.weights[dark].sum() / pilot.weights.sum()
    assert found == pytest.approx(expected, abs=0.05)


def test_all_edges_are_drawn_where_there_are_few(scene, pilot):
    covered = full_trace(scene).covered.ravel()
    edges = np.flatnonzero((covered > 0) & (covered < 16))
    marked = np.count_nonzero(stage_of(scene).sight.outlines)
    if marked <= EDGES or pilot.complete:
        assert_array_equal(pilot.edges.pixels, edges)
    else:
        assert np.isin(pilot.edges.pixels, edges).all()


@pytest.mark.parametrize("size", [(n, n) for n in range(28, 52, 6)])
def test_at_any_size_a_pilot_is_complete_or_has_a_bound(matt, size):
    # Between few pixels, all of which count, and many, of which some do.
    scene = folds(matt, size)
    pilot = pilot_of(stage_of(scene, Plan(spectrum="16")))
    covered = full_trace(scene).covered
    filled = np.flatnonzero(covered == 16)
    assert pilot.complete >= (filled.size < FEW)
    if pilot.complete:
        assert_array_equal(pilot.filled.pixels, filled)
    else:
        assert pilot.filled.pixels.size >= 688


def test_the_same_scene_has_the_same_pilot(scene, pilot):
    again = pilot_of(stage_of(scene, Plan(spectrum="16")))
    for one, other in ((pilot.filled, again.filled), (pilot.edges, again.edges)):
        assert_array_equal(one.pixels, other.pixels)
        assert_array_equal(one.hits.points, other.hits.points)
        assert_array_equal(one.hits.rays, other.hits.rays)
    assert (pilot.share, pilot.complete) == (again.share, again.complete)


def test_filled_pixels_are_drawn_evenly_over_what_is_seen(matt):
    # Against the shares of all filled pixels in a grid of 4 x 4 parts; all are lit.
    scene = hand(matt, (300, 300))
    scene = scene.replace(lights=(DirectionalLight(scene.camera.direction),))
    pilot = pilot_of(stage_of(scene, Plan(spectrum="16")))
    covered = full_trace(scene).covered

    def shares(pixels):
        row, column = np.divmod(pixels, 300)
        counts = np.bincount(row // 75 * 4 + column // 75, minlength=16)
        return counts / counts.sum()

    drawn, every = (
        shares(pilot.filled.pixels),
        shares(np.flatnonzero(covered.ravel() == 16)),
    )
    # Five standard deviations of as many independent draws.
    n = pilot.filled.pixels.size
    off = np.abs(drawn - every)
    assert (off <= 5 * np.sqrt(every * (1 - every) / n) + 1e-12).all()


def test_the_share_is_that_of_the_pixels_that_may_show_the_mesh(matt):
    scene = hand(matt, (300, 300))
    stage = stage_of(scene, Plan(spectrum="16"))
    pilot = pilot_of(stage)
    block, marked = stage.sight.blocks
    may = np.kron(marked, np.ones((block, block), bool))[:300, :300]
    first = render(scene, Plan(1, spectrum="16")).covered > 0
    assert pilot.share == pytest.approx(first[may].mean(), abs=0.03)


# What their light is ------------------------------------------------------------


def test_the_mean_over_their_rays_is_the_pictures_light(scene, pilot):
    reference = full_trace(scene).xyz.reshape(-1, 3)
    for sample in (pilot.filled, pilot.edges):
        light = sample.colours(Painter(pilot.stage))
        assert light.shape == (sample.pixels.size, 16, 3)
        expected = reference[sample.pixels]
        assert_allclose(light.mean(axis=1), expected, rtol=8 * FLOAT32, atol=1e-9)


def test_their_first_rays_are_those_of_a_picture_of_few(scene, pilot):
    light = pilot.filled.colours(Painter(pilot.stage))
    for samples in (1, 2, 4):
        few = render(scene, Plan(samples, spectrum="16")).xyz.reshape(-1, 3)
        expected = few[pilot.filled.pixels]
        assert_allclose(light[:, :samples].mean(axis=1), expected, rtol=8 * FLOAT32)
    one = point_colours(Painter(pilot.stage), pilot.one_each)
    assert_allclose(one, light[:, 0], rtol=8 * FLOAT32)


def test_contrasts_are_those_of_the_picture(matt):
    for scene in (hand(matt, (90, 100)), folds(matt, (60, 50))):
        stage = stage_of(scene, Plan(spectrum="16"))
        pilot, white = pilot_of(stage), contrast_white(stage)
        own = pilot.filled.colours(Painter(stage))
        outlined = stage.sight.outlines
        for samples in (1, 4):
            found = pilot.contrasts(Painter(stage), own, samples)
            image = render(scene, Plan(samples, spectrum="16")).xyz
            rays = np.where(outlined, 16, samples).astype(np.uint8)
            for limit in (1.0, 4.0):
                rough = np.zeros(outlined.shape, dtype=bool)
                contrasts.contrasts(
                    image, rays, samples, white, limit, 0, len(image), rough
                )
                expected = rough.ravel()[pilot.filled.pixels]
                looked_at = ~outlined.ravel()[pilot.filled.pixels]
                # The picture is kept in single precision: a few are at the limit.
                same = (found > limit) == expected
                assert same[looked_at].mean() > 0.995
                assert expected.any()


# Judgement ----------------------------------------------------------------------


def test_the_white_is_the_perfect_diffuser_under_light_1(scene, pilot):
    assert_array_equal(pilot.white, white_xyz(scene))


def test_what_does_not_differ_is_judged_0(pilot):
    light = pilot.filled.colours(Painter(pilot.stage)).mean(axis=1)
    assert pilot.judge(light, light) == 0
    edges = pilot.edges.colours(Painter(pilot.stage)).mean(axis=1)
    assert pilot.edge_difference(edges, edges) == 0


def test_one_pixel_counts_only_where_all_do(matt):
    for size, counts in (((31, 27), True), ((140, 120), False)):
        pilot = pilot_of(stage_of(folds(matt, size), Plan(spectrum="16")))
        light = pilot.filled.colours(Painter(pilot.stage)).mean(axis=1)
        changed = light.copy()
        brightest = light[:, 1].argmax()
        changed[brightest] *= 0.3
        assert (pilot.judge(changed, light) > 5) == counts


def test_what_is_dark_in_both_is_not_judged(matt):
    pilot = pilot_of(stage_of(folds(matt, (140, 120)), Plan(spectrum="16")))
    light = pilot.filled.colours(Painter(pilot.stage)).mean(axis=1)
    half = light.copy()
    half[:40] = 0
    assert pilot.judge(half, half) == 0
    # But light where the reference has none is, and the other way round.
    assert pilot.judge(light, half) > 10
    assert pilot.judge(half, light) > 10


def test_edges_differ_by_what_they_are_changed(matt):
    pilot = pilot_of(stage_of(hand(matt, (150, 170)), Plan(spectrum="16")))
    edges = pilot.edges.colours(Painter(pilot.stage)).mean(axis=1)
    assert 0 < pilot.edge_difference(1.02 * edges, edges) < 2
    assert 2 < pilot.edge_difference(0.5 * edges, edges) < 100


@pytest.mark.parametrize("size", [60, 150, 176, 190, 205, 300])
def test_of_few_lit_pixels_all_are_judged_or_nothing_is_told(matt, size):
    # A crescent of light, of whose rim the pilot holds a part.
    scene = hand(matt, (size, size))
    scene = scene.replace(lights=(DirectionalLight([-1, -0.8, 0.1]),))
    pilot = pilot_of(stage_of(scene, Plan(spectrum="16")))
    picture = full_trace(scene)
    lit = (picture.covered == 16) & (picture.xyz[..., 1] > 0)
    assert lit.sum() < FEW
    light = pilot.filled.colours(Painter(pilot.stage)).mean(axis=1)
    found = pilot.judge(0.9 * light, light)
    drawn = np.isin(np.flatnonzero(lit), pilot.filled.pixels)
    assert np.isinf(found) == (not drawn.all())


def test_one_edge_counts_only_where_few_pixels_are_filled(matt):
    for size, counts in (((150, 170), False), ((31, 27), True)):
        pilot = pilot_of(stage_of(hand(matt, size), Plan(spectrum="16")))
        edges = pilot.edges.colours(Painter(pilot.stage)).mean(axis=1)
        changed = edges.copy()
        changed[edges[:, 1].argmax()] *= 0.3
        assert (pilot.edge_difference(changed, edges) > 5) == counts


# Nothing to draw ----------------------------------------------------------------


@pytest.mark.parametrize("size", [(1, 1), (40, 30), (300, 200)])
def test_of_an_empty_picture_nothing_is_drawn(matt, size):
    scene = folds(matt, size)
    camera = Camera([0, 0, 1], UP, size, target=[900, 0, 0], height=10.0)
    pilot = pilot_of(stage_of(scene.replace(camera=camera), Plan(spectrum="16")))
    assert pilot.filled.pixels.size == pilot.edges.pixels.size == 0
    assert pilot.share == 0
    assert pilot.complete
    nothing = pilot.filled.colours(Painter(pilot.stage))
    assert nothing.shape == (0, 16, 3)
    assert pilot.judge(nothing.mean(axis=1), nothing.mean(axis=1)) == 0


def test_the_inside_of_a_mesh_is_dark(matt):
    scene = matt.replace(
        mesh=sphere(40, 2),
        camera=Camera([0, 0, 1], UP, (40, 40), distance=10.0, height=8.0),
    )
    pilot = pilot_of(stage_of(scene, Plan(spectrum="16")))
    light = pilot.filled.colours(Painter(pilot.stage)).mean(axis=1)
    assert light.size
    assert not light.any()
