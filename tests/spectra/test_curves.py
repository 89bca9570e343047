"""Response curves: the standard's and mpmath's numbers, there and back."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import EPS, ORACLE, ROUNDING

from skinviz import ArgumentError
from skinviz.spectra.curves import PowerCurve, SrgbCurve, TableCurve, measured_curve

SRGB_AS_POWER = PowerCurve(2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
RISING = TableCurve([0, 0.1, 0.5, 1], [0.0, 0.01, 0.3, 1.0])
FLAT = TableCurve([0, 0.2, 0.5, 0.6, 0.9, 1], [0, 0, 0.25, 0.25, 1, 1])
CURVES = {
    "sRGB": SrgbCurve(),
    "sRGB as a power": SRGB_AS_POWER,
    "linear": PowerCurve(1.0),
    "gamma 2.2": PowerCurve(2.2),
    "gamma 0.1": PowerCurve(0.1),
    "gamma 10": PowerCurve(10.0),
    "flat at first": PowerCurve(2.0, 1.1, -0.1, 0.0, 0.1 / 1.1),
    "with flare": PowerCurve(2.0, 0.98, 0.0, 0.0, 0.0, 0.02, 0.02),
    "points": RISING,
}


def power(gamma, x):
    """Return x^γ to 50 digits."""
    with mpmath.workdps(50):
        return mpmath.mpf(x) ** mpmath.mpf(gamma)


def srgb_light(numerator, denominator):
    """Return sRGB's light of an encoded fraction, to 50 digits."""
    with mpmath.workdps(50):
        value = mpmath.mpf(numerator) / denominator
        if value <= mpmath.mpf("0.04045"):
            return value / mpmath.mpf("12.92")
        base = (value + mpmath.mpf("0.055")) / mpmath.mpf("1.055")
        return base ** mpmath.mpf("2.4")


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_curves_rise_from_about_0_to_1(curve):
    light = curve.decode(np.linspace(0, 1, 10_001))
    assert (np.diff(light) >= 0).all()
    assert_allclose(light[[0, -1]], [0, 1], atol=0.03)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_light_is_encoded_as_what_shows_it(curve):
    light = curve.decode(np.linspace(0, 1, 10_001))
    assert_allclose(curve.decode(curve.encode(light)), light, rtol=1e-9, atol=3e-8)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_light_beyond_the_ends_is_encoded_as_the_ends(curve, strict_floats):
    shown = curve.encode(np.array([-1e30, -1.0, 3.0, 1e30]))
    assert_allclose(shown[2:], 1, rtol=EPS)
    assert_allclose(curve.decode(shown[:2]), curve.decode(np.zeros(2)), atol=1e-15)
    assert_array_equal(curve.encode(np.array([-np.inf, np.inf])), shown[[0, 3]])


@pytest.mark.parametrize("gamma", [0.1, 1.0, 1.8, 2.2, 10.0])
def test_a_gamma_is_a_power(gamma):
    x = np.linspace(0.01, 1, 50)
    expected = [float(power(gamma, v)) for v in x]
    assert_allclose(PowerCurve(gamma).decode(x), expected, rtol=ORACLE)


def test_srgb_as_iccs_function_is_srgb():
    x = np.linspace(0, 1, 1001)
    assert_allclose(SRGB_AS_POWER.decode(x), SrgbCurve().decode(x), rtol=ROUNDING)
    light = np.linspace(0, 1, 1001)
    # The standard's two thresholds miss each other by 5e-9 of light.
    assert_allclose(SRGB_AS_POWER.encode(light), SrgbCurve().encode(light), atol=1e-7)


def test_a_gap_between_the_pieces_is_encoded_as_its_edge():
    curve = PowerCurve(1.0, 0.5, 0.5, 0.2, 0.5)  # 0.1 below 0.5, 0.75 from there on
    assert_allclose(curve.encode(np.array([0.05, 0.0999])), [0.25, 0.4995])
    assert_allclose(curve.encode(np.array([0.75, 1.0])), [0.5, 1.0])
    assert 0.4999 < curve.encode(np.array([0.3]))[0] <= 0.5


