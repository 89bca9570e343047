"""Spectral rules keep white, lines and the colours of measured skin."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import ROUNDING

from skinviz import ArgumentError, load_archive, skin_model
from skinviz.spectra.colorimetry import (
    OBSERVERS,
    colour_matching_functions,
    delta_e_2000,
    xyz_to_lab,
    xyz_weights,
)
from skinviz.spectra.illuminants import (
    Illuminant,
    black_body,
    cie_illuminant,
    illuminant_spd,
    line_lamp,
    with_lines,
)
from skinviz.spectra.rules import band_rule, exact_rule, quadrature_rule
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS

NM = np.arange(380.0, 781.0)
LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3", "3000 K")
MERCURY = line_lamp([[404.7, 0.2], [435.8, 0.3], [546.1, 1.0], [578.0, 0.4]])

# Largest ΔE00 over the archives' spectra under six lamps for both observers; measured
# by scripts/benchmarks/quadrature.py and rounded up.
BOUNDS = {4: 3.0, 5: 1.8, 6: 1.5, 8: 0.9, 10: 0.6, 12: 0.4}


@pytest.fixture(scope="module")
def skin():
    """The two-layer model's training spectra at any wavelengths."""
    model = skin_model(site="cheek", specular="included")
    return lambda nm: model.diffuse(model.starts, nm)


@pytest.fixture(scope="module")
def measured():
    """Every whole spectrum of both archives at 1 nm, held beyond its ends."""
    found = []
    for name in ("issa", "nist"):
        archive = load_archive(name).sel(wavelength=slice(400, 740))
        spectra = archive.reflectance.values
        spectra = spectra[np.isfinite(spectra).all(axis=1)]
        bands = archive.wavelength.values
        unit = np.stack([np.interp(NM, bands, row) for row in np.eye(bands.size)])
        found.append(spectra @ np.stack(unit))
    return np.concatenate(found)


def largest_error(few, exact, reflectances):
    """Return the largest ΔE00 over reflectances at the exact rule's wavelengths."""
    at = np.searchsorted(exact.wavelengths, few.wavelengths)
    assert_array_equal(exact.wavelengths[at], few.wavelengths)
    lab = xyz_to_lab(few.xyz(reflectances[:, at]), exact.white[:, None])
    expected = xyz_to_lab(exact.xyz(reflectances), exact.white[:, None])
    return delta_e_2000(lab, expected).max()


# --- plain sums -------------------------------------------------------------------


@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("n", [1, 2, 16, 31, 61])
def test_bands_weigh_as_ever(observer, n):
    bands = np.linspace(410, 690, n)
    rule = band_rule(["D65", "FL11", MERCURY][: 2 if n == 1 else 3], bands, observer)
    for lamp, weights in zip(("D65", "FL11", MERCURY), rule.weights, strict=False):
        expected = xyz_weights(bands, illuminant_spd(lamp, bands), observer)
        assert_allclose(weights, expected, rtol=ROUNDING, atol=1e-300)


def test_bands_that_no_lamp_lights_are_left_out():
    rule = band_rule("546 nm", PAPER_WAVELENGTHS)
    assert_array_equal(rule.wavelengths, [545, 550])
    assert band_rule(["546 nm", "E"], PAPER_WAVELENGTHS).wavelengths.size == 61


def test_a_lamp_that_does_not_cover_the_bands_is_refused():
    lamp = Illuminant("lamp", [450, 600], [1, 1])
    with pytest.raises(ArgumentError, match=r"covers 450 to 600.*extrapolated"):
        band_rule(lamp, PAPER_WAVELENGTHS)
    with pytest.raises(ArgumentError, match="only lines"):
        band_rule("253.7 nm", PAPER_WAVELENGTHS)


# --- every nanometre and line -----------------------------------------------------


@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("lamp", ["D65", "A", "FL11", "LED-V1"])
def test_tables_are_summed_at_every_nanometre(lamp, observer):
    exact, plain = exact_rule(lamp, observer), band_rule(lamp, NM, observer)
    assert_array_equal(exact.wavelengths, plain.wavelengths)
    assert_allclose(exact.weights, plain.weights, rtol=ROUNDING, atol=1e-300)


