"""A finished picture that is too coarse is drawn finer, until it is fine enough."""

import numpy as np
import pytest
from planned_scenes import BACK, FINGERS, folds, hand, mapped
from scipy.optimize import brentq
from scipy.stats import binom

from skinviz import Camera, DirectionalLight, Plan, render
from skinviz.rendering import check
from skinviz.rendering.check import checked
from skinviz.rendering.imager import image_of
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.stage import stage_of
from skinviz.rendering.tolerance import colour_differences, compare

SMALL = Camera(BACK, FINGERS, (120, 120))

COARSE = {
    "few samples": {"samples": 1},
    "few samples, refined": {"samples": 1, "refine": 1e3},
    "no shadows": {"shadows": False},
    "no gloss": {"specular": "none"},
    "at vertices": {"shading": "vertices"},
    "all": {
        "samples": 1,
        "shadows": False,
        "specular": "none",
        "shading": "vertices",
    },
}


def drawn(scene, **plan):
    """A stage by a plan made by hand, and its picture."""
    stage = stage_of(scene, Plan(**plan))
    return stage, image_of(stage)


def difference(scene, image):
    """How a picture differs from the reference."""
    reference = render(scene, Plan())
    xyz = image.xyz.reshape(reference.xyz.shape)
    return compare(xyz, reference.xyz, reference.covered, white_xyz(scene))


def share_over(scene, image, tolerance):
    """The share of filled and lit pixels that differ by more than a tolerance."""
    reference = render(scene, Plan())
    lit = (reference.covered == 16) & (reference.xyz[..., 1] > 0)
    ours = image.xyz.reshape(reference.xyz.shape)[lit].astype(float)
    true = reference.xyz[lit].astype(float)
    off = colour_differences(ours, true, white_xyz(scene))
    return (off > tolerance).mean()


def binom_share(n, k):
    """The share of which n draws hold at most k in one case of a thousand."""
    return brentq(lambda share: binom.cdf(k, n, share) - 1e-3, 1e-6, 0.5)


def checks(stage):
    return [f for f in stage.plan.findings if f.knob == "check"]


@pytest.mark.parametrize("name", COARSE)
@pytest.mark.parametrize("tolerance", [0.05, 1.0])
def test_a_picture_too_coarse_is_drawn_until_it_keeps_its_tolerance(
    model, name, tolerance
):
    scene = folds(model, camera=Camera([0.2, -0.3, 1], [0, 1, 0], (90, 90)))
    before = drawn(scene, **COARSE[name], tolerance=tolerance)
    assert not difference(scene, before[1]).kept(tolerance)
    stage, image = checked(*before)
    # As well as 1,000 pixels tell: of those, no more than 10 differ by more.
    assert share_over(scene, image, tolerance) < binom_share(1000, 10)
    # What it now is, its plan says.
    assert stage.plan != before[0].plan
    assert stage.plan.tolerance == tolerance
    again = image_of(stage_of(scene, stage.plan))
    np.testing.assert_array_equal(image.xyz, again.xyz)
    exact = stage.plan.samples == 16
    assert len(checks(stage)) == (not exact)
    assert all(own.delta_e <= tolerance for own in checks(stage))


@pytest.mark.parametrize("name", ["few samples, refined", "at vertices"])
def test_a_picture_that_keeps_its_tolerance_is_left_as_it_is(model, name):
    scene = hand(model, camera=SMALL, lights=(DirectionalLight(BACK),))
    before = drawn(scene, **COARSE[name], tolerance=6.0)
    stage, image = checked(*before)
    assert image is before[1]
    (own,) = checks(stage)
    assert own.delta_e <= 6
    assert stage.plan.replace(findings=()) == before[0].plan


def test_the_check_tells_of_how_many_pixels(model):
    scene = hand(model, camera=SMALL)
    stage, _ = checked(*drawn(scene, samples=4, refine=2.0, tolerance=5.0))
    (own,) = checks(stage)
    n = int(own.chosen.split()[0])
    lit = difference(scene, image_of(stage_of(scene, Plan()))).n_filled
    assert 500 < n <= min(1000, lit)


