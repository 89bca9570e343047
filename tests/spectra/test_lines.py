"""Lines keep their power and their place in any bands that hold them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import ROUNDING

from skinviz import ArgumentError
from skinviz.spectra.colorimetry import colour_matching_functions, spectrum_to_xyz
from skinviz.spectra.illuminants import (
    Illuminant,
    as_illuminant,
    cie_illuminant,
    illuminant_spd,
    line_lamp,
    with_lines,
)
from skinviz.spectra.lines import deposit
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS, band_widths

MERCURY = np.array([[404.7, 0.2], [435.8, 0.3], [546.1, 1.0], [578.0, 0.4]])

grids = st.lists(st.floats(0.01, 50), min_size=1, max_size=30).map(
    lambda steps: 380 + np.concatenate([[0.0], np.cumsum(steps)])
)


@st.composite
def lines_within(draw):
    """A grid of bands, even or not, and lines within it."""
    bands = draw(grids)
    shares = draw(st.lists(st.floats(0, 1), min_size=1, max_size=8, unique=True))
    nm = np.unique(bands[0] + np.array(shares) * (bands[-1] - bands[0]))
    nm = nm[nm <= bands[-1]]
    power = draw(st.lists(st.floats(1e-9, 1e9), min_size=nm.size, max_size=nm.size))
    return bands, np.stack([nm, power], axis=1)


# --- what bands hold --------------------------------------------------------------


@given(lines_within())
def test_bands_hold_the_power_and_the_place_of_lines(drawn):
    bands, lines = drawn
    held = line_lamp(lines).spd(bands) * band_widths(bands)
    assert (held >= 0).all()
    power = lines[:, 1].sum()
    assert_allclose(held.sum(), power, rtol=ROUNDING)
    assert_allclose(held @ bands, lines.prod(axis=1).sum(), rtol=ROUNDING)


@given(lines_within())
def test_lines_touch_their_neighbours_alone(drawn):
    bands, lines = drawn
    for line in lines:
        lit = np.flatnonzero(deposit(line[None], bands))
        assert lit.size in {1, 2}
        assert np.ptp(lit) <= 1
        assert bands[lit[0]] <= line[0] * (1 + ROUNDING)
        assert bands[lit[-1]] >= line[0] * (1 - ROUNDING)


def test_a_line_on_a_band_is_in_it_alone():
    for nm in PAPER_WAVELENGTHS[[0, 1, 30, -1]]:
        spd = line_lamp([[nm, 7.0]]).spd(PAPER_WAVELENGTHS)
        assert_allclose(spd, np.where(nm == PAPER_WAVELENGTHS, 7.0 / 5, 0), rtol=1e-15)


def test_a_line_between_is_shared_by_nearness():
    spd = line_lamp([[401.0, 10.0]]).spd(PAPER_WAVELENGTHS)
    assert_allclose(spd[:3], [1.6, 0.4, 0], rtol=ROUNDING)


def test_lines_outside_the_bands_are_left_out():
    lamp = line_lamp([[253.7, 5.0], [546.1, 1.0], [1014.0, 3.0]])
    assert_array_equal(
        lamp.spd(PAPER_WAVELENGTHS),
        line_lamp([[546.1, 1.0]]).spd(PAPER_WAVELENGTHS),
    )


def test_rounding_of_the_last_band_loses_no_line():
    bands = np.arange(6001) * 0.05 + 400.0
    for last in (np.nextafter(700, 0), np.nextafter(700, 999)):
        bands[-1] = last
        held = line_lamp([[700.0, 2.0]]).spd(bands) * band_widths(bands)
        assert_allclose(held.sum(), 2.0, rtol=ROUNDING)


def test_one_band_holds_only_its_own_line():
    lamp = line_lamp([[546.1, 1.0], [589.3, 2.0]])
    assert_array_equal(lamp.spd([589.3]), [2.0])
    assert_array_equal(lamp.spd([np.nextafter(589.3, 0)]), [2.0])
    with pytest.raises(ArgumentError, match=r"none within 589 to 589 nm"):
        lamp.spd([589.0])


def test_no_line_within_the_bands_is_no_light():
    with pytest.raises(ArgumentError, match=r"253.7 nm has only lines.*400 to 700"):
        line_lamp([[253.7, 1.0]]).spd(PAPER_WAVELENGTHS)
    with pytest.raises(ArgumentError, match="only lines"):
        line_lamp([[253.7, 1.0], [500, 0.0]]).spd(PAPER_WAVELENGTHS)


@pytest.mark.parametrize("unit", [1e-300, 1e-30, 1.0, 1e30, 1e300])
def test_lines_may_have_any_unit(unit, strict_floats):
    spd = line_lamp([[401, unit], [402.5, 2 * unit]]).spd(PAPER_WAVELENGTHS[:3])
    assert_allclose(spd / unit, [(0.8 + 1) / 5, (0.2 + 1) / 5, 0], rtol=ROUNDING)


def test_power_beyond_a_float_is_told():
    with pytest.raises(ArgumentError, match="too large for a float"):
        line_lamp([[401, 1e308]]).spd([400.999, 401.001])
    with pytest.raises(ArgumentError, match="too large for a float"):
        line_lamp([[401, 1e308], [401.0000000001, 1.7e308]]).spd([401.0])


# --- what is seen -----------------------------------------------------------------


@pytest.mark.parametrize("observer", ["cie1931", "cie1964"])
def test_dense_bands_see_the_lines_themselves(observer):
    nm, power = MERCURY.T
    reflectance = 0.2 + 0.5 * (PAPER_WAVELENGTHS / 700) ** 2
    exact = power * np.interp(nm, PAPER_WAVELENGTHS, reflectance)
    cmfs = colour_matching_functions(nm, observer)
    expected = exact @ cmfs / (power @ cmfs[:, 1])
    off = []
    for step in (20.0, 5.0, 1.0, 0.1):
        bands = 400.0 + step * np.arange(round(300 / step) + 1)
        seen = np.interp(bands, PAPER_WAVELENGTHS, reflectance)
        xyz = spectrum_to_xyz(seen, bands, line_lamp(MERCURY), observer)
        off.append(np.abs(xyz / expected - 1).max())
    assert off[-1] < 1e-4
    assert off[-1] < off[1] < off[0]


def test_one_line_has_the_colour_of_its_wavelength():
    xyz = spectrum_to_xyz(np.ones(401), np.arange(380.0, 781), "589 nm")
    cmfs = colour_matching_functions([589.0])[0]
    assert_allclose(xyz, cmfs / cmfs[1], rtol=ROUNDING)


# --- lamps of lines ---------------------------------------------------------------


def test_lines_come_on_top_of_a_table():
    table = cie_illuminant("FL2")
    lamp = with_lines(table, MERCURY)
    expected = table.spd(PAPER_WAVELENGTHS) + deposit(MERCURY, PAPER_WAVELENGTHS)
    assert_array_equal(lamp.spd(PAPER_WAVELENGTHS), expected)
    assert lamp.name == "FL2 + 404.7 nm + 435.8 nm + 546.1 nm + 578 nm"
    same = Illuminant("lamp", table.wavelengths, table.power, MERCURY)
    assert_array_equal(same.spd(PAPER_WAVELENGTHS), expected)


def test_lines_beside_lines_are_sorted_in():
    lamp = with_lines(line_lamp([[546.1, 1.0]]), [[435.8, 0.3], [578, 0.2]])
    assert_array_equal(lamp.lines, [[435.8, 0.3], [546.1, 1.0], [578, 0.2]])
    with pytest.raises(ArgumentError, match="add the powers of equal ones"):
        with_lines(lamp, [[578, 1.0]])


def test_a_dark_table_with_a_line_is_a_lamp():
    lamp = Illuminant("lamp", [400, 700], [0, 0], [[500, 1.0]])
    assert lamp.spd(PAPER_WAVELENGTHS).sum() > 0


def test_a_table_still_ends_where_it_ends():
    lamp = Illuminant("lamp", [450, 700], [1, 1], [[500, 1.0]])
    with pytest.raises(ArgumentError, match=r"covers 450 to 700.*extrapolated"):
        lamp.spd(PAPER_WAVELENGTHS)


@pytest.mark.parametrize(
    "text", ["632.8 nm", "632.8nm", " 632.80 NM", "line 632.8 nm", "6.328e2 nm"]
)
def test_a_line_is_named_by_its_wavelength(text):
    lamp = as_illuminant(text)
    assert lamp.name == "632.8 nm"
    assert_array_equal(lamp.lines, [[632.8, 1]])
    assert lamp.wavelengths.size == lamp.power.size == 0
    assert_array_equal(as_illuminant(lamp.name).lines, lamp.lines)


@pytest.mark.parametrize("text", ["nm", "632.8", "-5 nm", "632.8 mm", "1 2 nm"])
def test_other_texts_are_no_line(text):
    with pytest.raises(ArgumentError, match=r"unknown illuminant.*'632.8 nm'"):
        as_illuminant(text)


@pytest.mark.parametrize("text", ["0 nm", "1e999 nm"])
def test_impossible_wavelengths_are_refused_by_name(text):
    with pytest.raises(ArgumentError, match="a lamp's lines must"):
        as_illuminant(text)


def test_names_of_many_lines_are_short():
    lamp = line_lamp([[400.0 + i, 1] for i in range(300)])
    assert lamp.name == "300 lines from 400 nm to 699 nm"
    assert line_lamp(MERCURY, "mercury").name == "mercury"


def test_lines_cannot_be_changed_behind_their_back():
    lines = MERCURY.copy()
    lamp = line_lamp(lines)
    lines[:] = 7
    assert_array_equal(lamp.lines, MERCURY)
    with pytest.raises(ValueError, match="read-only"):
        lamp.lines[0] = 1


def test_lamps_without_lines_are_as_before():
    assert cie_illuminant("D65").lines.shape == (0, 2)
    assert_array_equal(illuminant_spd("E", PAPER_WAVELENGTHS), np.full(61, 100.0))


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ([], r"must be pairs.*got shape \(0,\)"),
        ([500, 1], "must be pairs of wavelength and power"),
        ([[500, 1, 2]], "must be pairs"),
        ([["red", 1]], "must be numbers"),
        ([[500, np.nan]], "must be finite"),
        ([[np.inf, 1]], "must be finite"),
        ([[0, 1]], "must lie above 0 nm; got 0 nm"),
        ([[-5, 1], [500, 1]], "must lie above 0 nm; got -5 nm"),
        ([[500, 1], [400, 1]], "ascending; line 1 is at 400 after 500 nm; sort"),
        ([[500, 1], [500, 1]], "add the powers of equal ones"),
        ([[500, 1], [600, -2]], "powers ≥ 0; it is -2 at 600 nm"),
        ([[500, 0]], "0 everywhere, which is no light"),
    ],
)
def test_what_is_no_lamp_of_lines_is_refused(lines, told):
    with pytest.raises(ArgumentError, match=told):
        line_lamp(lines)


def test_a_table_has_to_be_whole_beside_lines():
    with pytest.raises(ArgumentError, match="0 wavelengths on its last axis"):
        Illuminant("lamp", [], [1.0], [[500, 1]])
    with pytest.raises(ArgumentError, match="2 wavelengths on its last axis"):
        Illuminant("lamp", [400, 500], [], [[500, 1]])
