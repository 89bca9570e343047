"""Colour: the CIE's tables and formulas, against colour-science and themselves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from oracles import delta_e as oracle
from oracles.sharma2005 import PAIRS
from strategies import lab_colours
from tolerances import EPS, ORACLE, QUADRATURE, ROUNDING

from skinviz import ArgumentError
from skinviz.spectra.colorimetry import (
    OBSERVERS,
    colour_matching_functions,
    decode_srgb,
    delta_e_2000,
    encode_srgb,
    lab_to_xyz,
    spectrum_to_xyz,
    xyz_to_lab,
    xyz_to_linear_srgb,
    xyz_weights,
)
from skinviz.spectra.illuminants import Illuminant, illuminant_spd, illuminants
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS as NM

NAMES = {
    "cie1931": "CIE 1931 2 Degree Standard Observer",
    "cie1964": "CIE 1964 10 Degree Standard Observer",
}


def random_lab(n, seed):
    """Return CIELAB colours (n, 3)."""
    rng = np.random.default_rng(seed)
    return rng.uniform([0, -100, -100], [100, 100, 100], (n, 3))


# --- tristimulus values --------------------------------------------------------


@pytest.mark.parametrize("observer", OBSERVERS)
def test_observers_are_the_cies(colour, observer):
    nm = np.arange(360.0, 831.0)
    expected = colour.MSDS_CMFS[NAMES[observer]][nm]
    # The shipped table keeps ten digits.
    found = colour_matching_functions(nm, observer)
    assert (found >= 0).all()
    # The oracle has -1e-20 where the CIE has 0.
    assert_allclose(found, expected, rtol=1e-9, atol=1e-19)


def by_colour_science(colour, reflectance, nm, spd, observer):
    """Return XYZ (n, 3) of spectra by colour-science's own sums, white Y = 1."""
    step = nm[1] - nm[0]
    shape = colour.SpectralShape(nm[0], nm[-1], step)
    functions = colour_matching_functions(nm, observer)
    return [
        colour.sd_to_XYZ(
            colour.SpectralDistribution(row, nm),
            colour.MultiSpectralDistributions(functions, nm),
            colour.SpectralDistribution(spd, nm),
            method="Integration",
            shape=shape,
        )
        / 100
        for row in reflectance
    ]


GRIDS = {
    "400-700/5": (400, 700, 5),
    "380-780/1": (380, 780, 1),
    "380-780/5": (380, 780, 5),
    "400-700/10": (400, 700, 10),
    "420-660/20": (420, 660, 20),
    "400-699/2.5": (400, 697.5, 2.5),
}


@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("illuminant", [*illuminants(), "3200 K", "100 K", "1e6 K"])
@pytest.mark.parametrize("grid", GRIDS.values(), ids=GRIDS)
def test_xyz_is_colour_sciences_on_the_same_bands(colour, grid, illuminant, observer):
    first, last, step = grid
    nm = np.arange(first, last + step / 2, step, dtype=float)
    reflectance = np.random.default_rng(1).uniform(0, 1, (2, nm.size))
    spd = illuminant_spd(illuminant, nm)
    expected = by_colour_science(colour, reflectance, nm, spd, observer)
    found = spectrum_to_xyz(reflectance, nm, illuminant, observer)
    # colour-science's own rounding shows in the blue of a body of 100 K, 1e-16.
    assert_allclose(found, expected, rtol=QUADRATURE, atol=1e-14)


@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("illuminant", ["A", "D50", "D65", "FL2", "E"])
def test_xyz_is_that_of_colour_sciences_own_tables(colour, illuminant, observer):
    shape = colour.SpectralShape(400, 700, 5)
    reflectance = np.random.default_rng(2).uniform(0, 1, NM.size)
    expected = (
        colour.sd_to_XYZ(
            colour.SpectralDistribution(reflectance, NM),
            colour.MultiSpectralDistributions(
                colour.MSDS_CMFS[NAMES[observer]][NM], NM
            ),
            colour.SpectralDistribution(colour.SDS_ILLUMINANTS[illuminant][NM], NM),
            method="Integration",
            shape=shape,
        )
        / 100
    )
    found = spectrum_to_xyz(reflectance, NM, illuminant, observer)
    assert_allclose(found, expected, rtol=QUADRATURE)


