"""Displays: measured primaries, levels exact to rounding, and counts."""

import dataclasses
import io
import pickle

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from icc_profiles import ADOBE_XY, D65_XY, primaries
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import EPS, ORACLE, ROUNDING

from skinviz import ArgumentError
from skinviz.spectra.colorimetry import (
    SRGB_FROM_XYZ,
    decode_srgb,
    encode_srgb,
    xyz_to_linear_srgb,
)
from skinviz.spectra.curves import PowerCurve, SrgbCurve, TableCurve
from skinviz.spectra.display import SRGB, Display, DisplayCounts, measured_display

ADOBE = primaries(ADOBE_XY, D65_XY)
FLAT = TableCurve([0, 0.2, 0.5, 0.6, 0.9, 1], [0, 0, 0.25, 0.25, 1, 1])
DISPLAYS = {
    "sRGB": SRGB,
    "gamma": measured_display(ADOBE.T, 2.2),
    "linear": measured_display(ADOBE.T, 1.0),
    "steep": measured_display(ADOBE.T, 10.0),
    "hollow": measured_display(ADOBE.T, 0.1),
    "three gammas": measured_display(ADOBE.T, [1.8, 2.2, 2.6]),
    "flat pieces": measured_display(ADOBE.T, FLAT),
    "mixed": measured_display(ADOBE.T, [FLAT, SrgbCurve(), PowerCurve(4.0)]),
    "a jump": measured_display(ADOBE.T, [[0, 0], [0.5, 0.1], [0.5001, 0.9], [1, 1]]),
    "a cliff": measured_display(ADOBE.T, [[0, 0], [0.9999999, 0], [1, 1]]),
    "with flare": measured_display(
        ADOBE.T, PowerCurve(2.0, 0.98, 0.0, 0.0, 0.0, 0.02, 0.02)
    ),
}
every_display = pytest.mark.parametrize("display", DISPLAYS.values(), ids=DISPLAYS)
both_depths = pytest.mark.parametrize(
    ("depth", "full"), [("encode8", 255), ("encode16", 65535)]
)
linear_values = st.floats(-1e300, 1e300) | st.floats(-0.1, 1.2)


def neighbours(values):
    """Return values and their next floats, up to three on either side."""
    found = [values]
    below = above = values
    for _ in range(3):
        below, above = np.nextafter(below, -np.inf), np.nextafter(above, np.inf)
        found += [below, above]
    return np.concatenate(found)


def grey(values):
    """Return colours (n, 3) with all channels the same."""
    return np.repeat(np.asarray(values, dtype=float)[:, None], 3, axis=1)


# --- levels, exact to rounding ----------------------------------------------------


def test_srgb_is_rounded_exactly_at_and_around_every_step():
    """255 times the standard's curve, to 50 digits, decides each level."""
    around = neighbours(SrgbCurve().steps(255))
    found = SRGB.encode8(grey(around))[0]
    with mpmath.workdps(50):
        limit, slope = mpmath.mpf("0.0031308"), mpmath.mpf("12.92")
        scale, offset = mpmath.mpf("1.055"), mpmath.mpf("0.055")
        for value, level in zip(around, found, strict=True):
            light = mpmath.mpf(float(value))
            shown = scale * light ** (1 / mpmath.mpf("2.4")) - offset
            shown = slope * light if light <= limit else shown
            assert int(mpmath.floor(255 * shown + mpmath.mpf("0.5"))) == level[0]
    assert (found == found[:, :1]).all()


def test_every_step_of_srgb_separates_two_levels():
    steps = SrgbCurve().steps(255)
    assert_array_equal(SRGB.encode8(grey(steps))[0][:, 0], np.arange(1, 256))
    below = np.nextafter(steps, 0)
    assert_array_equal(SRGB.encode8(grey(below))[0][:, 0], np.arange(255))


