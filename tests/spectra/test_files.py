"""Spectral files: both layouts read alike, refusals say where, none half-written."""

import os
import re
import stat

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from spectra_tables import skin_like, spectra_cube, spectra_list

from skinviz import (
    ArgumentError,
    DataError,
    SkinvizError,
    load_archive,
    read_spectra,
    write_spectra,
)

DOWN = "wavelength_nm,A,B\n400,0.1,0.2\n500,0.3,0.4\n600,0.5,0.6\n"
ACROSS = "label,400,500,600\nA,0.1,0.3,0.5\nB,0.2,0.4,0.6\n"
VALUES = [[0.1, 0.3, 0.5], [0.2, 0.4, 0.6]]


@pytest.fixture
def written(tmp_path):
    """Return a function that writes text to a CSV file and returns its path."""

    def write(text, name="hand.csv"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


# --- reading -------------------------------------------------------------------


@pytest.mark.parametrize("text", [DOWN, ACROSS], ids=["down", "across"])
@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("end", ["\n", "\r\n"], ids=["unix", "windows"])
def test_both_layouts_and_all_marks_read_alike(written, text, mark, end):
    found = read_spectra(written(text.replace(",", mark).replace("\n", end)))
    assert found.reflectance.dims == ("record", "wavelength")
    assert_array_equal(found.reflectance, VALUES)
    assert_array_equal(found.wavelength, [400, 500, 600])
    assert found.label.values.tolist() == ["A", "B"]


def test_two_bare_columns_are_one_spectrum_named_after_its_file(written):
    found = read_spectra(written("400,0.1\n500,0.3\n600,0.5\n", "left hand.csv"))
    assert_array_equal(found.reflectance, VALUES[:1])
    assert found.label.values.tolist() == ["left hand"]


def test_across_joins_the_columns_of_words_into_a_label(written):
    text = "site,400,500,subject\ncheek,0.1,0.3,7\n,0.2,0.4,\n"
    found = read_spectra(written(text))
    assert found.label.values.tolist() == ["cheek 7", "line 3"]
    assert_array_equal(found.reflectance, [[0.1, 0.3], [0.2, 0.4]])


@pytest.mark.parametrize("head", ["wavelength", "Wavelength [nm]", "WAVELENGTH_NM"])
def test_any_heading_that_starts_with_wavelength_is_one(written, head):
    found = read_spectra(written(DOWN.replace("wavelength_nm", head)))
    assert_array_equal(found.reflectance, VALUES)


def test_spaces_blank_lines_and_a_byte_order_mark_do_not_matter(written):
    text = "\ufeff" + DOWN.replace(",", " , ").replace("\n", "\n\n")
    found = read_spectra(written(text))
    assert_array_equal(found.reflectance, VALUES)
    assert found.label.values.tolist() == ["A", "B"]


def test_numbers_as_labels_are_labels(written):
    found = read_spectra(written(DOWN.replace("A,B", "1,2")))
    assert found.label.values.tolist() == ["1", "2"]


def test_per_cent_is_declared(written):
    text = "wavelength_nm,A\n400,10\n500,30\n600,50\n"
    found = read_spectra(written(text), scale="percent")
    assert_allclose(found.reflectance, VALUES[:1], rtol=1e-15)


def test_notes_tell_how_it_was_measured(written):
    notes = "# Specular: included\n# geometry: d:8\n# operator: somebody\n# a remark\n"
    path = written(notes + DOWN)
    assert read_spectra(path).attrs == {
        "source": str(path),
        "specular": "included",
        "geometry": "d:8",
    }


@pytest.mark.parametrize("given", ["excluded", 0.03])
def test_a_caller_who_contradicts_the_notes_is_refused(written, given):
    path = written("# specular: included\n" + DOWN)
    with pytest.raises(DataError, match=rf"hand\.csv says .*included.*{given}"):
        read_spectra(path, specular=given)
    assert read_spectra(path, specular="included").attrs["specular"] == "included"


def test_without_notes_nothing_is_claimed(written):
    path = written(DOWN)
    assert read_spectra(path).attrs == {"source": str(path)}


# --- refusals ------------------------------------------------------------------

REFUSED = {
    "empty": ("", "the file is empty"),
    "only comments": ("# nothing\n\n# more\n", "only comments or blank lines"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\xff\xfe", "not a text file"),
    "header alone": ("wavelength_nm,A\n", "a header and no data"),
    "words": ("once,upon\na,time\n", "the layout is neither of"),
    "one column": ("400\n500\n", "the layout is neither of"),
    "NaN": (DOWN.replace("0.3", "nan"), r"spectrum 'A' at 500 nm: nan is not finite"),
    "infinity": (DOWN.replace("0.3", "inf"), r"'A' at 500 nm: inf is not finite"),
    "negative": (DOWN.replace("0.4", "-0.4"), r"'B' at 500 nm: -0.4 is negative"),
    "per cent": (DOWN.replace("0.6", "60"), r"'B' at 600 nm: 60 .*say --scale percent"),
    "descending": (
        "wavelength_nm,A\n500,0.1\n400,0.2\n",
        "must ascend; 400 nm follows 500 nm",
    ),
    "repeated": (
        "wavelength_nm,A\n500,0.1\n500,0.2\n",
        "must ascend; 500 nm follows 500 nm",
    ),
    "across descending": ("x,500,400\na,0.1,0.2\n", "400 nm follows 500 nm"),
    "micrometres": ("wavelength_um,A\n0.4,0.1\n0.5,0.2\n", "expected in nm"),
    "ragged": (DOWN.replace("500,0.3,0.4", "500,0.3"), "line 3: 2 cells where .* 3"),
    "ragged across": (ACROSS.replace("B,0.2", "B"), "line 3: 3 cells where .* has 4"),
    "no number": (DOWN.replace("0.3", "dark"), "line 3: expected a number.*'dark'"),
    "decimal comma": (
        "wavelength_nm;A\n400;0,1\n500;0,2\n",
        "line 2: expected a number, found '0,1'",
    ),
    "underscore": (DOWN.replace("0.3", "0.3_1"), "line 3: expected a number.*0.3_1"),
    "empty cell": (
        DOWN.replace("0.3", ""),
        "line 3: .* found an empty cell",
    ),
    "wavelength NaN": (DOWN.replace("500", "nan"), "line 3"),
    "open quotation": (DOWN.replace("B", '"B'), "quotation mark"),
    "misspelt note": ("# specular: include\n" + DOWN, "unknown specular.*included"),
    "no wavelength": (DOWN.replace("500", "green"), "line 3: expected a number"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_every_refusal_names_the_file_and_the_place(written, what):
    text, told = REFUSED[what]
    path = written(text)
    with pytest.raises(DataError, match=f"^{re.escape(str(path))}.*{told}"):
        read_spectra(path)


def test_fractions_called_per_cent_are_refused(written):
    with pytest.raises(DataError, match=r"every value is at most 1.*--scale fraction"):
        read_spectra(written(DOWN), scale="percent")


def test_too_much_per_cent_is_refused(written):
    text = "wavelength_nm,A\n400,10\n500,151\n"
    with pytest.raises(DataError, match="'A' at 500 nm: 151 is above 150 %"):
        read_spectra(written(text), scale="percent")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match=r"hand\.csv: no such file"):
        read_spectra(tmp_path / "hand.csv")


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(DataError, match="is a folder, a file is expected"):
        read_spectra(tmp_path)


def test_a_file_that_may_not_be_read_is_refused(written, monkeypatch):
    path = written(DOWN)

    # Root may read everything, so that its answers are made up here.
    def no_access(*_, **__):
        return False

    def forbidden(*_, **__):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("os.access", no_access)
    monkeypatch.setattr("pathlib.Path.read_text", forbidden)
    with pytest.raises(DataError, match=re.escape(str(path))):
        read_spectra(path)


def test_unknown_scale_lists_the_known(written):
    with pytest.raises(ArgumentError, match="choose one of: fraction, percent"):
        read_spectra(written(DOWN), scale="%")


@pytest.mark.parametrize("wrong", ["sometimes", 0.9, -1.0])
def test_specular_that_no_model_knows_is_refused(written, wrong):
    with pytest.raises(SkinvizError, match="specular"):
        read_spectra(written(DOWN), specular=wrong)


# --- there and back ------------------------------------------------------------


@given(
    values=st.lists(
        st.lists(st.floats(0, 1.5), min_size=3, max_size=3), min_size=1, max_size=4
    )
)
def test_what_is_written_is_read(values, tmp_path_factory):
    path = tmp_path_factory.mktemp("spectra") / "hand.csv"
    spectra = spectra_list(values, specular="included", geometry="d:8")
    found = read_spectra(write_spectra(path, spectra))
    assert_array_equal(found.reflectance, values)
    assert_array_equal(found.wavelength, spectra.wavelength)
    assert_array_equal(found.label, spectra.label)
    assert found.attrs == {**spectra.attrs, "source": str(path)}


@pytest.mark.parametrize(
    "label", ["left, right", "a;b", 'the "best"', "#1", "Ä/β", "7", "nan"]
)
def test_labels_come_back_as_they_were(tmp_path, label):
    path = write_spectra(tmp_path / "hand.csv", spectra_list([[0.1, 0.2]], [label]))
    assert read_spectra(path).label.values.tolist() == [label]


def test_wavelengths_come_back_as_they_were(tmp_path):
    nm = np.array([400.123456, 500.0, 632.8, 632.8001, 1064.4444])
    spectra = spectra_list([[0.1, 0.2, 0.3, 0.4, 0.5]], nm=nm)
    found = read_spectra(write_spectra(tmp_path / "hand.csv", spectra))
    assert_array_equal(found.wavelength, nm)


def test_a_number_for_the_surface_comes_back_as_a_number(tmp_path):
    path = write_spectra(
        tmp_path / "hand.csv", spectra_list([[0.1, 0.2]], specular=0.03)
    )
    assert read_spectra(path).attrs["specular"] == 0.03


def test_spectra_without_labels_are_refused(tmp_path):
    with pytest.raises(ArgumentError, match="label"):
        write_spectra(tmp_path / "nist.csv", load_archive("nist"))
    assert not list(tmp_path.iterdir())


def test_missing_bands_cannot_be_written_and_lost(tmp_path):
    """What would be refused when read is refused when written."""
    path = tmp_path / "hand.csv"
    with pytest.raises(SkinvizError, match=r"finite|NaN|missing"):
        write_spectra(path, spectra_list([[0.1, np.nan]]))
    assert not path.exists()


# --- written whole or not at all -----------------------------------------------


def test_a_folder_is_made_and_nothing_is_left_beside(tmp_path):
    path = write_spectra(tmp_path / "new" / "hand.csv", spectra_list([[0.1, 0.2]]))
    assert [p.name for p in path.parent.iterdir()] == ["hand.csv"]


def test_a_written_file_has_the_users_own_rights(tmp_path):
    mask = os.umask(0o027)
    try:
        path = write_spectra(tmp_path / "hand.csv", spectra_list([[0.1, 0.2]]))
    finally:
        os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


class Unprintable:
    """A label that fails in the middle of writing."""

    def __str__(self):
        raise OSError(28, "No space left on device")


def test_a_failure_leaves_the_old_file_and_no_other(tmp_path):
    path = tmp_path / "hand.csv"
    path.write_text("precious")
    spectra = spectra_list([[0.1, 0.2]])
    spectra["label"] = ("record", np.array([Unprintable()], dtype=object))
    with pytest.raises(SkinvizError, match=re.escape(f"cannot write {path}")):
        write_spectra(path, spectra)
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]


def test_an_unknown_suffix_lists_the_known(tmp_path, written):
    known = r"\.csv, \.tsv, \.spdx, \.cgats, \.txt, \.nc, \.hdr; '\.xlsx' is none"
    with pytest.raises(ArgumentError, match=known):
        write_spectra(tmp_path / "hand.xlsx", spectra_list([[0.1, 0.2]]))
    assert not list(tmp_path.iterdir())
    with pytest.raises(DataError, match=known):
        read_spectra(written(DOWN, "hand.xlsx"))
    with pytest.raises(DataError, match="'no suffix' is none"):
        read_spectra(written(DOWN, "hand"))


def test_a_place_that_is_no_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(SkinvizError, match="cannot write"):
        write_spectra(tmp_path / "file" / "hand.csv", spectra_list([[0.1, 0.2]]))


# --- scale and kind, alike in all formats --------------------------------------


@pytest.mark.parametrize("given", [None, "percent"])
def test_a_note_declares_the_scale(written, given):
    path = written("# Scale: percent\nwavelength_nm,A\n400,10\n500,30\n600,50\n")
    assert_allclose(read_spectra(path, scale=given).reflectance, VALUES[:1], rtol=1e-15)


def test_a_caller_who_contradicts_the_scale_is_refused(written):
    path = written("# scale: percent\nwavelength_nm,A\n400,10\n500,30\n")
    with pytest.raises(DataError, match=r"says .* written as 100, and .* it is 1 was"):
        read_spectra(path, scale="fraction")


def test_a_misspelt_scale_in_the_file_is_refused(written):
    with pytest.raises(DataError, match="unknown scale 'perc'; choose one of: frac"):
        read_spectra(written("# scale: perc\n" + DOWN))


def test_a_declared_scale_that_cannot_be_is_refused(written):
    with pytest.raises(DataError, match=r"at most 1.*correct the scale in the file"):
        read_spectra(written("# scale: percent\n" + DOWN))
    with pytest.raises(DataError, match=r"60 is above 1.5, and the file declares 0"):
        read_spectra(written("# scale: fraction\n" + DOWN.replace("0.6", "60")))


def test_tabs_are_written_where_the_suffix_says_so(tmp_path):
    path = write_spectra(tmp_path / "hand.tsv", spectra_list(VALUES, ["A, B", "C"]))
    assert "wavelength_nm\tA, B\tC\n" in path.read_text()
    assert_array_equal(read_spectra(path).reflectance, VALUES)


@pytest.mark.parametrize("suffix", [".csv", ".tsv", ".spdx", ".cgats", ".txt"])
def test_text_cannot_hold_cubes_or_missing_bands(tmp_path, suffix):
    path = tmp_path / f"hand{suffix}"
    with pytest.raises(ArgumentError, match=r"cannot hold a cube; write \.hdr or \.nc"):
        write_spectra(path, spectra_cube(skin_like(2, 2, 3)))
    with pytest.raises(ArgumentError, match=r"missing bands.*drop .* or write \.nc"):
        write_spectra(path, spectra_list([[0.1, np.nan, 0.2]]))
    assert not list(tmp_path.iterdir())


REFUSED_TO_WRITE = {
    "text": ("spectra", "spectra need reflectance"),
    "no reflectance": (
        spectra_list(VALUES).rename(reflectance="r"),
        "need reflectance",
    ),
    "an array": (spectra_list(VALUES).reflectance, "need reflectance"),
    "no wavelength": (spectra_list(VALUES).drop_vars("wavelength"), "wavelength and"),
    "other dims": (spectra_list(VALUES).rename(record="x"), r"\(record, wavelength\)"),
    "none": (spectra_list(VALUES).isel(record=[]), "no spectra to write"),
    "no bands": (spectra_list(VALUES).isel(wavelength=[]), "no spectra to write"),
    "negative": (spectra_list([[0.1, -0.2]]), "number 1.*400|410 nm: -0.2 is negative"),
    "per cent": (spectra_list([[10.0, 20.0]]), "10 is above 1.5; .* 0 to 1"),
    "infinite": (spectra_list([[0.1, np.inf]]), "finite|missing"),
    "words": (spectra_list([["a", "b"]]), "expected real numbers"),
    "complex": (spectra_list([[0.1j, 0.2]]), "expected real numbers"),
    "descending": (spectra_list(VALUES, nm=[500, 400, 300]), "must ascend"),
    "micrometres": (spectra_list(VALUES, nm=[0.4, 0.5, 0.6]), "expected in nm"),
    "NaN nm": (spectra_list(VALUES, nm=[400, np.nan, 500]), "not a finite number"),
}


@pytest.mark.parametrize("suffix", [".csv", ".cgats", ".nc"])
@pytest.mark.parametrize("what", REFUSED_TO_WRITE)
def test_what_reading_would_refuse_is_not_written(tmp_path, what, suffix):
    spectra, told = REFUSED_TO_WRITE[what]
    with pytest.raises(ArgumentError, match=told):
        write_spectra(tmp_path / f"hand{suffix}", spectra)
    assert not list(tmp_path.iterdir())


def test_reflectance_in_per_cent_is_not_written_as_fractions(tmp_path):
    spectra = spectra_list(VALUES)
    spectra.reflectance.attrs["units"] = "%"
    with pytest.raises(ArgumentError, match="in '%'; expected"):
        write_spectra(tmp_path / "hand.csv", spectra)


@pytest.mark.parametrize("suffix", [".csv", ".tsv", ".spdx", ".cgats", ".txt"])
@pytest.mark.parametrize("mark", ["\n", "\r", "\u2028", "\x00", "\x85", "\ud800"])
def test_no_label_or_note_breaks_a_line(tmp_path, suffix, mark):
    """It would come back as data, or not at all."""
    path = tmp_path / f"hand{suffix}"
    with pytest.raises(ArgumentError, match=r"label .* line break or control"):
        write_spectra(path, spectra_list([[0.1, 0.2]], [f"a{mark}b"]))
    with pytest.raises(ArgumentError, match=r"attribute geometry .* line break"):
        write_spectra(path, spectra_list([[0.1, 0.2]], geometry=f"0{mark}500,9"))
    assert not list(tmp_path.iterdir())