@pytest.mark.parametrize("unit", [1e-30, 1.0, 1e30])
def test_xyz_under_a_measured_lamp_is_colour_sciences(colour, unit):
    rng = np.random.default_rng(3)
    own_nm = np.sort(rng.uniform(390, 710, 200))
    own_nm[[0, -1]] = 390, 710
    lamp = Illuminant("lamp", own_nm, rng.uniform(0, 1, 200) * unit)
    spd = np.interp(NM, own_nm, lamp.power)
    reflectance = rng.uniform(0, 1, (2, NM.size))
    expected = by_colour_science(colour, reflectance, NM, spd / unit, "cie1931")
    assert_allclose(spectrum_to_xyz(reflectance, NM, lamp), expected, rtol=QUADRATURE)


def test_a_lamp_that_does_not_reach_is_refused():
    with pytest.raises(ArgumentError, match="illuminant lamp covers 450 to 700 nm"):
        spectrum_to_xyz(np.ones(61), NM, Illuminant("lamp", [450, 700], [1, 1]))


@pytest.mark.parametrize("illuminant", illuminants())
@pytest.mark.parametrize("observer", OBSERVERS)
def test_perfect_diffuser_has_y_1(illuminant, observer):
    xyz = spectrum_to_xyz(np.ones(NM.size), NM, illuminant, observer)
    assert_allclose(xyz[1], 1, rtol=ROUNDING)


def test_d65_is_at_its_chromaticity():
    # x = 0.3127, y = 0.3290 over 380–780 nm; four decimals are published.
    nm = np.arange(380.0, 781.0, 5.0)
    xyz = spectrum_to_xyz(np.ones(nm.size), nm)
    assert_allclose((xyz / xyz.sum())[:2], [0.3127, 0.3290], rtol=0, atol=1e-4)


def test_xyz_is_linear_in_reflectance():
    rng = np.random.default_rng(2)
    a, b = rng.uniform(0, 1, (2, 5, NM.size))
    mixed = spectrum_to_xyz(0.3 * a + 0.7 * b, NM)
    apart = 0.3 * spectrum_to_xyz(a, NM) + 0.7 * spectrum_to_xyz(b, NM)
    assert_allclose(mixed, apart, rtol=ROUNDING)


def test_finer_bands_change_smooth_spectra_little():
    def xyz(step):
        nm = np.arange(400.0, 701.0, step)
        return spectrum_to_xyz(0.4 + 0.3 * np.tanh((nm - 560) / 60), nm, "A")

    assert_allclose(xyz(5.0), xyz(1.0), rtol=0, atol=1e-3)


@pytest.mark.parametrize("scale", [1e-300, 1e-30, 1.0, 1e30, 1e300])
def test_weights_do_not_depend_on_the_lamps_power(scale, strict_floats):
    lamp = illuminant_spd("A", NM)
    assert_allclose(xyz_weights(NM, lamp * scale), xyz_weights(NM, lamp), rtol=ROUNDING)


@pytest.mark.parametrize("i", [0, 10, 31, 60])
@pytest.mark.parametrize("power", [1e-30, 1.0, 1e30])
def test_a_single_line_has_the_colour_of_its_wavelength(i, power):
    laser = np.zeros(NM.size)
    laser[i] = power
    reflectance = np.linspace(0.1, 0.9, NM.size)
    cmfs = colour_matching_functions(NM)[i]
    expected = reflectance[i] * cmfs / cmfs[1]
    assert_allclose(reflectance @ xyz_weights(NM, laser), expected, rtol=ROUNDING)


def test_one_band_alone_is_a_colour():
    band = np.array([550.0])
    cmfs = colour_matching_functions(band)[0]
    assert_allclose(xyz_weights(band, [3.0])[0], cmfs / cmfs[1], rtol=ROUNDING)