@every_display
@both_depths
def test_a_level_is_the_number_of_steps_reached(display, depth, full):
    """By a search through all steps, at and around each and anywhere."""
    rng = np.random.default_rng(0)
    for channel, curve in enumerate(display.curves):
        steps = curve.steps(full)
        black = curve.decode(np.zeros(1))[0]
        values = np.concatenate(
            [
                neighbours(steps),
                rng.uniform(-0.1, 1.1, 20_000),
                10.0 ** rng.uniform(-20, 0, 5_000),
            ]
        )
        values = values[values != black]  # which is level 0 whatever else is as dark
        found = getattr(display, depth)(grey(values))[0][:, channel]
        expected = np.searchsorted(steps, values, side="right")
        # Between black and the rounding of a flat curve's first step.
        flat = np.abs(values - black) < 1e-300
        assert_array_equal(found[~flat], expected[~flat])


@every_display
@both_depths
def test_a_level_is_the_rounded_curve(display, depth, full):
    colours = np.random.default_rng(1).uniform(-0.05, 1.05, (20_000, 3))
    found = getattr(display, depth)(colours)[0]
    exact = full * display.encode(colours)
    near = np.abs(exact % 1 - 0.5) < 1e-6  # there the curve's own rounding decides
    # A level either side of a jump is as far from light that no level shows.
    light = display.decode(found / full) - display.decode(np.round(exact) / full)
    same = (found == np.round(exact)) | (np.abs(light) < 1e-12)
    assert (same | near).all()


@every_display
@both_depths
def test_every_level_survives_the_journey(display, depth, full):
    levels = grey(np.arange(full + 1.0))
    found = getattr(display, depth)(display.decode(levels / full))[0]
    # Of levels that are equally bright any is right.
    assert_array_equal(display.decode(found / full), display.decode(levels / full))
    rises = np.diff(display.decode(levels / full), axis=0) > 0
    if rises.all():
        assert_array_equal(found, levels)


@every_display
@both_depths
def test_black_and_white_are_the_ends(display, depth, full):
    ends = display.decode(np.array([[0.0] * 3, [1.0] * 3]))
    found, counts = getattr(display, depth)(ends)
    assert found.tolist() == [[0] * 3, [full] * 3]
    assert (counts.over_exposed, counts.out_of_gamut) == (0, 0)


@every_display
@given(st.lists(linear_values, min_size=2, max_size=30))
def test_brighter_is_never_shown_darker(display, values):
    found = display.encode8(grey(np.sort(values)))[0].astype(int)
    assert (np.diff(found, axis=0) >= 0).all()


@pytest.mark.parametrize("rows", [1, 2, 127, 128, 129, 255, 256, 257, 1000])
def test_the_number_of_colours_does_not_matter(rows):
    colours = np.random.default_rng(rows).uniform(-0.1, 1.1, (rows, 3))
    found, counts = SRGB.encode8(colours)
    each = [SRGB.encode8(colour) for colour in colours]
    assert_array_equal(found, [levels for levels, _ in each])
    assert counts == sum((one for _, one in each), DisplayCounts())


@pytest.mark.parametrize("shape", [(3,), (0, 3), (5, 0, 3), (4, 5, 3), (2, 3, 4, 3)])
def test_any_shape_of_colours_is_encoded(shape):
    colours = np.random.default_rng(2).uniform(0, 1, shape)
    found, counts = SRGB.encode8(colours)
    assert found.shape == shape
    assert found.dtype == np.uint8
    assert SRGB.encode16(colours)[0].dtype == np.uint16
    assert counts.total == np.prod(shape[:-1])
    assert_array_equal(found, np.round(255 * encode_srgb(colours)))


def test_float32_is_taken_for_what_it_is():
    colours = np.random.default_rng(3).uniform(-0.1, 1.1, (9000, 3)).astype(np.float32)
    found, counts = SRGB.encode8(colours)
    same, also = SRGB.encode8(colours.astype(np.float64))
    assert_array_equal(found, same)
    assert counts == also


def test_parts_of_arrays_are_encoded_as_they_lie():
    colours = np.random.default_rng(4).uniform(0, 1, (40, 50, 6))
    view = colours[::2, ::-1, ::2]
    assert not view.flags.c_contiguous
    assert_array_equal(SRGB.encode8(view)[0], SRGB.encode8(view.copy())[0])


