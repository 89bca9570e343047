"""The illuminants are the CIE's, and nothing between 5 nm is invented."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import ArgumentError
from skinviz.spectra.illuminants import illuminant_spd, illuminants

NM = np.arange(380.0, 781.0, 5.0)


@pytest.mark.parametrize("name", illuminants())
def test_table_is_the_cies(colour, name):
    expected = colour.SDS_ILLUMINANTS[name][NM]
    assert_allclose(illuminant_spd(name, NM), expected, rtol=1e-9)


def test_the_names_a_paper_needs_are_known():
    assert {"A", "C", "D50", "D65", "E", "FL2", "FL11"} <= set(illuminants())


def test_illuminant_a_is_plancks_lamp():
    # CIE 15: 100 (560/λ)⁵ (e^(b/560) − 1)/(e^(b/λ) − 1), b = 1.435e7/2848 nm.
    b = 1.435e7 / 2848
    planck = 100 * (560 / NM) ** 5 * np.expm1(b / 560) / np.expm1(b / NM)
    assert_allclose(illuminant_spd("A", NM), planck, rtol=1e-4)


def test_between_the_table_it_is_straight():
    halves = illuminant_spd("D65", NM[:-1] + 2.5)
    table = illuminant_spd("D65", NM)
    assert_allclose(halves, (table[1:] + table[:-1]) / 2)


def test_names_are_known_in_either_case():
    assert_array_equal(illuminant_spd("d65", NM), illuminant_spd("D65", NM))
    assert_array_equal(illuminant_spd("led-b1", NM), illuminant_spd("LED-B1", NM))


@pytest.mark.parametrize("wrong", ["D56", "", "sun", None])
def test_unknown_names_list_the_known(wrong):
    with pytest.raises(ArgumentError, match="choose one of: A, C, D50"):
        illuminant_spd(wrong, NM)


@pytest.mark.parametrize("nm", [[379.0, 400.0], [700.0, 781.0]])
def test_nothing_is_extrapolated(nm):
    with pytest.raises(ArgumentError, match="illuminant D65 covers 380 to 780 nm"):
        illuminant_spd("D65", nm)


@pytest.mark.parametrize("nm", [[500.0, 400.0], [], 500.0, [500.0, np.nan], [5e2, 5e2]])
def test_wavelengths_that_are_no_grid_are_refused(nm):
    with pytest.raises(ArgumentError, match="wavelengths must be"):
        illuminant_spd("D65", nm)