def test_bands_of_unequal_width_count_by_their_width():
    nm = np.array([500.0, 510, 520, 540, 560])
    widths = np.array([10.0, 10, 15, 20, 20])
    weights = widths[:, None] * colour_matching_functions(nm)
    expected = weights / weights[:, 1].sum()
    assert_allclose(xyz_weights(nm, np.ones(5)), expected, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("spd", "told"),
    [
        (np.zeros(61), "not all zero"),
        (-np.ones(61), "≥ 0"),
        (np.ones((2, 61)), "one spectrum"),
        (np.full(61, np.nan), "must be finite"),
        (np.ones(60), "61 wavelengths on its last axis"),
    ],
)
def test_illuminants_that_are_none_are_refused(spd, told):
    with pytest.raises(ArgumentError, match=told):
        xyz_weights(NM, spd)


def test_light_that_nobody_sees_is_refused():
    with pytest.raises(ArgumentError, match="observer's table covers 360 to 830"):
        xyz_weights([840.0, 850.0], [1.0, 1.0])


def test_unknown_observer_lists_the_known():
    with pytest.raises(ArgumentError, match="choose one of: cie1931, cie1964"):
        spectrum_to_xyz(np.ones(61), NM, "D65", "cie2006")


# --- CIELAB and ΔE00 -----------------------------------------------------------


def test_lab_is_colour_sciences(colour):
    rng = np.random.default_rng(3)
    # Down to 1e-6, where the cube root gives way to a straight line.
    xyz = rng.uniform(0, 1, (500, 3)) ** rng.choice([1, 4, 12], (500, 1))
    white = np.array([0.95, 1.0, 1.09])
    expected = colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(white))
    # colour-science takes the white by its chromaticity, where Y = 1.
    assert_allclose(xyz_to_lab(xyz, white), expected, rtol=1e-9, atol=1e-9)


def test_white_and_black_are_grey():
    white = np.array([0.9, 1.0, 0.4])
    assert_allclose(xyz_to_lab(white, white), [100, 0, 0], atol=1e-12)
    assert_allclose(xyz_to_lab([0, 0, 0], white), [0, 0, 0], atol=1e-12)


def test_lab_and_back(colour):
    white = np.array([0.9505, 1.0, 1.089])
    dark_and_light = np.geomspace(1e-6, 1.2, 40)[:, None] * [1.05, 1.0, 0.8]
    lab = xyz_to_lab(dark_and_light, white)
    assert_allclose(lab_to_xyz(lab, white), dark_and_light, rtol=1e-12, atol=1e-16)
    expected = colour.Lab_to_XYZ(lab, colour.XYZ_to_xy(white))
    assert_allclose(lab_to_xyz(lab, white), expected, rtol=1e-9, atol=1e-9)


def test_lab_depends_on_the_ratio_to_white_alone():
    xyz, white = np.array([0.3, 0.4, 0.2]), np.array([0.95, 1, 1.09])
    assert_allclose(
        xyz_to_lab(xyz * 1e30, white * 1e30), xyz_to_lab(xyz, white), rtol=ROUNDING
    )


def test_lab_is_continuous_where_the_curve_changes():
    # ε = (6/29)³; value and slope meet there.
    y = (6 / 29) ** 3 * np.array([1 - 1e-9, 1 + 1e-9])
    L = xyz_to_lab(np.column_stack([y, y, y]), [1, 1, 1])[:, 0]
    assert_allclose(L[1] - L[0], 903.2963 * 2e-9 * y.mean(), rtol=1e-5)


@pytest.mark.parametrize(("one", "other", "expected"), PAIRS)
def test_delta_e_of_sharmas_pairs(one, other, expected):
    assert_allclose(delta_e_2000(one, other), expected, rtol=0, atol=5e-5)
    assert_allclose(delta_e_2000(other, one), expected, rtol=0, atol=5e-5)


def test_delta_e_is_colour_sciences(colour):
    one, other = random_lab(4000, 4), random_lab(4000, 5)
    # Near and far, greys, and hues on both sides of 0.
    other[:1000] = one[:1000] + (other[:1000] - 50) / 100
    one[1000:1100, 1:] = 0
    other[1050:1150, 1:] = 0
    one[2000:2500, 2] *= 1e-3
    other[2000:2500, 2] *= -1e-3
    expected = colour.delta_E(one, other, method="CIE 2000")
    assert_allclose(delta_e_2000(one, other), expected, rtol=1e-10, atol=1e-10)