def test_colours_are_left_as_they_were():
    colours = np.random.default_rng(5).uniform(-1, 2, (300, 3))
    before = colours.copy()
    colours.setflags(write=False)
    SRGB.encode8(colours)
    assert_array_equal(colours, before)


# --- what does not fit ------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_infinity_and_huge_values_are_over_exposed(dtype):
    largest = np.finfo(dtype).max
    colours = np.array([[np.inf] * 3, [largest] * 3, [1e30, 0.5, 0.5]], dtype=dtype)
    found, counts = SRGB.encode8(colours)
    assert found.tolist() == [[255] * 3, [255] * 3, [255, 188, 188]]
    assert (counts.over_exposed, counts.out_of_gamut) == (3, 0)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_minus_infinity_is_out_of_gamut(dtype):
    colours = np.array([[-np.inf] * 3, [0.5, -1e30, np.inf]], dtype=dtype)
    found, counts = SRGB.encode8(colours)
    assert found.tolist() == [[0] * 3, [188, 0, 255]]
    assert (counts.over_exposed, counts.out_of_gamut) == (1, 2)


@pytest.mark.parametrize("at", [0, 130, 299])
@pytest.mark.parametrize("channel", [0, 1, 2])
@both_depths
def test_nan_is_refused_wherever_it_is(at, channel, depth, full):
    colours = np.full((300, 3), 0.5)
    colours[at, channel] = np.nan
    message = rf"must not be NaN; 1 are, the first at \[{at}\]"
    with pytest.raises(ArgumentError, match=message):
        getattr(SRGB, depth)(colours)
    picture = colours.reshape(20, 15, 3).astype(np.float32)
    message = rf"the first at \[{at // 15}, {at % 15}\]"
    with pytest.raises(ArgumentError, match=message):
        getattr(SRGB, depth)(picture)


def test_colours_are_counted_once_however_many_channels_do_not_fit():
    colours = np.array([[2, 2, 2], [2, 0.5, 0.5], [-1, -1, 0.5], [2, -1, 0.5], [1] * 3])
    counts = SRGB.encode8(colours)[1]
    assert counts == DisplayCounts(5, 3, 2)


@every_display
def test_what_rounds_to_the_ends_is_not_counted(display):
    # The curve goes on beyond its ends as it comes to them.
    for channel, curve in enumerate(display.curves):
        none, low, high, full = curve.decode(np.array([0, 0.5, 254.5, 255]) / 255)
        above = full + max(full - high, 1e-6)
        below = none - max(low - none, 1e-6)
        colours = np.tile(display.decode(np.full(3, 0.5)), (4, 1))
        colours[:, channel] = [
            above - 1e-9,
            above + 1e-9,
            below + 1e-9,
            below - 1e-9,
        ]
        found = [display.encode8(one)[1] for one in colours]
        assert [one.over_exposed for one in found] == [0, 1, 0, 0]
        assert [one.out_of_gamut for one in found] == [0, 0, 0, 1]


def test_counts_do_not_depend_on_the_depth():
    colours = np.random.default_rng(6).normal(0.5, 0.3, (5000, 3))
    assert SRGB.encode8(colours)[1] == SRGB.encode16(colours)[1]


def test_counts_are_those_of_a_plain_count():
    colours = np.random.default_rng(7).normal(0.5, 0.3, (5000, 3))
    chosen = np.random.default_rng(8).random(5000) < 0.3
    above, below = 2 - decode_srgb(254.5 / 255), -0.5 / 255 / 12.92
    for mask in (None, chosen, np.zeros(5000, bool)):
        part = colours if mask is None else colours[mask]
        counts = SRGB.encode8(colours, mask)[1]
        assert counts.total == len(part)
        assert counts.over_exposed == (part > above).any(axis=1).sum()
        assert counts.out_of_gamut == (part < below).any(axis=1).sum()


@pytest.mark.parametrize(
    "counted", [np.ones(4, bool), np.ones((5, 3), bool), np.ones(5), [True] * 4]
)
def test_a_mask_of_another_shape_is_refused(counted):
    with pytest.raises(ArgumentError, match=r"counted must be bool \(5,\)"):
        SRGB.encode8(np.zeros((5, 3)), counted)


