"""The coefficient tables follow from their formulas, and the blood is blood."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import TABLE

from skinviz import ArgumentError, DataError, skin_model
from skinviz.skin.coefficients import (
    COEFFICIENT_SETS,
    body_sites,
    layer_thickness,
    load_coefficients,
)

TABLE_I = {
    "cheek": ("Cheek", 0.027, 1.491),
    "back of hand": ("Back of hand", 0.035, 1.190),
    "outer arm": ("Outside of arm", 0.036, 1.403),
    "inner arm": ("Inside of arm", 0.041, 1.294),
}
"""The paper's Table I, by the archives' names: (its name, epidermis, dermis). [mm]"""

ISOSBESTIC = (390, 422, 452, 500, 529, 545, 570, 584)
"""Of human haemoglobin, Zijlstra, Buursma & van Assendelft 2000. [nm]"""


def test_effective_set_follows_from_its_five_numbers():
    found = load_coefficients("effective")
    x = found.wavelengths / 500
    assert_allclose(found.melanin, 2 * 51.9 * x**-1.88, rtol=TABLE)
    assert_allclose(found.epidermis, 2.14 * x**-1.27, rtol=TABLE)
    dermis = 6.41 * (0.46 * x**-4 + 0.54 * x**-1.27)
    assert_allclose(found.dermis, dermis, rtol=TABLE)


def test_textbook_set_is_twice_absorption_and_three_quarters_of_scattering():
    found = load_coefficients("textbook")
    nm, x = found.wavelengths, found.wavelengths / 500
    assert_allclose(found.melanin, 2 * 6.6e10 * nm**-3.33, rtol=TABLE)
    epidermis = 6.67 * (0.29 * x**-4 + 0.71 * x**-0.689)  # Jacques 2013, μ_s′ [mm⁻¹]
    dermis = 4.36 * (0.41 * x**-4 + 0.59 * x**-0.562)
    assert_allclose(found.epidermis, 0.75 * epidermis, rtol=TABLE)
    assert_allclose(found.dermis, 0.75 * dermis, rtol=TABLE)


def test_both_sets_have_one_blood():
    first, second = (load_coefficients(name) for name in COEFFICIENT_SETS)
    assert_array_equal(first.oxyhaemoglobin, second.oxyhaemoglobin)
    assert_array_equal(first.deoxyhaemoglobin, second.deoxyhaemoglobin)


def test_oxygen_makes_no_difference_at_the_isosbestic_points():
    blood = load_coefficients()
    visible = blood.wavelengths <= 700
    nm = blood.wavelengths[visible]
    apart = (blood.oxyhaemoglobin - blood.deoxyhaemoglobin)[visible]
    i = np.flatnonzero(np.sign(apart[1:]) != np.sign(apart[:-1]))
    crossings = nm[i] + 5 * apart[i] / (apart[i] - apart[i + 1])
    # Whole blood at 5 nm, 98 % oxygenated: some nm from pure haemoglobin's.
    assert_allclose(crossings, ISOSBESTIC, rtol=0, atol=7)


def test_oxygenated_blood_is_the_redder():
    blood = load_coefficients().at([660.0])
    assert blood.deoxyhaemoglobin > 5 * blood.oxyhaemoglobin


@pytest.mark.parametrize("name", COEFFICIENT_SETS)
def test_every_coefficient_is_positive_on_380_to_780(name):
    found = load_coefficients(name)
    assert_array_equal(found.wavelengths, np.arange(380, 781, 5))
    for column in ("melanin", "oxyhaemoglobin", "deoxyhaemoglobin"):
        assert (getattr(found, column) > 0).all()
    assert (found.epidermis > 0).all()
    assert (found.dermis > 0).all()


def test_tables_cannot_be_changed_in_place():
    with pytest.raises(ValueError, match="read-only"):
        load_coefficients().melanin[0] = 0


def test_resampling_keeps_the_nodes_and_halves_between():
    table = load_coefficients()
    assert_array_equal(table.at(table.wavelengths).dermis, table.dermis)
    middle = table.at((table.wavelengths[1:] + table.wavelengths[:-1]) / 2)
    assert_allclose(middle.melanin, (table.melanin[1:] + table.melanin[:-1]) / 2)


@pytest.mark.parametrize("nm", [[379.9, 500.0], [500.0, 780.1], [900.0]])
def test_resampling_never_extrapolates(nm):
    with pytest.raises(ArgumentError, match=r"'effective' coefficients covers 380 to"):
        load_coefficients().at(nm)


def test_unknown_set_lists_the_known():
    with pytest.raises(ArgumentError, match="effective, textbook; did you mean"):
        load_coefficients("efective")


@pytest.mark.parametrize("site", TABLE_I)
def test_thickness_is_table_i_under_both_names(site):
    paper, *expected = TABLE_I[site]
    assert layer_thickness(site) == tuple(expected)
    assert layer_thickness(paper) == tuple(expected)
    assert layer_thickness(site.upper()) == tuple(expected)


def test_sites_are_the_archives_own_names():
    assert body_sites() == tuple(TABLE_I)


def test_unknown_site_lists_the_known():
    with pytest.raises(ArgumentError, match="cheek, back of hand, outer arm, inner"):
        layer_thickness("knee")


HEADER = "wavelength_nm,K_m_mm1,K_h_mm1,K_dh_mm1,S_e_mm1,S_d_mm1\n"


def test_a_table_of_ones_own_is_read_and_used(tmp_path):
    at = load_coefficients("textbook")
    columns = (at.melanin, at.oxyhaemoglobin, at.deoxyhaemoglobin, at.epidermis)
    rows = zip(at.wavelengths, *columns, at.dermis, strict=True)
    file = tmp_path / "mine.csv"
    lines = [",".join(repr(float(x)) for x in row) for row in rows]
    file.write_text(HEADER + "\n".join(lines))
    own = load_coefficients(file)
    assert own.name == str(file)
    assert_array_equal(own.dermis, at.dermis)
    options = {"site": "cheek", "specular": "included"}
    nm = np.arange(400.0, 701.0, 50.0)
    expected = skin_model(coefficients="textbook", **options)
    for given in (file, str(file), own):
        skin = skin_model(coefficients=given, **options)
        values = [0.1, 0.01, 0.005]
        assert_array_equal(skin.measured(values, nm), expected.measured(values, nm))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("nm,K\n500,1\n", "line 1: a coefficient table has the header wavelength_nm"),
        (HEADER, "a header and no coefficients"),
        (HEADER + "500,1,2,3,4\n", "line 2: 6 numbers from 0 to 1e.16"),
        (HEADER + "500,1,2,-3,4,5\n", "line 2: 6 numbers from 0"),
        (HEADER + "500,1,2,nan,4,5\n", "line 2: 6 numbers from 0"),
        (HEADER + "500,1,2,x,4,5\n", "line 2: could not convert string to float: 'x'"),
        (HEADER + "500,1,2,3,4,5\n500,1,2,3,4,5\n", "strictly ascending"),
    ],
)
def test_a_broken_table_is_refused_by_line(tmp_path, content, message):
    file = tmp_path / "mine.csv"
    file.write_text(content)
    with pytest.raises(DataError, match=message):
        load_coefficients(file)


def test_a_table_that_is_missing_or_no_text_is_refused(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        load_coefficients(tmp_path / "none.csv")
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DataError, match="not a text file"):
        load_coefficients(tmp_path / "bytes.csv")