# --- steps ------------------------------------------------------------------------


def test_srgbs_8_bit_steps_are_exact():
    """The least float that is not below the light half-way between two levels."""
    steps = SrgbCurve().steps(255)
    with mpmath.workdps(50):
        for level, step in enumerate(steps, start=1):
            exact = srgb_light(2 * level - 1, 510)
            assert mpmath.mpf(float(step)) >= exact
            assert mpmath.mpf(float(np.nextafter(step, 0))) < exact


def test_srgbs_16_bit_steps_are_right_to_rounding():
    steps = SrgbCurve().steps(65535)
    assert (np.diff(steps) > 0).all()
    for level in np.random.default_rng(0).integers(1, 65536, 300):
        exact = float(srgb_light(2 * int(level) - 1, 131070))
        assert_allclose(steps[level - 1], exact, rtol=8 * EPS)


@pytest.mark.parametrize("gamma", [1.0, 1.8, 2.2, 10.0])
def test_the_steps_of_a_gamma_are_powers(gamma):
    half = (np.arange(1, 256) - 0.5) / 255
    expected = [float(power(gamma, v)) for v in half]
    assert_allclose(PowerCurve(gamma).steps(255), expected, rtol=ORACLE)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
@pytest.mark.parametrize("levels", [255, 65535])
def test_steps_never_fall(curve, levels):
    steps = curve.steps(levels)
    assert steps.shape == (levels,)
    assert (np.diff(steps) >= 0).all()


def test_a_small_dip_between_the_pieces_does_not_unsort_the_steps():
    curve = PowerCurve(2.0, 1.0, 0.0, 0.5, 0.5 + 2e-4)
    assert (np.diff(curve.decode(np.linspace(0.4, 0.6, 999))) < 0).sum() == 0
    dipping = PowerCurve(2.0, 1.0, 0.0, 0.501, 0.5)
    assert (np.diff(dipping.decode(np.linspace(0.4, 0.6, 9999))) < 0).sum() == 1
    assert (np.diff(dipping.steps(65535)) >= 0).all()


# --- measured points --------------------------------------------------------------


def test_points_are_joined_by_straight_lines():
    assert_allclose(RISING.decode(np.array([0.05, 0.3, 0.75])), [0.005, 0.155, 0.65])
    assert_allclose(RISING.encode(np.array([0.005, 0.155, 0.65])), [0.05, 0.3, 0.75])


def test_where_a_curve_is_flat_black_is_0_and_white_is_1():
    assert_array_equal(FLAT.encode(np.array([0.0, 1.0])), [0, 1])
    assert_allclose(FLAT.encode(np.array([1e-9, 0.25, 0.625])), [0.2, 0.6, 0.75])


@pytest.mark.parametrize("unit", [1e-30, 1.0, 3.3, 1e30, 1e308])
@pytest.mark.parametrize("last", [1.0, 255, 1023])
def test_a_measured_curves_units_do_not_matter(unit, last):
    x = np.linspace(0, 1, 9)
    points = np.stack([x * last, (0.01 + 0.99 * x**2.2) * unit], axis=1)
    curve = measured_curve(points)
    assert_allclose(curve.inputs, x, rtol=ROUNDING)
    # The first output is what leaks at black.
    assert_allclose(curve.outputs, x**2.2, rtol=1e-12, atol=1e-14)


@given(st.lists(st.floats(0, 1e6), min_size=2, max_size=20))
def test_any_rising_points_are_a_curve(outputs):
    outputs = np.sort(outputs)
    points = np.stack([np.arange(outputs.size), outputs], axis=1)
    if outputs[-1] <= outputs[0]:
        with pytest.raises(ArgumentError, match="must rise"):
            measured_curve(points)
        return
    curve = measured_curve(points)
    x = np.linspace(0, 1, 41)
    assert_allclose(curve.decode(curve.encode(curve.decode(x))), curve.decode(x))
    assert ((curve.encode(x) >= 0) & (curve.encode(x) <= 1)).all()


