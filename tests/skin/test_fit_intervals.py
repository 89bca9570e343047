"""The fit says how sure it is: pulls, coverage and what it cannot know."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import fit_skin, skin_model

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="back of hand", specular="included")

SIGMA = 2e-3
TRUTH = np.array([0.1, 0.01, 0.005])


@pytest.fixture(scope="module")
def noisy():
    """3000 measurements of one skin with known noise."""
    rng = np.random.default_rng(20050)
    return MODEL.measured(TRUTH, NM) + rng.normal(0, SIGMA, (3000, 31))


def covered(fit, truth):
    """Return for each parameter in which share of fits its interval holds it."""
    inside = (fit.interval[..., 0] <= truth) & (truth <= fit.interval[..., 1])
    return inside.mean(axis=0)


def test_pulls_are_normal_where_sigma_is_known(noisy):
    fit = fit_skin(noisy, NM, MODEL, uncertainty=np.full(31, SIGMA))
    assert (fit.status == "converged").all()
    deviation = np.sqrt(np.einsum("mpp->mp", fit.covariance))
    pulls = (fit.values - TRUTH) / deviation
    assert_allclose(pulls.std(axis=0), 1, rtol=0, atol=0.1)
    assert_allclose(pulls.mean(axis=0), 0, rtol=0, atol=0.1)
    assert_allclose(np.corrcoef(pulls.T), _correlation(fit), rtol=0, atol=0.1)
    assert_allclose(covered(fit, TRUTH), 0.95, rtol=0, atol=0.02)


def _correlation(fit):
    """Return the mean correlation that the fits themselves state."""
    spread = np.sqrt(np.einsum("mpp->mp", fit.covariance))
    return (fit.covariance / spread[:, :, None] / spread[:, None, :]).mean(axis=0)


def test_saturation_interval_holds_at_least_95_percent(noisy):
    fit = fit_skin(noisy, NM, MODEL, uncertainty=np.full(31, SIGMA))
    truth = TRUTH[1] / TRUTH[1:].sum()
    low, high = fit.oxygen_saturation_interval.T
    assert ((low <= truth) & (truth <= high)).mean() > 0.94


def test_intervals_hold_where_the_residuals_tell_sigma(noisy):
    assert_allclose(covered(fit_skin(noisy, NM, MODEL), TRUTH), 0.95, rtol=0, atol=0.02)


def test_few_bands_widen_the_interval_as_student_says(noisy):
    few = np.linspace(0, 30, 6).astype(int)
    fit = fit_skin(noisy[:, few], NM[few], MODEL)
    inside = fit.status == "converged"
    assert inside.mean() > 0.8
    assert_allclose(covered(fit, TRUTH), 0.95, rtol=0, atol=0.02)


def test_bands_count_by_their_uncertainty():
    rng = np.random.default_rng(3)
    sigma = np.where(NM < 500, 0.02, 1e-3)
    data = MODEL.measured(TRUTH, NM) + rng.normal(0, 1, (2000, 31)) * sigma
    weighted = fit_skin(data, NM, MODEL, uncertainty=sigma)
    assert_allclose(covered(weighted, TRUTH), 0.95, rtol=0, atol=0.02)
    plain = fit_skin(data, NM, MODEL)
    assert (weighted.values.std(axis=0) < plain.values.std(axis=0)).all()


def test_uncertainty_may_differ_between_spectra():
    data = MODEL.measured(TRUTH, NM) + np.random.default_rng(4).normal(0, 1e-3, (3, 31))
    sigma = np.array([1e-3, 2e-3, 4e-3])[:, None] * np.ones(31)
    together = fit_skin(data, NM, MODEL, uncertainty=sigma)
    for i in range(3):
        alone = fit_skin(data[i], NM, MODEL, uncertainty=sigma[i])
        assert_allclose(together.covariance[i], alone.covariance, rtol=1e-6)
    doubled = fit_skin(data, NM, MODEL, uncertainty=2 * sigma)
    assert_allclose(doubled.covariance, 4 * together.covariance, rtol=1e-5)


def test_intervals_at_the_bound_hold_95_percent_of_what_may_have_been():
    """Of skins drawn evenly whose fit stops at w_dh = 0, 95 % lie within.

    For flat priors that is what a one-sided credible interval promises. The noise
    is small, so that the model is straight over the interval.
    """
    rng = np.random.default_rng(6)
    n, sigma = 11_000, 5e-4
    truth = np.stack(
        [rng.uniform(0.05, 0.3, n), rng.uniform(0.004, 0.02, n), np.zeros(n)], axis=1
    )
    truth[:, 2] = rng.uniform(0, 1e-3, n)
    data = MODEL.measured(truth, NM) + rng.normal(0, sigma, (n, 31))
    fit = fit_skin(data, NM, MODEL, uncertainty=np.full(31, sigma))
    held = fit.values[:, 2] == 0
    assert held.sum() > 400
    inside = truth[held, 2] <= fit.interval[held, 2, 1]
    assert_allclose(inside.mean(), 0.95, rtol=0, atol=0.03)


@pytest.mark.parametrize("sigma", [1e-6, 1e-4, 2e-4, 1e-2, 1.0, 1e3])
def test_any_scale_of_uncertainty_is_fitted(sigma, noisy):
    fit = fit_skin(noisy[:200], NM, MODEL, uncertainty=np.full(31, sigma))
    expected = fit_skin(noisy[:200], NM, MODEL)
    assert_allclose(fit.values, expected.values, rtol=1e-5)


def test_what_cannot_be_known_has_the_widest_interval():
    # Without an epidermis there is no melanin to tell.
    model = skin_model(thickness=(0.0, 1.2), specular="included")
    data = model.measured([0.1, 0.01, 0.005], NM)
    fit = fit_skin(data, NM, model, uncertainty=np.full(31, SIGMA))
    assert_array_equal(fit.interval[0], [0, model.parameters[0].upper])
    assert_allclose(fit.values[1:], [0.01, 0.005], rtol=1e-5)
