"""Exponential and angle without calls: against mpmath, over all that floats hold."""

import numba
import numpy as np
import pytest
from mpmath import mp, mpf
from numpy.testing import assert_allclose, assert_array_equal
from oracles.agreement import assert_oracle
from tolerances import EPS

from skinviz._vector_math import angle, decay, logarithm, loss_log

rng = np.random.default_rng(5)


@numba.njit(error_model="numpy")
def _angles(sine, cosine, out):
    for i in range(out.size):
        out[i] = angle(sine[i], cosine[i])


@numba.njit(error_model="numpy")
def _decays(y, out):
    for i in range(y.size):
        out[0, i], out[1, i] = decay(y[i])


@numba.njit(error_model="numpy")
def _losses(loss, out):
    for i in range(out.size):
        out[i] = loss_log(loss[i])


@numba.njit(error_model="numpy")
def _logarithms(x, out):
    for i in range(out.size):
        out[i] = logarithm(x[i])


def angles(sine, cosine):
    sine, cosine = np.array(sine, dtype=float), np.array(cosine, dtype=float)
    out = np.zeros(sine.size)
    _angles(sine, cosine, out)
    return out


def decays(y):
    y = np.array(y, dtype=float)
    out = np.zeros((2, y.size))
    _decays(y, out)
    return out


def test_angle_equals_the_oracle():
    drawn = np.concatenate(
        [
            rng.uniform(0, np.pi, 3000),
            10.0 ** rng.uniform(-300, 0, 1000),
            np.pi - 10.0 ** rng.uniform(-16, 0, 1000),
            np.arange(17) * np.pi / 16,
        ]
    )
    sine, cosine = np.abs(np.sin(drawn)), np.cos(drawn)
    with mp.workdps(40):
        expected = [
            float(mp.atan2(mpf(float(s)), mpf(float(c))))
            for s, c in zip(sine, cosine, strict=True)
        ]
    assert_allclose(angles(sine, cosine), expected, rtol=2 * EPS, atol=0)


def test_angle_takes_any_length_of_the_vector():
    drawn, length = rng.uniform(0, np.pi, 1000), 10.0 ** rng.uniform(-100, 100, 1000)
    sine, cosine = length * np.sin(drawn), length * np.cos(drawn)
    assert_allclose(angles(sine, cosine), np.arctan2(sine, cosine), rtol=2 * EPS)


def test_angle_is_whole_at_the_axes():
    found = angles([0.0, 1.0, 0.0, 1.0], [1.0, 0.0, -1.0, -0.0])
    assert_array_equal(found, [0, np.pi / 2, np.pi, np.pi / 2])


@pytest.mark.parametrize("cosine", [0.0, -0.0])
def test_no_direction_has_no_angle(cosine):
    assert angles([0.0], [cosine]) == 0


def test_decay_equals_the_oracle():
    y = np.concatenate([rng.uniform(0, 708, 2000), 10.0 ** rng.uniform(-300, 3, 2000)])
    with mp.workdps(60):
        powers = [mp.exp(-mpf(float(v))) for v in y]
        gaps = [float(-mp.expm1(-mpf(float(v)))) for v in y]
    found = decays(y)
    assert_oracle(found[0], [float(p) for p in powers], rtol=3 * EPS)
    assert_oracle(found[1], gaps, rtol=3 * EPS)


@pytest.mark.parametrize("y", [709.0, 1e300, np.inf])
def test_decay_beyond_the_smallest_float_is_0(y):
    assert_array_equal(decays([y]), [[0], [1]])


def losses(loss):
    loss = np.array(loss, dtype=float)
    out = np.zeros(loss.size)
    _losses(loss, out)
    return out


def test_loss_log_equals_the_oracle():
    loss = np.concatenate(
        [
            rng.uniform(0, 1, 3000),
            10.0 ** rng.uniform(-300, 0, 2000),
            1 - 2.0 ** -rng.uniform(0, 53, 1000),
            [0.5, 1 - np.sqrt(0.5), 0.25, 1 - 2.0**-53],
        ]
    )
    with mp.workdps(40):
        expected = [float(-mp.log1p(-mpf(float(x)))) for x in loss]
    assert_oracle(losses(loss), expected, rtol=3 * EPS)


def test_no_loss_is_0_and_all_is_much():
    assert_array_equal(losses([0.0]), [0])
    assert (losses([1.0, 2.0, np.inf]) > 36).all()


def test_logarithm_equals_the_oracle():
    x = np.concatenate(
        [
            10.0 ** rng.uniform(-307, 308, 3000),
            rng.uniform(0.4, 3, 3000),
            1 + 10.0 ** rng.uniform(-15, -1, 1000),
            1 - 10.0 ** rng.uniform(-15, -1, 1000),
            2.0 ** np.arange(-1022, 1024),
            np.sqrt(2) * (1 + EPS * np.arange(-4, 5)),
        ]
    )
    out = np.full(x.size, np.nan)
    _logarithms(x, out)
    with mp.workdps(40):
        expected = [float(mp.log(mpf(float(v)))) for v in x]
    assert_allclose(out, expected, rtol=4 * EPS)