@pytest.mark.parametrize(
    "colours",
    [0.5, np.zeros(4), np.zeros((3, 2)), np.zeros((2, 3), complex), ["a"] * 3],
)
def test_what_is_no_colour_is_refused(colours):
    with pytest.raises(ArgumentError, match="linear colours must be real numbers"):
        SRGB.encode8(colours)


def test_counts_of_tiles_add_up():
    assert DisplayCounts(3, 1, 0) + DisplayCounts(4, 1, 2) == DisplayCounts(7, 2, 2)


# --- sRGB -------------------------------------------------------------------------


def test_srgb_is_the_packages_own():
    rng = np.random.default_rng(9)
    xyz = rng.uniform(-0.2, 1.2, (100, 3))
    assert_array_equal(SRGB.linear(xyz), xyz_to_linear_srgb(xyz))
    assert_array_equal(SRGB.encode(xyz), encode_srgb(xyz))
    assert_array_equal(SRGB.decode(np.abs(xyz)), decode_srgb(np.abs(xyz)))
    assert_allclose(SRGB.linear(SRGB.white), 1, rtol=ROUNDING)
    assert_allclose(SRGB.white, [0.9505, 1.0, 1.089], atol=2e-4)


def test_srgbs_profile_is_srgb_and_the_same_every_day():
    from PIL import ImageCms

    profile = SRGB.profile()
    told = ImageCms.ImageCmsProfile(io.BytesIO(profile)).profile
    assert "sRGB" in told.profile_description
    assert told.creation_date.year == 2000
    assert profile == SRGB.profile()
    assert pickle.loads(pickle.dumps(SRGB)).profile() == profile
    assert DISPLAYS["gamma"].profile() is None


# --- measured displays ------------------------------------------------------------


@pytest.mark.parametrize("unit", [1e-30, 1.0, 80.0, 1e30])
def test_primaries_show_themselves_in_any_unit(unit):
    display = measured_display(ADOBE.T * unit, 2.2)
    assert_allclose(display.linear(ADOBE.T), np.eye(3), atol=1e-14)
    assert_allclose(display.white, ADOBE.sum(axis=1), rtol=ORACLE)
    assert_allclose(display.white[1], 1, rtol=ORACLE)


def test_adobes_matrix_is_colour_sciences(colour):
    space = colour.RGB_COLOURSPACES["Adobe RGB (1998)"]
    # Made of the same chromaticities, to the rounding of the white's.
    assert_allclose(
        measured_display(ADOBE.T).matrix, space.matrix_XYZ_to_RGB, rtol=0, atol=1e-3
    )


def test_black_is_taken_off_the_primaries():
    black = np.array([0.002, 0.003, 0.004])
    clean = measured_display(ADOBE.T)
    assert_allclose(
        measured_display(ADOBE.T + black, black=black).matrix, clean.matrix, rtol=1e-10
    )


def test_curves_may_be_given_in_many_ways():
    table = [[0, 0], [100, 0.2], [255, 1]]
    for curves, kinds in {
        2.2: (PowerCurve,) * 3,
        "sRGB": (SrgbCurve,) * 3,
        "srgb": (SrgbCurve,) * 3,
    }.items():
        made = measured_display(ADOBE.T, curves).curves
        assert tuple(type(one) for one in made) == kinds
    assert measured_display(ADOBE.T, (1.8, 2.0, 2.2)).curves[2] == PowerCurve(2.2)
    assert measured_display(ADOBE.T, np.array([1.8, 2.0, 2.2])).curves[0].gamma == 1.8
    one = measured_display(ADOBE.T, table).curves
    three = measured_display(ADOBE.T, [table, "sRGB", 2.2]).curves
    as_array = measured_display(ADOBE.T, np.array([table] * 3)).curves
    for curve in (*one, three[0], *as_array):
        assert_allclose(curve.decode(np.array([100 / 255])), 0.2, rtol=ROUNDING)
    assert three[1:] == (SrgbCurve(), PowerCurve(2.2))


