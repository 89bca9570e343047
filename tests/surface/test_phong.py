"""Phong's lobe: about the mirror direction, normalised, symmetric."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from numpy.testing import assert_allclose
from oracles import fresnel
from oracles import surfaces as oracle
from strategies import log_uniform
from surface_kinds import UP, direction, upwards
from tolerances import KINKED_QUADRATURE, ORACLE

from skinviz.surface import Phong

pytestmark = pytest.mark.usefixtures("strict_floats")

MIRROR = 1e8


@given(light=upwards, view=upwards, p=log_uniform(1e-3, 1e4))
def test_value_is_the_power_of_the_angle_from_the_mirror_direction(light, view, p):
    L, V = direction(*light), direction(*view)
    with mp.workdps(40):
        to, v = (mp.matrix([mpf(float(x)) for x in u]) for u in (L, V))
        to, v = to / mp.norm(to), v / mp.norm(v)
        R = mp.matrix([-to[0], -to[1], to[2]])
        cosine = sum(a * b for a, b in zip(R, v, strict=True))
        F = fresnel.reflectance(mp.norm(to + v) / 2, mpf(1.4))
        lobe = max(cosine, mpf(0)) ** mpf(p) * (mpf(p) + 2) / (2 * mp.pi)
        expected = float(mp.pi * to[2] * lobe * F)
    # Rounding of cos α is magnified by p/cos α.
    rtol = 1e-12 + 1e-15 * p / max(float(cosine), 1e-15)
    found = Phong(p).evaluate(UP, L, V)
    if rtol < 1:
        assert_allclose(found, expected, rtol=rtol, atol=1e-200)
    else:
        assert 0 <= found < 1e-3


def test_the_lobe_is_brightest_against_the_mirror_direction():
    light = direction(0.8)
    angles = np.linspace(0, 1.5, 1501)
    views = np.stack([direction(a, np.pi) for a in angles])
    lobe = Phong(200.0).parts(UP, light, views)["distribution"]
    assert angles[lobe.argmax()] == pytest.approx(0.8, abs=1e-9)
    assert lobe.max() == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("p", [1e4, 1e6, 1e9])
def test_sharp_lobes_keep_their_digits(p):
    light = direction(0.5)
    for turns in (0.0, 0.5, 1.0, 2.0):
        off = turns / np.sqrt(p)
        found = Phong(p).parts(UP, light, direction(0.5 + off, np.pi))["distribution"]
        with mp.workdps(40):
            expected = float(mp.cos(mpf(off)) ** p)
        # The angles are known to 1e-16, which the slope p·off magnifies.
        assert_allclose(found, expected, rtol=1e-11 + 1e-15 * p * off)


@pytest.mark.parametrize("p", [0.0, 1.0, 5.0, 50.0])
def test_all_light_along_the_normal_is_reflected_and_less_elsewhere(p):
    surface = Phong(p)

    def value(N, L, V):
        return surface.evaluate(N, L, V, MIRROR)

    shares = [oracle.albedo(value, np.deg2rad(a)) for a in (0, 20, 40, 60, 80)]
    assert_allclose(shares[0], 1, rtol=KINKED_QUADRATURE)
    assert (np.diff(shares) < 0).all()


@given(p=st.floats(0, 1e9))
def test_peak_is_the_normalisation(p):
    assert_allclose(Phong(p).evaluate(UP, UP, UP, MIRROR), (p + 2) / 2, rtol=1e-7)
    assert Phong(p).beta == (p + 2) / 2


def test_exponent_0_is_half_the_hemisphere():
    # cos⁰ α: all directions within 90 degrees of the mirror direction alike.
    light = direction(0.6)
    views = np.stack([direction(1.4, a) for a in (0.0, np.pi / 2, np.pi)])
    lobe = Phong(0.0).parts(UP, light, views)["distribution"]
    assert_allclose(lobe, [0, 1, 1], rtol=ORACLE)
