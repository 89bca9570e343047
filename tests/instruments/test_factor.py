"""Radiance factors: exact without noise, and honest about it with."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skinviz.errors import ArgumentError
from skinviz.instruments.errors import DriftExceeded
from skinviz.instruments.factor import (
    Frame,
    between,
    drift,
    frame_of,
    is_steady,
    radiance_factor,
)

N = 101
LIGHT = np.linspace(0.5, 2, N)
RHO, U_RHO = np.full(N, 0.98), np.full(N, 0.002)


def _exact(values, time=0.0):
    return Frame(np.asarray(values), np.zeros(N), np.full(N, np.inf), 0.0, time)


def test_a_known_factor_is_found_under_drift_and_stray_light():
    truth = np.linspace(0.1, 0.6, N)
    lamp = [1.0, 1.005, 1.01]
    before, after = (
        _exact(LIGHT * RHO * k + 0.02, t) for k, t in ((1.0, 0), (1.01, 20))
    )
    sample = _exact(LIGHT * truth * lamp[1] + 0.01, 10.0)
    found = radiance_factor(
        sample,
        between(before, after, 10.0),
        RHO,
        U_RHO,
        ambient_sample=_exact(np.full(N, 0.01)),
        ambient_white=_exact(np.full(N, 0.02)),
    )
    assert_allclose(found.value, truth, rtol=1e-13)
    bent = 0.01 / 8 / np.sqrt(3)
    assert_allclose(found.u, truth * np.hypot(U_RHO / RHO, bent), rtol=0.01)


def _trials(repeats, trials, *, ambient=True):
    """Return errors over u of many simulated measurements with 0.4 % noise."""
    rng = np.random.default_rng(repeats)
    off = []
    for _ in range(trials):

        def frame(level, time):
            data = level * (1 + rng.normal(0, 0.004, (repeats, N)))
            return frame_of(data, np.full(repeats, time))

        dark = frame(0.02 * LIGHT, 0) if ambient else None
        white = between(
            frame(LIGHT * 0.98 + 0.02 * LIGHT * ambient, 0),
            frame(LIGHT * 0.98392 + 0.02 * LIGHT * ambient, 20),
            10,
        )
        sample = frame(LIGHT * 0.35 * 1.002 + 0.02 * LIGHT * ambient, 10)
        found = radiance_factor(
            sample, white, RHO, np.zeros(N), ambient_sample=dark, ambient_white=dark
        )
        off.append((found.value - 0.35) / found.u)
    return np.array(off)


@pytest.mark.parametrize("repeats", [3, 5, 10])
def test_errors_are_as_large_as_their_uncertainty_says(repeats):
    off = _trials(repeats, 120)
    assert abs(off.mean()) < 0.03
    assert off.std() == pytest.approx(1, abs=0.06)
    assert (np.abs(off) < 2).mean() > 0.93
    assert (np.abs(off) < 3).mean() > 0.99


def test_without_pooling_five_readings_would_pretend_too_much():
    rng = np.random.default_rng(2)
    data = 1 + rng.normal(0, 0.01, (5, 4000))
    plain = data.std(axis=0, ddof=1) / np.sqrt(5)
    pooled = frame_of(data, np.zeros(5)).u
    off = data.mean(axis=0) - 1
    assert (np.abs(off) < 3 * plain).mean() < 0.97
    assert (np.abs(off) < 3 * pooled).mean() > 0.99


def test_the_mean_knows_its_scatter_and_freedom():
    found = frame_of(np.array([[1.0, 2.0], [1.1, 2.2]]), [3.0, 5.0])
    assert_allclose(found.mean, [1.05, 2.1])
    assert found.time == 4
    assert found.scatter == pytest.approx(np.std([3, 3.3], ddof=1) / 3.15)
    assert_allclose(found.dof, [2, 2])


def test_bands_that_say_nothing_are_nan():
    dim = LIGHT.copy()
    dim[:5] = 0.0201
    dark = Frame(np.full(N, 0.02), np.full(N, 1e-3), np.full(N, 4.0), 0.0, 0.0)
    certified = RHO.copy()
    certified[-3:] = np.nan
    found = radiance_factor(
        _exact(dim),
        _exact(dim),
        certified,
        U_RHO,
        ambient_sample=dark,
        ambient_white=dark,
    )
    assert np.isnan(found.value[:5]).all()
    assert np.isnan(found.value[-3:]).all()
    assert np.isfinite(found.value[5:-3]).all()
    assert np.isfinite(found.u[5:-3]).all()


def test_a_line_between_whites_is_as_uncertain_as_it_may_bend():
    before, after = _exact(LIGHT, 0.0), _exact(1.02 * LIGHT, 10.0)
    for time, share in ((0.0, 0), (5.0, 0.02 / 8 / np.sqrt(3)), (10.0, 0)):
        found = between(before, after, time)
        assert_allclose(found.u / found.mean, share, atol=1e-15)


def test_drift_is_told_and_too_much_refused():
    assert drift(_exact(LIGHT), _exact(1.01 * LIGHT)) == pytest.approx(0.01)
    with pytest.raises(DriftExceeded, match=r"\+3.0%"):
        drift(_exact(LIGHT), _exact(1.03 * LIGHT))
    with pytest.raises(DriftExceeded):
        drift(_exact(LIGHT), _exact(np.full(N, np.nan)))


def test_a_lamp_is_steady_after_three_readings_alike():
    assert not is_steady([1, 1])
    assert not is_steady([1, 1.003, 1.0031])
    assert is_steady([0.9, 1, 1.001, 1.0015])
    assert not is_steady([0, 0, 0])


@pytest.mark.parametrize("values", [[[1.0, 2.0]], [1.0, 2.0], [[1, np.nan], [1, 2]]])
def test_means_of_too_little_are_refused(values):
    with pytest.raises(ArgumentError):
        frame_of(values, np.zeros(len(values)))
