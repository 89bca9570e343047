"""Files of goniometer readings: degrees in, radians out, and what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import DataError
from skinviz.surface.gonio import read_gonio

HEADER = "illumination_deg,viewing_deg,specular\n"


def written(tmp_path, text):
    """Return a file of that text."""
    file = tmp_path / "gonio.csv"
    file.write_text(text)
    return file


def test_degrees_become_radians(tmp_path):
    data = read_gonio(written(tmp_path, HEADER + "0,60,0.01\n45,60,0.1\n"))
    assert_allclose(data.illumination, [0, np.pi / 4], rtol=1e-15)
    assert_allclose(data.viewing, np.pi / 3, rtol=1e-15)
    assert_array_equal(data.specular, [0.01, 0.1])
    assert data.uncertainty is None


def test_columns_in_any_order_comments_and_uncertainty(tmp_path):
    text = "# back of hand\nspecular, uncertainty, Viewing_deg, illumination_deg\n\n"
    data = read_gonio(written(tmp_path, text + "-0.01, 0.02, 60, 85\n"))
    assert_array_equal(data.specular, [-0.01])
    assert_array_equal(data.uncertainty, [0.02])
    assert_allclose(np.rad2deg(data.illumination), [85])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "the file is empty"),
        ("# nothing\n", "only comments"),
        (HEADER, "a header and no readings"),
        ("illumination,viewing,specular\n1,2,3\n", "the header must be"),
        ("0,60,0.01\n", "the header must be"),
        ("illumination_deg,specular\n1,2\n", "the header must be"),
        (HEADER.strip() + ",specular\n1,2,3,4\n", "the header must be"),
        (HEADER + "0,60\n", "line 2: 2 cells where the header has 3"),
        (HEADER + "0,60,1\n5,60,bright\n", "line 3: expected a number"),
        (HEADER + "0,60,\n", "line 2: expected a number, found an empty cell"),
        (HEADER + "0,60,nan\n", "line 2: nan is no reading"),
        (HEADER + "inf,60,1\n", "line 2: inf is no reading"),
    ],
)
def test_files_that_are_none_are_refused(tmp_path, text, told):
    with pytest.raises(DataError, match=told):
        read_gonio(written(tmp_path, text))


def test_a_missing_file_is_said(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read_gonio(tmp_path / "none.csv")


def test_what_is_no_text_is_refused(tmp_path):
    file = tmp_path / "gonio.csv"
    file.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(DataError, match="not a text file"):
        read_gonio(file)
