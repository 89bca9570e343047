"""The surface over the skin: Walsh's closed form and Saunderson's limits."""

import numpy as np
import pytest
from mpmath import mp, mpf
from numpy.testing import assert_allclose, assert_array_equal
from oracles import fresnel, two_layer
from tolerances import EPS, ORACLE, QUADRATURE

from skinviz import ArgumentError
from skinviz.skin.interface import diffuse_internal_reflectance, interface
from skinviz.surface import fresnel_reflectance

R_B = np.linspace(0, 1, 21)


@pytest.mark.parametrize("n", [1.1, 1.33, 1.4, 1.5, 2.0, 3.0])
def test_walsh_equals_fresnels_law_integrated_inside(n):
    with mp.workdps(30):
        expected = float(fresnel.diffuse(1 / mpf(n)))
    assert_allclose(diffuse_internal_reflectance(n), expected, rtol=ORACLE)


@pytest.mark.parametrize("n", [1.1, 1.4, 2.0, 3.0])
def test_walsh_equals_the_surface_models_fresnel_integrated_outside(n):
    nodes, weights = np.polynomial.legendre.leggauss(80)
    mu = (nodes + 1) / 2
    outside = float(weights @ (fresnel_reflectance(mu, n) * mu))
    expected = 1 - (1 - outside) / n**2
    assert_allclose(diffuse_internal_reflectance(n), expected, rtol=QUADRATURE)


def test_skins_two_reflectances_are_those_known():
    # PHYSICS.md section 4: n = 1.4 gives k1 = 0.0278 and k2 = 0.529.
    face = interface("included")
    assert_allclose(face.offset, (0.4 / 2.4) ** 2, rtol=4 * EPS)
    assert_allclose(face.internal, 0.529, rtol=0, atol=5e-4)
    assert_allclose(face.transmission, (1 - face.offset) * (1 - face.internal))


def test_saunderson_equals_the_oracle():
    with mp.workdps(40):
        expected = [float(two_layer.saunderson(mpf(float(r)))) for r in R_B]
    assert_allclose(interface("included").measured(R_B), expected, rtol=ORACLE)


@pytest.mark.parametrize("specular", ["included", "excluded"])
def test_white_skin_sends_all_light_back(specular):
    assert_allclose(interface(specular).measured(1.0), 1.0, rtol=4 * EPS)


@pytest.mark.parametrize("specular", ["included", "excluded", 0.03])
def test_black_skin_shows_its_surface_alone(specular):
    face = interface(specular)
    assert face.measured(0.0) == face.offset
    assert face.diffuse(0.0) == 0


@pytest.mark.parametrize("specular", ["included", "excluded", 0.03])
def test_measured_is_surface_and_what_came_from_inside(specular):
    face = interface(specular)
    assert_allclose(face.offset + face.diffuse(R_B), face.measured(R_B), rtol=EPS)


def test_excluded_and_a_constant_leave_the_body_as_it_is():
    assert_array_equal(interface("excluded").measured(R_B), R_B)
    assert_array_equal(interface(0.25).measured(R_B), 0.25 + R_B)
    assert_array_equal(interface(0).measured(R_B), R_B)


@pytest.mark.parametrize("specular", ["included", "excluded", 0.03])
def test_slope_is_the_derivative_of_measured(specular):
    face = interface(specular)
    step = 1e-30  # a complex step does not cancel
    expected = face.measured(R_B + 1j * step).imag / step
    assert_allclose(face.slope(R_B) * np.ones_like(R_B), expected, rtol=4 * EPS)


@pytest.mark.parametrize("wrong", ["include", "SCI", ""])
def test_unknown_words_list_the_known(wrong):
    with pytest.raises(ArgumentError, match="choose one of: excluded, included"):
        interface(wrong)


@pytest.mark.parametrize("wrong", [-0.01, 0.51, np.nan, np.inf, None])
def test_numbers_that_are_no_reflectance_are_refused(wrong):
    with pytest.raises(ArgumentError, match="specular"):
        interface(wrong)