@pytest.mark.parametrize(
    ("curves", "told"),
    [
        ("gamma", "unknown curve 'gamma'"),
        ([2.2, 2.2], "or three of these"),
        ([2.2] * 4, "or three of these"),
        ([], "or three of these"),
        ({}, "gamma must be a number"),
        (None, "gamma must be a number"),
        (0.0, "gamma must be in"),
        (np.nan, "gamma must be in"),
        (["sRGB", 2.2, "x"], "unknown curve 'x'"),
        ([[0, 0], [1, 1], [2, 0.5]], "must not fall"),
        ([[0, 0]], "at least two rows"),
        ([2.2, [[0, 1], [1, 0]], 2.2], "must rise"),
        ([[0, 0], [1]], "must be numbers"),
    ],
)
def test_curves_that_are_none_are_refused(curves, told):
    with pytest.raises(ArgumentError, match=told):
        measured_display(ADOBE.T, curves)


@pytest.mark.parametrize(
    ("primaries", "told"),
    [
        (np.zeros((3, 3)), "no luminance"),
        (-ADOBE.T, "must be ≥ 0"),
        (ADOBE.T * np.nan, "finite"),
        (ADOBE.T[:2], r"\(3, 3\)"),
        (np.ones((3, 3)), "mixture of the others"),
        (np.stack([ADOBE[:, 0], ADOBE[:, 0] * 2, ADOBE[:, 2]]), "mixture"),
        (ADOBE.T * [[0], [1], [1]], "mixture"),
        ("red", "must be numbers"),
    ],
)
def test_primaries_that_are_none_are_refused(primaries, told):
    with pytest.raises(ArgumentError, match=told):
        measured_display(primaries)


@pytest.mark.parametrize(
    ("black", "told"),
    [
        ([1.0, 1, 1], "black the darkest"),
        ([-0.1, 0, 0], "≥ 0"),
        ([0, 0], "one XYZ"),
        ([np.nan, 0, 0], "finite"),
        ("dark", "black must be numbers"),
    ],
)
def test_blacks_that_are_none_are_refused(black, told):
    with pytest.raises(ArgumentError, match=told):
        measured_display(ADOBE.T, black=black)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"matrix": np.eye(2)}, "must be \\(3, 3\\)"),
        ({"matrix": np.full((3, 3), np.inf)}, "finite"),
        ({"matrix": np.ones((3, 3))}, "mixture"),
        ({"matrix": np.zeros((3, 3))}, "mixture"),
        ({"curves": (SrgbCurve(),)}, "3 curves; got 1"),
    ],
)
def test_displays_that_are_none_are_refused(changes, told):
    with pytest.raises(ArgumentError, match=told):
        dataclasses.replace(SRGB, **changes)


def test_a_display_cannot_be_changed_behind_its_back():
    matrix = SRGB_FROM_XYZ.copy()
    display = Display("mine", matrix, SRGB.curves)
    matrix[:] = 0
    assert_array_equal(display.matrix, SRGB_FROM_XYZ)
    with pytest.raises(ValueError, match="read-only"):
        display.matrix[0, 0] = 1
    other = dataclasses.replace(display, curves=(PowerCurve(1.0),) * 3)
    assert other.encode8(np.full(3, 0.2))[0].tolist() == [51] * 3
    assert display.encode8(np.full(3, 0.2))[0].tolist() == [124] * 3


@pytest.mark.parametrize("method", ["encode", "decode", "linear"])
def test_curves_need_three_channels(method):
    for colours in (0.5, [0.5, 0.5], np.zeros((3, 4))):
        with pytest.raises(ArgumentError, match=r"colours must be \(..., 3\)"):
            getattr(SRGB, method)(colours)


def test_levels_are_those_of_the_curve_where_steps_crowd():
    # A steep curve has hundreds of 16-bit steps in one bin of the look-up.
    display = DISPLAYS["steep"]
    values = 10.0 ** np.linspace(-40, 0, 4001)
    found = display.encode16(grey(values))[0][:, 0]
    exact = 65535 * values**0.1
    assert (np.abs(found - exact) <= 0.5 + 65535 * 8 * EPS).all()
