"""Intervals: exact for linear models, at a bound by the mass beyond it."""

import numpy as np
import pytest
from mpmath import mp, mpf
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import norm, t
from tolerances import QUADRATURE, ROUNDING

from skinviz.skin.problem import room
from skinviz.skin.uncertainty import _one_sided_reach, covariance_and_interval

BOUNDS = np.array([[0.0, 0.0, 0.0], [1e3, 1e3, 1e3]])


def mass_below(d, slope, sigma):
    """Return ∫₀ᵈ / ∫₀^∞ of exp(−(s + slope σ²)²/(2σ²)), by quadrature."""
    with mp.workdps(40):
        slope, sigma, d = mpf(float(slope)), mpf(float(sigma)), mpf(float(d))
        # The density relative to its value at 0, whose logarithm is so.
        scale = min(sigma, 1 / slope) if slope else sigma

        def density(s):
            return mp.exp(-slope * s - s * s / (2 * sigma * sigma))

        ends = [scale * k for k in (0, 1, 2, 4, 8, 16, 40, 100)]
        return mp.quad(density, mp.linspace(0, d, 6)) / mp.quad(density, ends)


@pytest.mark.parametrize("sigma", [1e-6, 1.0, 1e4])
@pytest.mark.parametrize("offset", [0.0, 1e-6, 0.3, 3.0, 12.0, 29.0, 37.0, 1e3, 1e8])
def test_one_sided_reach_holds_95_percent(offset, sigma):
    slope = np.array([offset / sigma])
    reach = _one_sided_reach(slope, np.array([sigma]))
    # Beyond 30 σ the reach is that of an exponential, to 1 in offset².
    tolerance = 1e-9 if offset < 30 else 4 / offset**2
    assert_allclose(
        float(mass_below(reach[0], slope[0], sigma)), 0.95, rtol=0, atol=tolerance
    )


NO_PRIOR = np.zeros(3)


def linear_fit(seed=0, held=(False, False, False), n=14, shown=(1, 1, 1)):
    """Return a linear problem's matrix, target and weights, and its Solutions."""
    rng = np.random.default_rng(seed)
    A = (rng.normal(size=(n, 3)) + 1) * shown
    sigma = rng.uniform(0.05, 0.2, n)
    target = A @ np.array([2.0, 3.0, -0.1 if held[2] else 1.0]) + rng.normal(0, sigma)
    free = ~np.array(held)
    values = np.zeros(3)
    root = 1 / sigma
    values[free] = np.linalg.lstsq(A[:, free] * root[:, None], target * root)[0]
    weights = 1 / sigma**2
    return A, target, weights, solutions(A, target, weights, values, held)


def solutions(A, target, weights, values, held):
    """Return what the solver hands over of one linear fit."""
    found, unit = room(1, 3), 1 / weights.max()
    relative, off = weights * unit, A @ values - target
    found.values[0], found.held[0] = values, held
    found.information[0] = A.T @ (relative[:, None] * A)
    found.pull[0] = A.T @ (relative * off)
    found.cost[0], found.unit[0], found.n_used[0] = relative @ off**2, unit, len(target)
    return found


def test_absolute_covariance_is_the_inverse_of_the_information():
    A, _, weights, found = linear_fit()
    covariance, interval = covariance_and_interval(
        found, NO_PRIOR, BOUNDS, absolute=True
    )
    expected = np.linalg.inv(A.T @ (weights[:, None] * A))
    assert_allclose(covariance[0], expected, rtol=1e-10)
    half = norm.ppf(0.975) * np.sqrt(np.diag(expected))
    assert_allclose(interval[0, :, 0], np.maximum(found.values[0] - half, 0))
    assert_allclose(interval[0, :, 1], found.values[0] + half)


