"""An error that all bands share, in the covariance and the intervals of a fit."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz.errors import ArgumentError
from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model
from skinviz.skin.scale_error import fit_uncertain_scale

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="cheek", specular="excluded")
WEIGHTS = np.array([0.12, 0.006, 0.004])


def test_a_scale_that_is_sure_changes_nothing():
    data = MODEL.measured(WEIGHTS, NM) + 1e-3 * np.sin(NM)
    plain = fit_skin(data, NM, MODEL, uncertainty=np.full(NM.size, 1e-3))
    same = fit_uncertain_scale(
        data, NM, MODEL, scale=0.0, uncertainty=np.full(NM.size, 1e-3)
    )
    assert_array_equal(same.values, plain.values)
    assert_allclose(same.covariance, plain.covariance, rtol=1e-12)
    assert_allclose(same.interval, plain.interval, rtol=1e-12)


def test_intervals_hold_the_truth_when_the_scale_is_off():
    rng = np.random.default_rng(5)
    n, noise, scale = 2000, 2e-3, 5e-3
    off = 1 + scale * rng.normal(size=(n, 1))
    data = MODEL.measured(WEIGHTS, NM) * off + rng.normal(0, noise, (n, NM.size))
    sigma = np.full(NM.size, noise)

    def covered(fit):
        held = (fit.interval[..., 0] <= WEIGHTS) & (fit.interval[..., 1] >= WEIGHTS)
        return held.mean(axis=0)

    assert covered(fit_skin(data, NM, MODEL, uncertainty=sigma))[0] < 0.7
    fit = fit_uncertain_scale(data, NM, MODEL, scale=scale, uncertainty=sigma)
    assert_allclose(covered(fit), 0.95, atol=0.02)
    pulls = (fit.values - WEIGHTS) / np.sqrt(np.einsum("mpp->mp", fit.covariance))
    assert_allclose(pulls.std(axis=0), 1, atol=0.05)
    tail = np.quantile(pulls[:, 0], [0.025, 0.975])
    assert_allclose(tail, [-1.96, 1.96], atol=0.2)


def test_intervals_stay_within_the_bounds():
    data = MODEL.measured([0.12, 0.006, 0.0], NM)
    fit = fit_uncertain_scale(
        data, NM, MODEL, scale=0.1, uncertainty=np.full(NM.size, 1e-3)
    )
    assert (fit.interval >= 0).all()
    assert (fit.interval[:, 0] <= fit.values).all()


def test_scales_out_of_range_are_refused():
    with pytest.raises(ArgumentError, match="scale"):
        fit_uncertain_scale(MODEL.measured(WEIGHTS, NM), NM, MODEL, scale=0.5)