@given(st.floats(380, 780))
def test_a_line_is_where_it_is(nm):
    rule = exact_rule(line_lamp([[nm, 3.0]]))
    assert_array_equal(rule.wavelengths, [nm])
    cmfs = colour_matching_functions([nm])
    assert_allclose(rule.xyz([0.25])[0], 0.25 * cmfs[0] / cmfs[0, 1], rtol=ROUNDING)


def test_two_lines_are_two_nodes():
    rule = exact_rule(line_lamp([[435.8, 0.3], [546.1, 1.0]]))
    y = colour_matching_functions([435.8, 546.1])[:, 1]
    assert_array_equal(rule.wavelengths, [435.8, 546.1])
    assert_allclose(rule.light[0], np.array([0.3, 1.0]) / (y @ [0.3, 1.0]))


def test_lines_add_to_a_table_by_their_power():
    lamp = with_lines(cie_illuminant("FL2"), [[546.0, 40.0], [578.1, 20.0]])
    rule, table = exact_rule(lamp), exact_rule("FL2")
    assert rule.wavelengths.size == 402  # 546 nm is the table's own
    assert (np.diff(rule.wavelengths) > 0).all()
    spd = cie_illuminant("FL2").spd(NM)
    seen = np.concatenate([spd, [40.0, 20.0]])
    cmfs = colour_matching_functions(NM)
    cmfs = np.concatenate([cmfs, colour_matching_functions([546.0, 578.1])])
    assert_allclose(rule.white[0], seen @ cmfs / (seen @ cmfs[:, 1]), rtol=ROUNDING)
    assert not np.allclose(rule.white, table.white, rtol=1e-3)


def test_lamps_share_one_list_of_nodes():
    short = Illuminant("short", [500, 600], [1, 2])
    rule = exact_rule(["D65", short, "632.8 nm"])
    assert rule.light.shape == (3, 402)
    assert_allclose(rule.white[:, 1], 1, rtol=ROUNDING)
    lit = rule.wavelengths[rule.light[1] > 0]
    assert_array_equal(lit, np.arange(500.0, 601))
    assert_array_equal(rule.wavelengths[rule.light[2] > 0], [632.8])
    for lamp, light in zip(("D65", short, "632.8 nm"), rule.light, strict=True):
        alone = exact_rule(lamp)
        assert_allclose(light[light > 0], alone.light[0], rtol=ROUNDING)


@pytest.mark.parametrize("step", [0.05, 0.3, 0.7])
def test_fine_tables_lose_nothing_between_nodes(step):
    nm = np.arange(400.0, 700.0 + step / 2, step)
    power = np.exp(-0.5 * ((nm - 555.37) / 0.4) ** 2) + 0.2
    lamp = Illuminant("peak", nm, power)
    dense = np.arange(400.0, nm[-1], 0.001)
    seen = np.interp(dense, nm, power)[:, None] * colour_matching_functions(dense)
    expected = seen.sum(axis=0) / seen[:, 1].sum()
    assert_allclose(exact_rule(lamp).white[0], expected, rtol=2e-4)


def test_a_narrow_table_tends_to_its_line():
    line = exact_rule("632.8 nm").white
    for width in (1.0, 0.1, 1e-3):
        nm = 632.8 + width * np.array([-1, 0, 1])
        white = exact_rule(Illuminant("laser", nm, [0, 1, 0])).white
        assert_allclose(white, line, rtol=0.03)  # a nanometre's worth of X


def test_a_table_of_one_wavelength_is_a_line():
    one = exact_rule(Illuminant("one", [589.3], [5.0]))
    assert_array_equal(one.wavelengths, [589.3])
    assert_allclose(one.white, exact_rule("589.3 nm").white, rtol=ROUNDING)


def test_a_dark_table_with_a_line_has_one_node():
    for nm in ([400, 700], [400, 400.5, 700]):
        lamp = Illuminant("lamp", nm, np.zeros(len(nm)), [[500.5, 1.0]])
        assert_array_equal(exact_rule(lamp).wavelengths, [500.5])


@pytest.mark.parametrize("kelvin", [100.0, 3000.0, 1e6])
def test_a_black_body_is_summed_as_smoothly(kelvin):
    exact, plain = exact_rule(black_body(kelvin)), band_rule(black_body(kelvin), NM)
    rtol = 0.01 if kelvin == 100 else 1e-4
    assert_allclose(exact.white, plain.white, rtol=rtol)


