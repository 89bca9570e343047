"""CGATS text: what instruments write is read, and the scale is never guessed."""

import re

import numpy as np
import pytest
import xarray
from numpy.testing import assert_array_equal
from spectra_tables import skin_like, spectra_list

from skinviz import DataError, read_spectra, write_spectra

I1 = """CGATS.17
ORIGINATOR "i1Profiler"
FILE_DESCRIPTOR	"Measurement data: ""hand"" # 3"
CREATED "2024-05-06"
INSTRUMENTATION "i1 Pro 2; Serial number 1001"
MEASUREMENT_GEOMETRY "45/0"
NUMBER_OF_FIELDS 6
BEGIN_DATA_FORMAT
SAMPLE_ID SAMPLE_NAME RGB_R SPECTRAL_NM400 SPECTRAL_NM410 SPECTRAL_NM420
END_DATA_FORMAT
NUMBER_OF_SETS 2
BEGIN_DATA
1	"left hand"	255.0	0.1	0.3	0.5
2	B1	0	0.2	0.4	0.6
END_DATA
"""
VALUES = [[0.1, 0.3, 0.5], [0.2, 0.4, 0.6]]
ARGYLL = """CTI3

DESCRIPTOR "Argyll Calibration Target chart information 3"
# a remark with a " in it
KEYWORD "DEVICE_CLASS"
DEVICE_CLASS "OUTPUT"
SPECTRAL_BANDS "4"
SPECTRAL_START_NM "380.000000"
SPECTRAL_END_NM "390.000000"
SPECTRAL_NORM "100.000000"
NUMBER_OF_FIELDS 5
BEGIN_DATA_FORMAT
SAMPLE_ID SPEC_380 SPEC_383 SPEC_387 SPEC_390
END_DATA_FORMAT
NUMBER_OF_SETS 1
BEGIN_DATA
A1 10 30 50 60
END_DATA
"""
PAIRED = """CGATS.17
BEGIN_DATA_FORMAT
SAMPLE_ID SPECTRAL_NM SPECTRAL_PCT SPECTRAL_NM SPECTRAL_PCT
END_DATA_FORMAT
BEGIN_DATA
a 400 10 500 20
b 400 30 500 40
END_DATA
"""


@pytest.fixture
def written(tmp_path):
    """Return a function that writes text to a file and returns its path."""

    def write(text, name="hand.cgats"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def fraction(path):
    """Return the spectra of a file that does not state its scale."""
    return read_spectra(path, scale="fraction")


@pytest.mark.parametrize("suffix", [".txt", ".cgats", ".TXT"])
def test_an_instruments_export_is_read(written, suffix):
    path = written(I1, f"hand{suffix}")
    found = fraction(path)
    assert_array_equal(found.reflectance, VALUES)
    assert_array_equal(found.wavelength, [400, 410, 420])
    assert found.label.values.tolist() == ["left hand", "B1"]
    assert found.attrs == {
        "source": str(path),
        "geometry": "45/0",
        "instrument": "i1 Pro 2; Serial number 1001",
        "date": "2024-05-06",
        "comment": 'Measurement data: "hand" # 3',
    }


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["unix", "windows", "mac"])
@pytest.mark.parametrize("start", ["", "\ufeff"], ids=["plain", "mark"])
def test_line_ends_and_a_byte_order_mark_do_not_matter(written, end, start):
    assert_array_equal(
        fraction(written(start + I1.replace("\n", end))).reflectance, VALUES
    )


@pytest.mark.parametrize(
    "name",
    [
        *("nm{}", "NM{}", "NM_{}", "SPECTRAL_NM_{}", "SPECTRAL_{}", "SPEC_{}"),
        *("R_{}", "{}_NM", "nm{}.0"),
    ],
)
def test_every_name_that_instruments_give_to_bands(written, name):
    text = re.sub(r"SPECTRAL_NM(\d+)", lambda found: name.format(found[1]), I1)
    found = fraction(written(text))
    assert_array_equal(found.reflectance, VALUES)
    assert_array_equal(found.wavelength, [400, 410, 420])


