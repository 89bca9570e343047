"""The words for how a spectrum was measured are one small vocabulary."""

import numpy as np
import pytest

from skinviz import ArgumentError
from skinviz.spectra.measurement import EXCLUDED, INCLUDED, as_specular


@pytest.mark.parametrize("word", [EXCLUDED, INCLUDED])
def test_the_two_words_stand_for_themselves(word):
    assert as_specular(word) == word


@pytest.mark.parametrize("number", [0, 0.03, 0.5, np.float32(0.25), "0.03", "0"])
def test_a_number_is_a_float_from_text_too(number):
    found = as_specular(number)
    assert isinstance(found, float)
    assert found == float(number)


@pytest.mark.parametrize("wrong", [-0.01, 0.51, np.nan, np.inf, "nan", "inf", "-1"])
def test_numbers_that_are_no_reflectance_are_refused(wrong):
    with pytest.raises(ArgumentError, match=r"specular must be in \[0, 0.5\]"):
        as_specular(wrong)


@pytest.mark.parametrize("wrong", [None, True, [0.03], ()])
def test_what_is_neither_word_nor_number_is_refused(wrong):
    with pytest.raises(ArgumentError, match="specular must be a number"):
        as_specular(wrong)


@pytest.mark.parametrize(("wrong", "near"), [("include", "included"), ("", None)])
def test_other_words_list_the_known(wrong, near):
    hint = f"; did you mean '{near}'" if near else ""
    told = f"choose one of: excluded, included{hint}"
    with pytest.raises(ArgumentError, match=told):
        as_specular(wrong)