# --- refusals ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("points", "told"),
    [
        ([[0, 0]], "at least two rows"),
        ([], "at least two rows"),
        ([0, 1], "at least two rows"),
        ([[0, 0, 0], [1, 1, 1]], "at least two rows"),
        ([[0, 0], [1, np.nan]], "must be finite"),
        ([[0, 0], [np.inf, 1]], "must be finite"),
        ([[1, 0], [2, 1]], "ascend from 0; they run from 1 to 2"),
        ([[0, 0], [-1, 1]], "ascend from 0"),
        ([[0, 0], [2, 0.5], [1, 1]], "inputs must be finite and ascend"),
        ([[0, 0], [1, 0.5], [1, 1]], "inputs must be finite and ascend"),
        ([[0, 1], [1, 0]], "must rise; it runs from 1 to 0"),
        ([[0, 1], [1, 1]], "must rise"),
        ([[0, 0], [1, 2], [2, 1.5], [3, 4]], "must not fall; .* points 1 and 2"),
        ("sRGB", "must be numbers"),
        ([[0, 0], [1]], "must be numbers"),
        ([[0, 0], [1, 0.1], [2, 3.0], [3, 1.0]], "must not fall"),
    ],
)
def test_points_that_are_no_curve_are_refused(points, told):
    with pytest.raises(ArgumentError, match=told):
        measured_curve(points)


@pytest.mark.parametrize("gamma", [0.0, -2.2, 0.09, 10.1, np.nan, np.inf, "2.2", None])
def test_gammas_that_are_none_are_refused(gamma):
    with pytest.raises(ArgumentError, match="a display's gamma must be"):
        PowerCurve(gamma)


@pytest.mark.parametrize(
    ("numbers", "told"),
    [
        ((2.0, -1.0, 1.0), "0 to 1"),
        ((2.0, 1.0, 0.0, 2.0, 0.5), "must not fall"),
        ((2.0, 1.0, 0.0, 0.0, 0.0, np.nan), "a curve's e must be"),
        ((2.0, 1e7), "a curve's a must be"),
        ((2.0, 3.0), "runs from 0 to 9"),
        ((2.0, 0.0), "runs from 0 to 0"),
        ((2.0, 1.0, 0.0, 0.0, 0.0, 0.6, 0.6), "runs from 0.6 to 1.6"),
    ],
)
def test_functions_that_are_no_curve_are_refused(numbers, told):
    with pytest.raises(ArgumentError, match=told):
        PowerCurve(*numbers)


@pytest.mark.parametrize(
    ("inputs", "outputs", "told"),
    [
        ([0, 1], [0, 0.5, 1], r"at least two points .*\(2,\) inputs and \(3,\)"),
        ([0], [0], "at least two points"),
        ([0.1, 1], [0, 1], "from 0 to 1; got 0.1 to 1"),
        ([0, 2], [0, 1], "from 0 to 1; got 0 to 2"),
        ([0, 1], [0, np.nan], "must be finite"),
        ([0, 1], [0, 7], "runs from 0 to 7"),
        ([0, 1], [0.7, 1], "runs from 0.7 to 1"),
    ],
)
def test_tables_that_are_no_curve_are_refused(inputs, outputs, told):
    with pytest.raises(ArgumentError, match=told):
        TableCurve(inputs, outputs)


def test_a_table_cannot_be_changed_behind_its_back():
    inputs, outputs = np.array([0, 0.5, 1]), np.array([0, 0.3, 1])
    curve = TableCurve(inputs, outputs)
    inputs[1] = outputs[1] = 0.9
    assert curve.decode(np.array([0.5])) == 0.3
    with pytest.raises(ValueError, match="read-only"):
        curve.outputs[1] = 0.9