def test_what_was_found_before_is_kept(model):
    scene = hand(model, camera=SMALL)
    told = check.Finding("specular", "none", "the surface's reflection", 0.1)
    before = drawn(scene, samples=4, refine=1.0, tolerance=5.0, findings=(told,))
    stage, _ = checked(*before)
    assert stage.plan.findings[0] == told
    assert len(checks(stage)) == 1


@pytest.mark.parametrize("knob", ["spectrum", "reflectance", "arithmetic", "bounce"])
def test_what_was_priced_by_itself_is_taken_off_the_tolerance(model, knob):
    scene = hand(model, camera=SMALL)
    plan = {"samples": 1, "refine": 8.0, "tolerance": 2.0}
    (plain,) = checks(checked(*drawn(scene, **plan))[0])
    assert 0 < plain.delta_e < 2
    # All but a little less than is needed.
    told = check.Finding(knob, "some", "more", 2.0 - 0.9 * plain.delta_e)
    before = drawn(scene, **plan, findings=(told,))
    stage, _ = checked(*before)
    assert stage.plan.samples > 1
    assert all(own.delta_e < plain.delta_e for own in checks(stage))
    other = check.Finding("sampling", "some", "more", 2.0 - 0.9 * plain.delta_e)
    stage, _ = checked(*drawn(scene, **plan, findings=(other,)))
    assert stage.plan.samples == 1


def test_the_reference_has_nothing_to_be_checked(model):
    before = drawn(hand(model, camera=SMALL), tolerance=0.01)
    stage, image = checked(*before)
    assert image is before[1]
    assert stage is before[0]
    assert not checks(stage)


def test_checks_of_the_same_picture_are_the_same(model):
    before = drawn(hand(model, camera=SMALL), samples=1, refine=8.0, tolerance=1.0)
    one, other = checked(*before), checked(*before)
    assert one[0].plan == other[0].plan
    np.testing.assert_array_equal(one[1].xyz, other[1].xyz)


@pytest.mark.parametrize("size", [(1, 1), (9, 8)])
def test_an_empty_picture_is_as_it_should_be(model, size):
    camera = Camera(BACK, FINGERS, size, target=[5000, 0, 0], height=10.0)
    before = drawn(hand(model, camera=camera), samples=1, refine=8.0, tolerance=0.1)
    stage, image = checked(*before)
    assert image is before[1]
    (own,) = checks(stage)
    assert own.delta_e == 0
    assert own.chosen.startswith("0 pixels")


def test_a_dark_picture_is_as_it_should_be(model):
    lights = (DirectionalLight(-np.array(BACK)),)
    scene = hand(model, camera=SMALL, lights=lights)
    stage, image = checked(*drawn(scene, samples=1, refine=8.0, tolerance=0.1))
    with pytest.warns(UserWarning, match="behind everything"):
        reference = render(scene, Plan(1))
    dark = ~reference.xyz.reshape(-1, 3).any(axis=1)
    assert not image.xyz[dark & (image.rays == 1)].any()
    assert stage.plan.tolerance == 0.1


def test_maps_are_checked_with_the_reflectance_that_they_have(model):
    scene = mapped(model, camera=Camera(BACK, FINGERS, (64, 64)))
    plan = {"spectrum": "8 nodes", "reflectance": "vertices", "tolerance": 1.0}
    stage, image = checked(*drawn(scene, samples=1, refine=32.0, **plan))
    assert stage.plan.spectrum == "8 nodes"
    assert stage.plan.reflectance == "vertices"
    exact = image_of(stage_of(scene, Plan(16, **plan)))
    full = (exact.covered == 16) & exact.xyz.any(axis=1)
    found = compare(image.xyz, exact.xyz, np.where(full, 16, 0), white_xyz(scene))
    assert found.filled <= 1.2