@pytest.mark.parametrize("unit", [1e-300, 1e-30, 1e30, 1e300])
def test_any_unit_of_power_will_do(unit):
    def lamp(unit):
        power = np.array([1.0, 3.0, 2.0]) * unit
        return Illuminant("lamp", [400, 500, 700], power, [[450.5, 7 * unit]])

    assert_allclose(
        exact_rule(lamp(unit)).weights, exact_rule(lamp(1.0)).weights, rtol=ROUNDING
    )


def test_limits_leave_out_the_rest():
    rule = exact_rule(["D65", MERCURY], limits=(420.5, 550))
    assert_array_equal(
        rule.wavelengths, np.sort([*np.arange(420.5, 550), 435.8, 546.1])
    )
    with pytest.raises(ArgumentError, match=r"632\.8 nm has no power where the"):
        exact_rule("632.8 nm", limits=(400, 600))
    with pytest.raises(ArgumentError, match="has no power where the observer"):
        exact_rule(["D65", Illuminant("infrared", [790, 1000], [1, 1])])


@pytest.mark.parametrize(
    "limits", [(300, 700), (400, 900), (700, 400), (400,), (np.nan, 700), "visible"]
)
def test_limits_that_are_none_are_refused(limits):
    with pytest.raises(ArgumentError, match="limits must be"):
        exact_rule("D65", limits=limits)


def test_some_lamp_is_needed():
    with pytest.raises(ArgumentError, match="at least one lamp"):
        exact_rule([])
    with pytest.raises(ArgumentError, match="at least one lamp"):
        band_rule([], NM)


# --- few nodes --------------------------------------------------------------------


@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("lamp", LAMPS)
def test_few_nodes_keep_the_colours_of_measured_skin(lamp, observer, skin, measured):
    exact = exact_rule(lamp, observer)
    seen = measured[:, np.isin(NM, exact.wavelengths)]
    training = skin(exact.wavelengths)
    found = {
        n: largest_error(quadrature_rule(exact, training, n), exact, seen)
        for n in (*BOUNDS, 40)
    }
    assert all(found[n] <= BOUNDS[n] for n in BOUNDS), found
    assert found[4] > found[8] > found[40]
    assert found[6] > found[10] > found[40]
    assert found[40] < 0.1


@pytest.mark.parametrize("lamp", ["FL2", "FL11", "LED-B3"])
def test_eight_nodes_are_better_than_sixteen_bands(lamp, skin, measured):
    exact = exact_rule(lamp)
    seen = measured[:, np.isin(NM, exact.wavelengths)]
    rule = quadrature_rule(exact, skin(exact.wavelengths), 8)
    bands = np.linspace(400, 700, 16)
    plain = band_rule(lamp, bands).xyz(measured[:, np.searchsorted(NM, bands)])
    labs = (xyz_to_lab(xyz, exact.white[0]) for xyz in (plain, exact.xyz(seen)))
    assert 5 * largest_error(rule, exact, seen) < delta_e_2000(*labs).max()


@pytest.mark.parametrize("lamp", LAMPS)
def test_few_nodes_keep_the_models_light_that_bounced(lamp, skin):
    exact = exact_rule(lamp)
    spectra = skin(exact.wavelengths)
    rule = quadrature_rule(exact, spectra, 12)
    assert largest_error(rule, exact, spectra) < 0.7
    at = np.searchsorted(exact.wavelengths, rule.wavelengths)
    once = exact.xyz(spectra**2)
    off = np.abs(rule.xyz(spectra[:, at] ** 2) - once) / exact.white[:, None]
    assert off.max() < 2e-3


@pytest.mark.parametrize("lamp", [*LAMPS, "100 K", "1000000 K", "LED-RGB1"])
@pytest.mark.parametrize("n", [1, 2, 3, 7, 8, 25, 60, 400])
def test_white_is_kept_by_weights_that_are_not_negative(lamp, n, skin):
    exact = exact_rule(lamp)
    rule = quadrature_rule(exact, skin(exact.wavelengths), n)
    assert 1 <= rule.wavelengths.size <= n
    assert (rule.colour >= 0).all()
    assert rule.colour.any(axis=1).all()
    assert_allclose(rule.white, exact.white, rtol=ROUNDING)
    assert np.isin(rule.wavelengths, exact.wavelengths).all()
    assert np.unique(rule.wavelengths).size == rule.wavelengths.size


