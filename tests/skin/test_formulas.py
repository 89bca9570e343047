"""The shipped tables are what the formulas and the numbers give, to the letter."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import ROUNDING, TABLE

from skinviz import ArgumentError
from skinviz.skin.coefficients import load_coefficients
from skinviz.skin.formulas import (
    TABLE_WAVELENGTHS,
    blood_absorption,
    effective_coefficients,
    effective_data,
    effective_numbers,
    table_text,
    textbook_coefficients,
)

DATA = files("skinviz.skin") / "data"


def _shipped(name):
    return (DATA / name).read_bytes().decode("utf-8")


def test_the_effective_table_is_written_from_its_numbers_to_the_last_digit():
    assert table_text(effective_coefficients(effective_numbers())) == _shipped(
        "effective.csv"
    )


def test_the_textbook_table_is_written_from_its_formulas_to_the_last_digit():
    assert table_text(textbook_coefficients()) == _shipped("textbook.csv")


@pytest.mark.parametrize("name", ["effective", "textbook"])
def test_rounding_costs_half_a_unit_of_the_sixth_digit(name):
    exact = (
        textbook_coefficients()
        if name == "textbook"
        else effective_coefficients(effective_numbers())
    )
    found = load_coefficients(name)
    for column in ("melanin", "oxyhaemoglobin", "epidermis", "dermis"):
        assert_allclose(getattr(found, column), getattr(exact, column), rtol=TABLE)


def test_another_number_gives_another_table():
    numbers = effective_numbers()
    changed = effective_coefficients(replace(numbers, melanin_slope=3.0))
    base = effective_coefficients(numbers)
    i = np.flatnonzero(TABLE_WAVELENGTHS == 500)
    assert_array_equal(changed.melanin[i], base.melanin[i])  # the reference
    ratio = changed.melanin / base.melanin
    expected = (TABLE_WAVELENGTHS / 500) ** -(3.0 - numbers.melanin_slope)
    assert_allclose(ratio, expected, rtol=ROUNDING)
    assert_array_equal(changed.dermis, base.dermis)


def test_a_dermis_of_rayleigh_scatterers_alone_falls_with_the_fourth_power():
    numbers = replace(effective_numbers(), rayleigh_share=1.0)
    x = TABLE_WAVELENGTHS / 500
    found = effective_coefficients(numbers).dermis
    assert_allclose(found, numbers.dermis_scattering * x**-4, rtol=ROUNDING)


def test_blood_keeps_the_sources_own_values():
    source = np.genfromtxt(
        _shipped("blood.csv").splitlines(), delimiter=",", skip_header=1
    )
    assert source.shape == (154, 3)
    assert_array_equal(blood_absorption(source[:, 0]), source[:, 1:].T)


def test_blood_is_not_extrapolated():
    with pytest.raises(ArgumentError, match="blood table covers 370 to 790 nm"):
        blood_absorption(np.array([365.0, 500.0]))


def test_every_number_says_its_unit_its_meaning_and_where_its_prior_is_from():
    data = effective_data()
    for name in effective_numbers().__dataclass_fields__:
        assert data[name]["unit"] in ("1", "mm⁻¹")
        assert data[name]["prior"]["scale"] in ("linear", "log")
        assert data[name]["prior"]["deviation"] > 0
        assert len(data[name]["meaning"]) > 20
        assert len(data[name]["source"]) > 20
