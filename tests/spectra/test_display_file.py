"""Displays in files: measurements in TOML, and profiles."""

import icc_profiles as make
import numpy as np
import pytest
from numpy.testing import assert_allclose
from tolerances import ROUNDING

from skinviz import DataError
from skinviz.spectra.curves import PowerCurve, SrgbCurve
from skinviz.spectra.display import measured_display
from skinviz.spectra.display_file import read_display

PRIMARIES = "primaries = [[57.7, 29.7, 2.7], [18.6, 62.7, 7.1], [18.8, 7.5, 99.1]]\n"
ROWS = [[57.7, 29.7, 2.7], [18.6, 62.7, 7.1], [18.8, 7.5, 99.1]]


@pytest.fixture
def written(tmp_path):
    """Return a function that writes a file and returns its path."""

    def write(content, name="screen.toml"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def test_a_measured_display_is_read(written):
    display = read_display(written(PRIMARIES + 'curves = 2.2\nname = "left screen"\n'))
    assert display.name == "left screen"
    assert_allclose(display.matrix, measured_display(ROWS).matrix, rtol=ROUNDING)
    assert display.curves == (PowerCurve(2.2),) * 3


def test_a_display_without_a_name_has_its_files(written):
    assert read_display(written(PRIMARIES + "curves = 2.2\n")).name == "screen"


def test_curves_are_read_in_all_their_forms(written):
    text = PRIMARIES + 'curves = ["sRGB", 1.8, [[0, 0.1], [128, 20.1], [255, 100.1]]]\n'
    red, green, blue = read_display(written(text)).curves
    assert (red, green) == (SrgbCurve(), PowerCurve(1.8))
    assert_allclose(blue.decode(np.array([128 / 255])), 0.2, rtol=ROUNDING)


def test_black_is_read(written):
    text = PRIMARIES + "curves = 2.2\nblack = [0.1, 0.1, 0.2]\n"
    expected = measured_display(ROWS, black=[0.1, 0.1, 0.2]).matrix
    assert_allclose(read_display(written(text)).matrix, expected, rtol=ROUNDING)


@pytest.mark.parametrize("name", ["a.icc", "a.icm", "a.ICC"])
def test_a_profile_is_read(written, name):
    content = make.profile(make.display_tags())
    display = read_display(written(content, name))
    assert display.icc == content
    assert_allclose(display.white, make.xyz_of(make.D65_XY), atol=1e-4)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (PRIMARIES, "curves is missing"),
        ("curves = 2.2\n", "primaries is missing"),
        (PRIMARIES + "curves = 2.2\ngamma = 2.2\n", "unknown key 'gamma'; known are"),
        (PRIMARIES + "curves = \n", "not a TOML file"),
        (b"\xff\xfe", "not a TOML file"),
        ("a = " + "[" * 5000, "not a TOML file"),
        (PRIMARIES + "curves = 0\n", "gamma must be in"),
        (PRIMARIES + "curves = true\n", "gamma must be a number"),
        (PRIMARIES + "curves = {a = 1}\n", "gamma must be a number"),
        (PRIMARIES + "curves = 2.2\nblack = 1\n", "black must be one XYZ"),
        (PRIMARIES + "curves = 2.2\nblack = 'x'\n", "black must be numbers"),
        ("primaries = 1\ncurves = 2.2\n", "primaries must be the XYZ"),
        ("primaries = [[1, 1, 1], [1]]\ncurves = 2.2\n", "primaries must be numbers"),
        ("primaries = 2020-01-01\ncurves = 2.2\n", "primaries must be"),
    ],
)
def test_what_is_no_display_is_refused_and_its_file_named(written, text, told):
    with pytest.raises(DataError, match=told) as caught:
        read_display(written(text))
    assert "screen.toml" in str(caught.value)


def test_other_files_are_refused(written, tmp_path):
    with pytest.raises(DataError, match=r"read from .toml and .icc, .icm; '.json'"):
        read_display(written("{}", "a.json"))
    with pytest.raises(DataError, match="'no suffix'"):
        read_display(written("{}", "a"))
    with pytest.raises(DataError, match="no such file"):
        read_display(tmp_path / "none.toml")
    with pytest.raises(DataError, match="'acsp'"):
        read_display(written(PRIMARIES, "a.icc"))


def test_a_huge_file_is_refused(written):
    with pytest.raises(DataError, match="4 MiB are no display"):
        read_display(written(b"#" * (2**22 + 1)))