def test_format_lines_may_be_broken_and_names_may_be_missing(written):
    text = I1.replace("SAMPLE_ID SAMPLE_NAME RGB_R ", "CMYK_C\nCMYK_M CMYK_Y\n")
    assert fraction(written(text)).label.values.tolist() == ["line 15", "line 16"]


def test_windows_letters_are_read(written):
    text = I1.replace("left hand", "Rücken").encode("cp1252")
    assert fraction(written(text)).label.values[0] == "Rücken"


# --- the scale -----------------------------------------------------------------


def test_a_file_that_does_not_say_its_scale_must_be_told(written):
    with pytest.raises(DataError, match=r"0-1 or 0-100.* say --scale fraction or"):
        read_spectra(written(I1))


@pytest.mark.parametrize(
    "said",
    [
        "SPECTRAL_NORM 100",
        'SPECTRAL_NORM "100.0"',
        "# scale: percent",
        "#Scale:percent",
    ],
)
def test_each_way_to_declare_per_cent(written, said):
    text = I1.replace(" 0.", " ").replace("\t0.", "\t").replace("ORIG", f"{said}\nORIG")
    found = read_spectra(written(text))
    assert_array_equal(found.reflectance, np.array(VALUES) / 10)
    with pytest.raises(DataError, match=r"is written as 100, and .* it is 1 was given"):
        fraction(written(text))


def test_rounded_names_are_made_exact_by_the_keywords(written):
    found = read_spectra(written(ARGYLL))
    assert_array_equal(found.wavelength, np.linspace(380, 390, 4))
    assert_array_equal(found.reflectance, [[0.1, 0.3, 0.5, 0.6]])


@pytest.mark.parametrize(("kind", "full"), [("PCT", 100), ("DEC", 1)])
def test_the_standards_own_pairs_say_their_scale(written, kind, full):
    text = PAIRED.replace("PCT", kind)
    text = re.sub(r"\b([1-4]0)\b", lambda v: str(int(v[0]) / 100 * full), text)
    found = read_spectra(written(text))
    assert_array_equal(found.wavelength, [400, 500])
    assert_array_equal(found.reflectance, [[0.1, 0.2], [0.3, 0.4]])


# --- there and back, and another reader ----------------------------------------

SPECTRA = spectra_list(
    skin_like(3, 4),
    ["left hand", 'the "best"', "Ä#/β"],
    [400, 410.5, 555.123456789, 700],
    specular="included",
    geometry="d/8",
    instrument="CM-700d",
    date="2024-05-06",
    comment="third # of 'three'",
)


@pytest.mark.parametrize(
    "nm", [[400.0, 410.5, 555.123456789, 700], [400.0, 410, 420, 430]]
)
def test_what_is_written_is_read(tmp_path, nm):
    spectra = SPECTRA.assign_coords(wavelength=("wavelength", nm, {"units": "nm"}))
    path = write_spectra(tmp_path / "hand.cgats", spectra)
    expected = spectra.assign_attrs(source=str(path))
    xarray.testing.assert_identical(read_spectra(path), expected)


def test_colour_science_reads_what_we_write(tmp_path, colour):
    nm = np.arange(400.0, 701, 10)
    spectra = spectra_list(skin_like(3, nm.size), ["a", "b", "c"], nm)
    path = write_spectra(tmp_path / "hand.txt", spectra)
    found = colour.read_sds_from_xrite_file(str(path))
    assert list(found) == ['"a"', '"b"', '"c"']  # it keeps the quotation marks
    for sd, row in zip(found.values(), spectra.reflectance.values, strict=True):
        assert_array_equal(sd.wavelengths, nm)
        assert_array_equal(sd.values, row)


# --- refusals ------------------------------------------------------------------

