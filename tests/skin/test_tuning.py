"""Refitting the table: known numbers come back, and priors and refusals count."""

from dataclasses import astuple

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_less

from skinviz import ArgumentError
from skinviz.skin.coefficients import layer_thickness
from skinviz.skin.formulas import EffectiveNumbers, effective_coefficients
from skinviz.skin.priors import NAMES, coordinate_bounds, literature
from skinviz.skin.tuning import implied_scale, misfits, tune
from skinviz.skin.two_layer import TwoLayer

TRUTH = EffectiveNumbers(2.6, 4.0, 3.6, 0.4, 0.9)
NOISE = 1e-4
BANDS = np.arange(400.0, 701.0, 20.0)
DEPTH = layer_thickness("inner arm")


@pytest.fixture(scope="module")
def people():
    """Noisy spectra of six people whose skin has the true numbers."""
    rng = np.random.default_rng(5)
    weights = rng.uniform((0.05, 4e-3, 2e-3), (0.5, 2e-2, 1e-2), (6, 3))
    model = TwoLayer(DEPTH, effective_coefficients(TRUTH, "true"), "included")
    return model.measured(weights, BANDS) + rng.normal(0, NOISE, (6, BANDS.size))


@pytest.fixture(scope="module")
def alone(people):
    """Their numbers, by spectra alone."""
    return tune(
        *(people, BANDS, DEPTH),
        specular="included",
        residual_scale=NOISE,
        prior_scale=np.inf,
    )


def test_known_numbers_come_back_within_their_errors(alone):
    assert alone.converged
    assert not alone.at_bound.any()
    errors = alone.standard_errors()
    z = (np.array(astuple(alone.numbers)) - astuple(TRUTH)) / errors
    assert_array_less(np.abs(z), 3.5)  # P < 0.003 for any of five
    # The errors are worth the name: each number is known to a fifth or better.
    assert_array_less(errors, 0.2 * np.array(astuple(TRUTH)))


def test_noise_is_all_that_remains(alone):
    freedom = 6 * (BANDS.size - 3) - len(NAMES)
    assert_allclose(alone.sse.sum() / NOISE**2, freedom, atol=5 * np.sqrt(2 * freedom))


def test_both_kinds_of_error_agree_where_residuals_are_independent_noise(alone):
    ratio = alone.standard_errors(between_people=True) / alone.standard_errors()
    assert_array_less(ratio, 3)  # six people: a rough estimate
    assert_array_less(1 / ratio, 3)


def test_priors_draw_the_numbers_to_their_means(people, alone):
    held = tune(people, BANDS, DEPTH, specular="included", residual_scale=1e4 * NOISE)
    assert_array_less(np.abs(held.pull), 0.05)
    assert np.abs(alone.pull).max() > 0.5
    assert_allclose(held.learned, 0, atol=0.2)
    assert held.sse.sum() > 10 * alone.sse.sum()


def test_the_true_table_leaves_only_noise_and_another_does_not(people):
    given = {"thickness": DEPTH, "specular": "included"}
    true = misfits(people, BANDS, coefficients=effective_coefficients(TRUTH), **given)
    other = EffectiveNumbers(2.6, 4.0, 3.6, 0.4, 2.0)
    wrong = misfits(people, BANDS, coefficients=effective_coefficients(other), **given)
    assert np.sqrt((true**2).mean()) < 1.2 * NOISE
    assert np.sqrt((wrong**2).mean()) > 5 * NOISE


def test_a_missing_band_has_no_misfit(people):
    gappy = people.copy()
    gappy[0, 3] = np.nan
    apart = misfits(
        *(gappy, BANDS, DEPTH),
        coefficients=effective_coefficients(TRUTH),
        specular="included",
    )
    assert apart[0, 3] == 0
    assert np.isfinite(apart).all()


def test_independent_misfits_ask_for_their_own_size_as_scale():
    apart = np.random.default_rng(1).normal(0, 0.01, (8000, 200))
    assert_allclose(implied_scale(apart), 0.01, rtol=0.15)


def test_one_misfit_shared_by_all_counts_once():
    shape = np.sin(np.linspace(0, 6, 20))
    apart = np.tile(shape, (50, 1))
    # One independent band of 20 and one independent person of 50.
    expected = np.sqrt((shape**2).mean() * 20 * 50)
    assert_allclose(implied_scale(apart), expected, rtol=1e-9)


def test_no_misfit_asks_for_no_scale():
    assert implied_scale(np.zeros((5, 4))) == 0


def test_coordinates_of_the_numbers_turn_back_into_them():
    priors = literature()
    back = priors.numbers(priors.coordinates(TRUTH))
    assert_allclose(astuple(back), astuple(TRUTH), rtol=1e-14)


def test_the_search_covers_three_deviations_of_every_positive_prior():
    priors = literature()
    low, high = coordinate_bounds(priors)
    assert (priors.mean + 3 * priors.deviation < high).all()
    assert (priors.mean - 3 * priors.deviation > low)[priors.log].all()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"residual_scale": 0.0}, "residual_scale must be greater than 0; got 0"),
        ({"prior_scale": -1.0}, "prior_scale must be greater than 0; got -1"),
        ({"prior_scale": float("nan")}, "prior_scale must be greater than 0; got nan"),
    ],
)
def test_scales_that_mean_nothing_are_refused(people, change, says):
    with pytest.raises(ArgumentError, match=says):
        tune(people, BANDS, DEPTH, specular="included", **change)


def test_too_few_people_are_refused(people):
    with pytest.raises(ArgumentError, match="at least 5 spectra; got 4"):
        tune(people[:4], BANDS, DEPTH, specular="included")


def test_a_spectrum_that_cannot_be_fitted_is_named(people):
    bad = people.copy()
    bad[4] = -0.1
    with pytest.raises(ArgumentError, match=r"1 of 6 spectra .* index 4; leave them"):
        tune(bad, BANDS, DEPTH, specular="included")
