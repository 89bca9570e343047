"""The illuminants are the CIE's and Planck's, and nothing between is invented."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import ORACLE, ROUNDING

from skinviz import ArgumentError
from skinviz.spectra.illuminants import (
    Illuminant,
    as_illuminant,
    black_body,
    cie_illuminant,
    illuminant_spd,
    illuminants,
)

NM = np.arange(380.0, 781.0, 5.0)


def planck(nm, kelvin):
    """Return Planck's law, 100 at 560 nm, to 40 digits; c₂ of CIE 15."""
    with mpmath.workdps(40):
        c2 = mpmath.mpf("1.4388e7") / mpmath.mpf(kelvin)

        def power(wavelength):
            x = mpmath.mpf(wavelength)
            return x**-5 / mpmath.expm1(c2 / x)

        return float(100 * power(float(nm)) / power(560))


# --- CIE --------------------------------------------------------------------------


@pytest.mark.parametrize("name", illuminants())
def test_table_is_the_cies(colour, name):
    expected = colour.SDS_ILLUMINANTS[name][NM]
    assert_allclose(illuminant_spd(name, NM), expected, rtol=1e-9)


def test_the_names_a_paper_needs_are_known():
    assert {"A", "C", "D50", "D55", "D65", "D75", "E"} <= set(illuminants())
    for name in (*(f"F{i}" for i in range(1, 13)), "LED-B1", "LED-RGB1", "LED-V2"):
        assert cie_illuminant(name).spd([560.0]) > 0


@pytest.mark.parametrize("i", range(1, 13))
@pytest.mark.parametrize("spelling", ["F{}", "f{}", "FL{}", "fl{}", " F{} "])
def test_fluorescent_lamps_have_two_spellings(i, spelling):
    lamp = cie_illuminant(spelling.format(i))
    assert lamp.name == f"FL{i}"
    assert_array_equal(lamp.power, cie_illuminant(f"FL{i}").power)


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


@pytest.mark.parametrize(
    ("wrong", "nearest"),
    [
        ("D56", "D55, D50, D65, D75"),
        ("D60", "D55, D65, D50, D75"),
        ("F13", "FL12, FL11, FL10"),
        ("LED-B6", "LED-B5, LED-B4, LED-B3"),
        ("LEDB3", "LED-B3"),
        ("FL 2", "FL2"),
        ("led rgb", "LED-RGB1"),
        ("B", "LED-B1, LED-B2"),
    ],
)
def test_unknown_names_list_the_nearest_first(wrong, nearest):
    message = rf"unknown illuminant '{wrong}'; choose one of: ({nearest})\b"
    with pytest.raises(ArgumentError, match=message) as caught:
        cie_illuminant(wrong)
    told = str(caught.value)
    assert all(f" {name}" in told for name in illuminants())
    assert "'3200 K'" in told
    assert "\n" not in told


@pytest.mark.parametrize("wrong", ["", "sun", None, 65, "D65" * 10_000, "D²", "F²"])
def test_what_is_no_name_is_refused(wrong):
    with pytest.raises(ArgumentError, match="unknown illuminant"):
        as_illuminant(wrong)


@pytest.mark.parametrize("nm", [[379.0, 400.0], [700.0, 781.0]])
def test_nothing_is_extrapolated(nm):
    with pytest.raises(ArgumentError, match="illuminant D65 covers 380 to 780 nm"):
        illuminant_spd("D65", nm)


@pytest.mark.parametrize("nm", [[500.0, 400.0], [], 500.0, [500.0, np.nan], [5e2, 5e2]])
def test_wavelengths_that_are_no_grid_are_refused(nm):
    with pytest.raises(ArgumentError, match="wavelengths must be"):
        illuminant_spd("D65", nm)


# --- black bodies -----------------------------------------------------------------


@pytest.mark.parametrize("kelvin", [100, 1000, 2855.5, 3200, 6500, 2e4, 1e6])
def test_black_bodies_are_plancks(kelvin):
    nm = np.array([360.0, 380, 400.1, 555.5, 560, 632.8, 700, 780, 830])
    expected = [planck(x, kelvin) for x in nm]
    assert_allclose(black_body(kelvin).spd(nm), expected, rtol=ORACLE)


def test_black_bodies_are_colour_sciences(colour):
    nm = np.arange(360.0, 831.0)
    for kelvin in (1500, 2856, 6504, 1e5):
        told = colour.colorimetry.planck_law(nm * 1e-9, kelvin)
        expected = 100 * told / told[200]
        assert_allclose(black_body(kelvin).spd(nm), expected, rtol=1e-10)


@pytest.mark.parametrize(("kelvin", "off"), [(1000, 1e-5), (3000, 1e-6), (1e6, 1e-6)])
def test_between_tenths_of_a_nanometre_it_is_nearly_plancks(kelvin, off):
    nm = np.arange(380.05, 780, 7.3)
    expected = [planck(x, kelvin) for x in nm]
    assert_allclose(black_body(kelvin).spd(nm), expected, rtol=off)


def test_illuminant_a_is_the_black_body_that_is_told():
    assert_allclose(black_body(2855.5).spd(NM), illuminant_spd("A", NM), rtol=2e-4)


def test_hotter_is_bluer():
    ratio = [
        np.divide(*black_body(k).spd([450.0, 650.0]))
        for k in np.geomspace(1e2, 1e6, 50)
    ]
    assert (np.diff(ratio) > 0).all()
    # As hot as can be, power goes as λ⁻⁴.
    assert_allclose(ratio[-1], (650 / 450) ** 4, rtol=0.02)


