"""Fresnel's law: its limits, Brewster's angle, and exchange through the surface."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from numpy.testing import assert_allclose, assert_array_equal
from oracles import fresnel as oracle
from oracles.agreement import assert_oracle
from tolerances import EPS, ORACLE, ROUNDING

from skinviz import ArgumentError
from skinviz.surface import fresnel_reflectance

pytestmark = pytest.mark.usefixtures("strict_floats")

COSINES = np.cos(np.deg2rad(np.linspace(0, 90, 91))).clip(0)
INDICES = (1.0001, 1.1, 1.33, 1.4, 2.0, 3.0)


@pytest.mark.parametrize("n", [1 + 1e-12, *INDICES, 1e3])
def test_reflectance_equals_the_oracle(n):
    with mp.workdps(60):
        expected = [float(oracle.reflectance(float(mu), mpf(n))) for mu in COSINES]
    assert_oracle(fresnel_reflectance(COSINES, n), expected)


def test_nothing_is_reflected_where_nothing_changes():
    assert_array_equal(fresnel_reflectance(COSINES, 1.0), 0)


@pytest.mark.parametrize("n", INDICES)
def test_everything_is_reflected_at_grazing(n):
    assert_allclose(fresnel_reflectance(0.0, n), 1, rtol=4 * EPS)


@given(n=st.floats(1, 100))
def test_normal_incidence_has_the_known_form(n):
    expected = ((n - 1) / (n + 1)) ** 2
    assert_allclose(fresnel_reflectance(1.0, n), expected, rtol=ORACLE)


@pytest.mark.parametrize("n", INDICES)
def test_brewsters_angle_leaves_s_light_alone(n):
    # tan θ = n: R_p = 0 and R_s = ((n² − 1)/(n² + 1))².
    cosine = 1 / np.sqrt(1 + n * n)
    s = ((n * n - 1) / (n * n + 1)) ** 2
    assert_allclose(fresnel_reflectance(cosine, n), s / 2, rtol=ORACLE)


@given(n=st.floats(1, 3), mu=st.floats(1e-3, 1))
def test_a_surface_reflects_alike_from_both_sides(n, mu):
    refracted = np.sqrt(1 - (1 - mu * mu) / n**2)
    with mp.workdps(30):
        inside = float(oracle.reflectance(mpf(float(refracted)), 1 / mpf(n)))
    # The refracted cosine is rounded, and R falls steeply near total reflection.
    assert_allclose(fresnel_reflectance(mu, n), inside, rtol=1e-8, atol=1e-20)


@given(n=st.floats(1, 1e6), mu=st.floats(0, 1))
def test_reflectance_is_a_share(n, mu):
    assert 0 <= fresnel_reflectance(mu, n) <= 1 + 4 * EPS


@given(n=st.floats(1, 3), more=st.floats(0, 3))
def test_more_contrast_reflects_more_at_normal_incidence(n, more):
    low, high = fresnel_reflectance(1.0, [n, n + more])
    assert high >= low * (1 - ROUNDING)


@pytest.mark.parametrize("n", [1.1, 1.4, 2.0, 3.0])
def test_diffuse_light_is_exchanged_by_n_squared(n):
    # 1 − R_int = (1 − R_ext)/n², R_ext from the package and R_int from inside.
    x, w = np.polynomial.legendre.leggauss(80)
    mu = (x + 1) / 2
    outside = w @ (fresnel_reflectance(mu, n) * mu)
    inside = float(oracle.diffuse(1 / mpf(n)))
    assert_allclose(1 - inside, (1 - outside) / n**2, rtol=1e-10)


def test_a_near_perfect_mirror_reflects_nearly_all():
    assert_allclose(fresnel_reflectance(COSINES, 1e8), 1, rtol=0, atol=3e-6)


def test_arguments_broadcast():
    found = fresnel_reflectance(COSINES[:, None], INDICES)
    assert found.shape == (91, len(INDICES))
    assert_array_equal(found[:, 3], fresnel_reflectance(COSINES, INDICES[3]))


def test_rounding_above_one_is_forgiven():
    assert fresnel_reflectance(1 + 4 * EPS, 1.4) == fresnel_reflectance(1.0, 1.4)


@pytest.mark.parametrize("wrong", [-0.1, 1.1, np.nan, [0.5, -1.0]])
def test_cosines_that_are_none_are_refused(wrong):
    with pytest.raises(ArgumentError, match="cosine of incidence must be in"):
        fresnel_reflectance(wrong, 1.4)


@pytest.mark.parametrize("wrong", [0.99, 0.0, -1.4, np.nan, [1.4, 0.5]])
def test_light_from_the_dense_side_is_refused(wrong):
    with pytest.raises(ArgumentError, match="refractive index must be at least 1"):
        fresnel_reflectance(0.5, wrong)


def test_an_infinite_index_is_refused_and_named():
    with pytest.raises(ArgumentError, match=r"index must be .* got inf"):
        fresnel_reflectance(0.5, [1.4, np.inf])