@pytest.mark.parametrize("n", [4, 5, 100])
def test_lines_no_more_than_nodes_are_exact(n, skin):
    exact = exact_rule(MERCURY)
    rule = quadrature_rule(exact, skin(exact.wavelengths), n)
    assert_array_equal(rule.wavelengths, MERCURY.lines[:, 0])
    assert_allclose(rule.weights, exact.weights, rtol=ROUNDING)


def test_more_lines_than_nodes_are_chosen_from(skin):
    exact = exact_rule(MERCURY)
    spectra = skin(exact.wavelengths)
    rule = quadrature_rule(exact, spectra, 3)
    assert rule.wavelengths.size == 3
    assert largest_error(rule, exact, spectra) < 2


def test_a_lamp_without_blue_has_nodes(skin):
    exact = exact_rule(line_lamp([[600.0 + 10 * i, 1.0] for i in range(10)]))
    rule = quadrature_rule(exact, skin(exact.wavelengths), 5)
    assert_allclose(rule.white, exact.white, rtol=ROUNDING, atol=1e-300)


def test_each_lamp_has_nodes_of_its_own(skin):
    lamps = ["D65", "632.8 nm", "FL11", "D65"]
    exact = exact_rule(lamps)
    rule = quadrature_rule(exact, skin(exact.wavelengths), 8)
    assert_array_equal(rule.light[0], rule.light[3])
    assert set(np.unique(rule.light)) == {0.0, 1.0}
    # D65 twice, and it shares no node with the others.
    assert_array_equal(rule.light[:3].sum(axis=0), 1)
    assert (rule.light.sum(axis=1) <= 8).all()
    assert_allclose(rule.white, exact.white, rtol=ROUNDING, atol=1e-300)
    assert_array_equal(rule.wavelengths[rule.light[1] > 0], [632.8])
    seen = skin(exact.wavelengths)
    assert largest_error(rule, exact, seen) < 2


def test_the_same_lamp_has_the_same_nodes_each_time(skin):
    exact = exact_rule("D65")
    first, again = (
        quadrature_rule(exact, skin(exact.wavelengths), 8) for _ in range(2)
    )
    assert_array_equal(first.wavelengths, again.wavelengths)
    assert_array_equal(first.colour, again.colour)


@pytest.mark.parametrize(
    "spectra",
    [
        np.zeros((1, 401)),
        np.ones((3, 401)),
        np.full(401, 0.3),
        np.linspace(-0.01, 100, 401),
        np.full((2, 401), 1e-200),
    ],
    ids=["black", "white", "grey", "steep", "tiny"],
)
def test_any_training_gives_a_rule(spectra, strict_floats_but_underflow):
    exact = exact_rule("D65")
    rule = quadrature_rule(exact, spectra, 8)
    assert np.isfinite(rule.colour).all()
    assert_allclose(rule.white, exact.white, rtol=ROUNDING)


@pytest.fixture
def strict_floats_but_underflow():
    with np.errstate(all="raise", under="ignore"):
        yield


@pytest.mark.parametrize("limits", [(550, 551), (550, 560), (555, 555)])
def test_a_few_nanometres_have_a_rule(limits, skin):
    exact = exact_rule("D65", limits=limits)
    rule = quadrature_rule(exact, skin(exact.wavelengths), 5)
    assert_allclose(rule.white, exact.white, rtol=ROUNDING)


@pytest.mark.parametrize("n", [0, -1, 2.5, "8", True, None])
def test_numbers_of_nodes_that_are_none_are_refused(n):
    with pytest.raises(ArgumentError, match="n_nodes must be a whole number"):
        quadrature_rule(exact_rule("D65"), np.ones((1, 401)), n)


@pytest.mark.parametrize(
    "spectra",
    [
        np.ones((3, 400)),
        np.ones((0, 401)),
        np.ones((2, 2, 401)),
        np.full((1, 401), np.nan),
        np.full((1, 401), 1e30),
    ],
)
def test_spectra_that_are_no_training_are_refused(spectra):
    with pytest.raises(ArgumentError, match="reflectances must"):
        quadrature_rule(exact_rule("D65"), spectra, 8)


def test_a_rule_refuses_other_spectra():
    with pytest.raises(ArgumentError, match="reflectance must have the 401"):
        exact_rule("D65").xyz(np.ones(400))