REFUSED = {
    "a table": ("wavelength,A\n400,0.1\n", r"no CGATS text; .* name it \.csv"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\xff\xfe", "not a text file; expected CGATS"),
    "cut off": (
        I1.replace("END_DATA\n", ""),
        "END_DATA is missing; the file is cut off",
    ),
    "cut off in a row": (I1[: I1.index("0.6")], "END_DATA is missing"),
    "cut off format": (I1.replace("END_DATA_FORMAT", ""), "END_DATA_FORMAT is missing"),
    "lost row": (
        I1.replace("2\tB1\t0\t0.2\t0.4\t0.6\n", ""),
        "NUMBER_OF_SETS is 2 and 1",
    ),
    "lost field": (I1.replace(" RGB_R", ""), "line 13: 6 values where .* has 5 fields"),
    "wrong count": (I1.replace("FIELDS 6", "FIELDS 7"), "NUMBER_OF_FIELDS is 7 and 6"),
    "no rows": (re.sub(r"(?m)^[12]\t.*\n", "", I1), "no data between BEGIN_DATA"),
    "open quotation": (I1.replace('hand"\t', "hand\t"), "line 13: a quotation mark"),
    "unquoted": (I1.replace('"left hand"', "left hand"), "names with spaces in quot"),
    "word": (I1.replace("0.3", "dark"), "line 13: expected a number, found 'dark'"),
    "comma": (I1.replace("0.3", "0,3"), "write decimal points"),
    "NaN": (I1.replace("0.3", "nan"), "'left hand' at 410 nm: nan is not finite"),
    "negative": (I1.replace("0.3", "-0.3"), "-0.3 is negative"),
    "no spectra": (
        re.sub(r"SPECTRAL_NM(\d+)", r"CMYK_\1", I1),
        "no field of spectra such as .*; its fields are SAMPLE_ID",
    ),
    "descending": (I1.replace("NM420", "NM405"), "405 nm follows 410 nm"),
    "repeated": (I1.replace("NM420", "NM410"), "410 nm follows 410 nm"),
    "two kinds": (
        I1.replace("SPECTRAL_NM420", "nm420"),
        "several kinds, NM and SPECTR",
    ),
    "two tables": (I1 + I1, "2 tables of spectra, as of several measurement cond"),
    "a display": (
        I1.replace("ORIG", "DEVICE_CLASS DISPLAY\nORIG"),
        "is not reflectance",
    ),
    "a lamp": (
        I1.replace("ORIG", 'MEAS_TYPE "EMISSION"\nORIG'),
        "EMISSION is not refl",
    ),
    "bands": (
        ARGYLL.replace('BANDS "4"', 'BANDS "5"'),
        "BANDS is 5, and 4 fields were",
    ),
    "start": (ARGYLL.replace('"380.', '"370.'), "run from 380 to 390 nm, not in even"),
    "no start": (ARGYLL.replace('"380.000000"', "none"), "START_NM: expected a number"),
    "NaN start": (
        ARGYLL.replace('"380.000000"', "nan"),
        "SPECTRAL_BANDS is 4, and 4|NaN",
    ),
    "norm 0": (
        ARGYLL.replace('"100.0', '"0.0'),
        "written as 0; expected a number above",
    ),
    "norm NaN": (ARGYLL.replace('"100.000000', '"nan'), "written as nan; expected"),
    "two scales": (ARGYLL + "# scale: fraction\n", "written as 1 and 100; correct one"),
    "scale": (ARGYLL + "# scale: parts\n", "unknown scale 'parts'"),
    "mixed pairs": (PAIRED.replace("PCT\n", "DEC\n"), "SPECTRAL_DEC and SPECTRAL_PCT"),
    "lone pair": (PAIRED.replace("SPECTRAL_PCT", "LAB_L"), "after SPECTRAL_NM comes"),
    "other pairs": (PAIRED.replace("b 400", "b 410"), "line 7: other wavelengths"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_every_refusal_names_the_file_and_the_fault(written, what):
    text, told = REFUSED[what]
    path = written(text)
    declared = b"CTI3" in path.read_bytes() or b"_PCT" in path.read_bytes()
    with pytest.raises(DataError, match=f"^{re.escape(str(path))}.*{told}"):
        read_spectra(path, scale=None if declared else "fraction")


def test_a_table_of_colours_beside_the_spectra_does_not_matter(written):
    colours = "BEGIN_DATA_FORMAT\nLAB_L\nEND_DATA_FORMAT\nNUMBER_OF_FIELDS 1\n"
    text = I1 + colours + "NUMBER_OF_SETS 1\nBEGIN_DATA\n50\nEND_DATA\n"
    assert_array_equal(fraction(written(text)).reflectance, VALUES)