@pytest.mark.parametrize("kelvin", [100, 1e6])
def test_the_coldest_and_the_hottest_do_not_overflow(kelvin, strict_floats):
    power = black_body(kelvin).power
    assert np.isfinite(power).all()
    assert (power > 0).all()


@pytest.mark.parametrize("kelvin", [0, -300, 99.9, 1.1e6, np.nan, np.inf, None, "3200"])
def test_temperatures_that_are_none_are_refused(kelvin):
    with pytest.raises(ArgumentError, match="temperature must be"):
        black_body(kelvin)


# --- names of all kinds -----------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        *("3200 K", "3200K", "3200 k", " 3200.0 K ", "3.2e3 K", "blackbody 3200 K"),
        *("black body 3200 K", "Black-Body 3200K", "black body at 3200 K", "3200. K"),
    ],
)
def test_a_black_body_is_named_by_its_temperature(text):
    assert_array_equal(as_illuminant(text).power, black_body(3200).power)


@pytest.mark.parametrize("text", ["50 K", "2000000 K", "black body 0 K"])
def test_temperatures_out_of_range_are_refused_by_name(text):
    with pytest.raises(
        ArgumentError, match=r"temperature must be in \[100, 1e\+06\] K"
    ):
        as_illuminant(text)


@pytest.mark.parametrize(
    "text", ["K", "-3200 K", "3200 C", "3200", "black body", "1e K"]
)
def test_other_texts_are_no_black_body(text):
    with pytest.raises(ArgumentError, match="unknown illuminant"):
        as_illuminant(text)


@pytest.mark.parametrize(
    "light",
    [
        *(*illuminants(), "3200 K", "2855.54 K", "100 K", "1000000 K", "123456.7 K"),
        *("632.8 nm", "500 nm", "1e-5 nm"),
    ],
)
def test_an_illuminants_name_is_one_that_gives_it_again(light):
    first = as_illuminant(light)
    again = as_illuminant(first.name)
    assert again.name == first.name
    assert_array_equal(again.power, first.power)
    assert_array_equal(again.lines, first.lines)


def test_an_illuminant_stays_as_it_is():
    lamp = Illuminant("lamp", [400, 500], [1, 2])
    assert as_illuminant(lamp) is lamp
    assert_array_equal(illuminant_spd(lamp, [400.0, 450.0]), [1, 1.5])


# --- the user's own ---------------------------------------------------------------


@pytest.mark.parametrize("unit", [1e-300, 1e-30, 1.0, 1e30, 1e300])
def test_power_may_have_any_unit(unit, strict_floats):
    lamp = Illuminant("lamp", [400, 500, 700], np.array([1, 3, 2]) * unit)
    assert_allclose(lamp.spd([450, 600]) / unit, [2, 2.5], rtol=ROUNDING)


def test_a_laser_is_a_line_between_zeros():
    laser = Illuminant("laser", [400, 632, 632.8, 633.6, 700], [0, 0, 1e-30, 0, 0])
    assert_array_equal(laser.spd([400, 500, 632.8, 650]), [0, 0, 1e-30, 0])


def test_one_band_is_known_at_one_wavelength():
    line = Illuminant("line", [589.3], [2.0])
    assert_array_equal(line.spd([589.3]), [2])
    with pytest.raises(ArgumentError, match=r"covers 589.3 to 589.3 nm.*extrapolated"):
        line.spd([589.0])


@given(st.lists(st.floats(0, 1e308), min_size=2, max_size=20))
def test_power_between_points_is_between_theirs(powers):
    if not any(powers):
        return
    nm = 400.0 + 10 * np.arange(len(powers))
    found = Illuminant("any", nm, powers).spd(nm[:-1] + 3.0)
    pairs = np.stack([powers[:-1], powers[1:]])
    assert (found >= pairs.min(axis=0) * (1 - ROUNDING)).all()
    assert (found <= pairs.max(axis=0) * (1 + ROUNDING)).all()


def test_an_illuminant_cannot_be_changed_behind_its_back():
    nm, power = np.array([400.0, 500.0]), np.array([1.0, 2.0])
    lamp = Illuminant("lamp", nm, power)
    power[:] = nm[:] = 7
    assert_array_equal(lamp.power, [1, 2])
    assert_array_equal(lamp.wavelengths, [400, 500])
    with pytest.raises(ValueError, match="read-only"):
        lamp.power[0] = 1
    with pytest.raises(AttributeError):
        lamp.name = "other"


@pytest.mark.parametrize(
    ("nm", "power", "told"),
    [
        ([400, 500], [1, -1e-9], "must be ≥ 0; it is -1e-09 at 500 nm; set noise"),
        ([400, 500], [0, 0], "is 0 everywhere, which is no light"),
        ([400, 500], [1, np.nan], r"must be finite; index \(1,\) is not"),
        ([400, 500], [np.inf, 1], "must be finite"),
        ([500, 400], [1, 1], "strictly ascending"),
        ([400, 400], [1, 1], "strictly ascending"),
        ([400, np.nan], [1, 1], "wavelengths must be finite"),
        ([], [], "at least one value"),
        ([400, 500], [1, 1, 1], "2 wavelengths on its last axis"),
        ([400, 500], [[1, 1], [2, 2]], "must be one spectrum"),
        ([400, 500], ["a", "b"], "must be numbers"),
        ([400, 500], 1.0, "2 wavelengths on its last axis"),
    ],
)
def test_what_is_no_light_is_refused(nm, power, told):
    with pytest.raises(ArgumentError, match=told):
        Illuminant("lamp", nm, power)