OPPOSITE = [
    ((50.0, -15.0, 1.0), (50.0, 60.0, -4.0)),
    ((64.0, 60.0, -49.0), (63.0, -60.0, 49.0)),
    ((50.0, 10.0, -10.0), (50.0, -30.0, 30.0)),
    ((50.0, 0.0, -10.0), (50.0, 0.0, 30.0)),
    ((50.0, 20.0, 0.0), (50.0, -40.0, 0.0)),
]
"""Colours whose hues lie exactly 180° apart, where the formula has its seam."""


@pytest.mark.parametrize(("one", "other"), OPPOSITE)
def test_delta_e_of_opposite_hues_equals_the_oracle(one, other):
    expected = oracle.delta_e_2000(one, other)
    assert_allclose(delta_e_2000(one, other), expected, rtol=1e-10)
    assert_allclose(delta_e_2000(other, one), expected, rtol=1e-10)


@given(one=lab_colours, other=lab_colours)
def test_delta_e_equals_the_oracle(one, other):
    expected = oracle.delta_e_2000(one, other)
    assert_allclose(delta_e_2000(one, other), expected, rtol=1e-9, atol=1e-7)


@given(one=lab_colours, other=lab_colours)
def test_delta_e_is_symmetric(one, other):
    assert_allclose(
        delta_e_2000(one, other), delta_e_2000(other, one), rtol=1e-10, atol=1e-12
    )


@given(colour=lab_colours)
def test_a_colour_does_not_differ_from_itself(colour):
    assert delta_e_2000(colour, colour) == 0


def test_delta_e_broadcasts():
    one = random_lab(6, 6).reshape(2, 3, 3)
    found = delta_e_2000(one, [50.0, 10.0, 10.0])
    assert found.shape == (2, 3)
    assert_allclose(found[1, 2], delta_e_2000(one[1, 2], [50.0, 10.0, 10.0]))


# --- display -------------------------------------------------------------------


def test_srgb_curve_is_colour_sciences(colour):
    values = np.concatenate([np.linspace(0, 1, 1001), np.geomspace(1e-9, 1, 300)])
    expected = colour.models.eotf_inverse_sRGB(values)
    assert_allclose(encode_srgb(values), expected, rtol=ORACLE, atol=1e-15)
    expected = colour.models.eotf_sRGB(values)
    assert_allclose(decode_srgb(values), expected, rtol=ORACLE, atol=1e-15)


@given(st.floats(0, 1))
def test_decoding_undoes_encoding(linear):
    # At the join the standard's two pieces differ by 2e-8.
    assert_allclose(decode_srgb(encode_srgb(linear)), linear, rtol=1e-6, atol=1e-15)


def test_every_8_bit_value_survives_the_journey():
    codes = np.arange(256)
    back = np.rint(encode_srgb(decode_srgb(codes / 255)) * 255)
    assert_array_equal(back, codes)


def test_encoding_rises():
    values = np.linspace(0, 1, 100_001)
    assert (np.diff(encode_srgb(values)) > 0).all()


def test_what_the_display_cannot_show_is_clipped():
    shown = encode_srgb([-0.5, 0.0, 1.0, 7.0, 1e30])
    assert_allclose(shown, [0, 0, 1, 1, 1], rtol=EPS)


def test_display_white_is_d65():
    # x = 0.3127, y = 0.3290, of which the matrix keeps four decimals.
    white = np.array([0.3127 / 0.3290, 1.0, (1 - 0.3127 - 0.3290) / 0.3290])
    assert_allclose(xyz_to_linear_srgb(white), 1, rtol=0, atol=5e-4)


def test_primaries_are_the_standards(colour):
    matrix = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB
    found = xyz_to_linear_srgb(np.eye(3)).T
    assert_allclose(found, matrix, rtol=0, atol=5e-5)


def test_linear_srgb_keeps_the_batch():
    xyz = np.random.default_rng(7).uniform(0, 1, (2, 4, 3))
    assert_allclose(xyz_to_linear_srgb(xyz)[1, 3], xyz_to_linear_srgb(xyz[1, 3]))