def test_relative_covariance_is_scaled_by_the_residuals():
    A, target, weights, found = linear_fit()
    absolute, _ = covariance_and_interval(found, NO_PRIOR, BOUNDS, absolute=True)
    covariance, interval = covariance_and_interval(
        found, NO_PRIOR, BOUNDS, absolute=False
    )
    chi2 = float((weights * (A @ found.values[0] - target) ** 2).sum()) / (14 - 3)
    assert_allclose(covariance, absolute * chi2, rtol=ROUNDING)
    half = t.ppf(0.975, 11) * np.sqrt(np.diag(covariance[0]))
    assert_allclose(interval[0, :, 1] - found.values[0], half, rtol=1e-10)


@pytest.mark.parametrize("absolute", [True, False])
def test_a_prior_is_one_more_measurement(absolute):
    A, target, weights, found = linear_fit()
    stiffness = np.array([0.0, 50.0, 3.0])
    covariance, _ = covariance_and_interval(found, stiffness, BOUNDS, absolute=absolute)
    residual = A @ found.values[0] - target
    scale = 1.0 if absolute else float(weights @ residual**2) / 11
    information = A.T @ (weights[:, None] * A) / scale + np.diag(stiffness)
    assert_allclose(covariance[0], np.linalg.inv(information), rtol=1e-10)


def test_a_held_parameter_is_not_counted_nor_correlated():
    A, _, weights, found = linear_fit(held=(False, False, True))
    covariance, _ = covariance_and_interval(found, NO_PRIOR, BOUNDS, absolute=True)
    expected = np.linalg.inv(A[:, :2].T @ (weights[:, None] * A[:, :2]))
    assert_allclose(covariance[0][:2, :2], expected, rtol=1e-10)
    assert_array_equal(covariance[0][2], 0)
    assert_array_equal(covariance[0][:, 2], 0)


@pytest.mark.parametrize("seed", range(4))
def test_interval_at_a_bound_allows_for_the_other_parameters(seed):
    """The reach is the 95 % quantile with the free parameters left to adapt.

    Under flat priors the posterior of a linear model is a normal density; its
    margin in the held parameter, cut at the bound, is known in closed form.
    """
    A, target, weights, found = linear_fit(seed, held=(False, False, True))
    _, interval = covariance_and_interval(found, NO_PRIOR, BOUNDS, absolute=True)
    w = weights[:, None]
    unbounded = np.linalg.solve(A.T @ (w * A), A.T @ (weights * target))
    sigma = np.sqrt(np.linalg.inv(A.T @ (w * A))[2, 2])
    mean = unbounded[2]
    beyond = norm.sf(0, mean, sigma)
    expected = norm.isf(0.05 * beyond, mean, sigma)
    assert mean < 0
    assert interval[0, 2, 0] == 0
    assert_allclose(interval[0, 2, 1], expected, rtol=QUADRATURE)


@pytest.mark.parametrize("held", [(False, False, False), (False, True, False)])
def test_what_the_data_do_not_determine_may_be_anything(held):
    *_, found = linear_fit(held=held, shown=(1, 0, 1))
    covariance, interval = covariance_and_interval(
        found, NO_PRIOR, BOUNDS, absolute=True
    )
    assert interval[0, 1, 1] == BOUNDS[1, 1]
    assert np.isinf(covariance[0, 1, 1]) == (not held[1])
    assert (interval[0, 0, 1] - interval[0, 0, 0]) < 1


def test_two_parameters_that_do_the_same_are_both_undetermined():
    A, target, weights, _ = linear_fit()
    A[:, 1] = 3 * A[:, 0]
    found = solutions(A, target, weights, np.array([1.0, 1.0, 1.0]), [False] * 3)
    covariance, _ = covariance_and_interval(found, NO_PRIOR, BOUNDS, absolute=True)
    assert_array_equal(np.isinf(np.diag(covariance[0])), [True, True, False])


def test_intervals_stay_within_the_bounds():
    *_, found = linear_fit()
    narrow = np.array([[1.9, 2.9, 0.9], [2.05, 3.05, 1.05]])
    _, interval = covariance_and_interval(found, NO_PRIOR, narrow, absolute=True)
    assert (interval[0, :, 0] >= narrow[0]).all()
    assert (interval[0, :, 1] <= narrow[1]).all()
