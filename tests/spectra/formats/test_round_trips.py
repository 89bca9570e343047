"""What is written is read to the last digit, or was refused; netCDF has its own."""

import numpy as np
import pytest
import xarray
from hypothesis import example, given, settings
from hypothesis import strategies as st
from spectra_tables import skin_like, spectra_list

from skinviz import ArgumentError, read_spectra, write_spectra
from skinviz.spectra.formats import FORMATS
from skinviz.spectra.formats.raw import LIST

LISTS = [suffix for suffix, form in FORMATS.items() if LIST in form.KINDS]


@st.composite
def spectra(draw):
    """Return one spectrum, whatever a user may have in it."""
    nm = draw(st.lists(st.floats(100, 5000), min_size=1, max_size=5, unique=True))
    values = draw(
        st.lists(st.floats(0, 1.5), min_size=len(nm), max_size=len(nm)),
    )
    attributes = draw(
        st.fixed_dictionaries(
            {},
            optional={
                "specular": st.sampled_from(["included", "excluded", 0.0, 0.03, 0.5]),
                "geometry": st.sampled_from(["45x:0", "di:8", "d:d", "45/0", "a # b"]),
                "comment": st.sampled_from(["a: b", 'say "a"', "<a> & b", "1,2;3"]),
            },
        )
    )
    return spectra_list([values], [draw(st.text(max_size=6))], sorted(nm), **attributes)


@pytest.mark.parametrize("suffix", [".csv", ".spdx", ".cgats"])
@settings(max_examples=50)
@example(data=spectra_list([[0.1]], ["None"], [400]))
@example(data=spectra_list([[0.1]], [" "], [400]))
@example(data=spectra_list([[0.1]], [""], [400]))
@example(data=spectra_list([[0.1]], ["a  b"], [400]))
@example(data=spectra_list([[0.1]], ["a"], [400], comment="specular: 0.5"))
@given(data=spectra())
def test_what_is_written_is_read_or_refused(tmp_path_factory, suffix, data):
    path = tmp_path_factory.mktemp("spectra") / f"hand{suffix}"
    try:
        write_spectra(path, data)
    except ArgumentError:
        label, comment = data.label.values[0], data.attrs.get("comment", "")
        plain = label.isprintable() and label.isascii() and label == label.strip()
        assert not plain or label in ("", "None") or comment.startswith("specular")
        assert not path.exists()
        return
    found = read_spectra(path)
    xarray.testing.assert_identical(
        found.drop_attrs(deep=False), data.drop_attrs(deep=False)
    )
    attributes = {k: v for k, v in found.attrs.items() if k in data.attrs}
    assert attributes == data.attrs


def test_a_file_goes_through_every_format_and_comes_back(tmp_path):
    first = spectra_list(
        skin_like(1, 31),
        ["left hand"],
        specular="included",
        geometry="d/8",
        instrument="CM-700d",
        date="2024-05-06",
        comment="third of three",
    )
    found = first
    for suffix in [*LISTS, *reversed(LISTS)]:
        found = read_spectra(write_spectra(tmp_path / f"hand{suffix}", found))
    xarray.testing.assert_identical(
        found.drop_attrs(deep=False), first.drop_attrs(deep=False)
    )
    assert {k: v for k, v in found.attrs.items() if k != "source"} == first.attrs


def test_a_long_list_is_read_fast_enough_to_be_used(tmp_path):
    """Each spectrum of a list is some lines of text: no step may be quadratic."""
    many = spectra_list(skin_like(2000, 36), np.arange(2000).astype(str))
    for suffix in (".csv", ".cgats", ".nc"):
        found = read_spectra(write_spectra(tmp_path / f"many{suffix}", many))
        xarray.testing.assert_equal(found, many)
