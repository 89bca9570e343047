"""Points in text: their columns, separators, units and faults."""

import codecs

import numpy as np
import pytest
import pyvista as pv

from meshes import sphere, wave
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.clean import clean_scan
from skinviz.scan.formats import read_mesh, read_scan

ROWS = [(0.0, 1.5, -2.0), (3.0, 4.0, 5.25), (-1e-3, 0.0, 7.0), (10.0, 20.0, 30.0)]
SEPARATORS = {
    "blank": " ",
    "blanks": "   ",
    "tab": "\t",
    "comma": ",",
    "comma and blank": ", ",
    "semicolon": ";",
    "semicolons with blanks": " ; ",
}


def text(rows=ROWS, separator=" ", ending="\n", tail=""):
    return ending.join(separator.join(map(str, row)) + tail for row in rows) + ending


def cloud(path, content, unit="mm"):
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        path.write_bytes(content.encode())
    scan = read_scan(path, unit)
    assert (scan.views, scan.mesh, scan.source) == ((), None, str(path))
    return scan.cloud


@pytest.mark.parametrize("suffix", [".xyz", ".asc"])
@pytest.mark.parametrize("separator", SEPARATORS)
def test_columns_are_parted_by_any_of_the_usual_marks(tmp_path, separator, suffix):
    got = cloud(tmp_path / f"a{suffix}", text(separator=SEPARATORS[separator]))
    np.testing.assert_array_equal(got.points, ROWS)
    assert got.normals is None


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r", "\n\n", "\r\n \r\n"])
def test_lines_may_end_as_on_any_system(tmp_path, ending):
    got = cloud(tmp_path / "a.xyz", text(ending=ending))
    np.testing.assert_array_equal(got.points, ROWS)


def test_endings_may_be_mixed_and_the_last_missing(tmp_path):
    got = cloud(tmp_path / "a.xyz", "1 2 3\r\n4 5 6\r7 8 9\n1 1 1")
    np.testing.assert_array_equal(
        got.points, [[1, 2, 3], [4, 5, 6], [7, 8, 9], [1] * 3]
    )


@pytest.mark.parametrize(
    ("mark", "encoding"),
    [
        (codecs.BOM_UTF8, "utf-8"),
        (codecs.BOM_UTF16_LE, "utf-16-le"),
        (codecs.BOM_UTF16_BE, "utf-16-be"),
    ],
)
def test_a_byte_order_mark_is_no_number(tmp_path, mark, encoding):
    got = cloud(tmp_path / "a.xyz", mark + text().encode(encoding))
    np.testing.assert_array_equal(got.points, ROWS)


def test_a_separator_at_the_end_of_each_line_is_passed_over(tmp_path):
    got = cloud(tmp_path / "a.xyz", text(separator=",", tail=","))
    np.testing.assert_array_equal(got.points, ROWS)


def test_the_number_of_points_may_come_first(tmp_path):
    got = cloud(tmp_path / "a.xyz", f"{len(ROWS)}\n{text()}")
    np.testing.assert_array_equal(got.points, ROWS)


def test_comments_are_passed_over_and_may_state_the_unit(tmp_path):
    content = "# made by hand\n// unit of nothing\n# unit cm\n" + text(tail=" # here")
    got = cloud(tmp_path / "a.xyz", content, None)
    np.testing.assert_array_equal(got.points, 10 * np.array(ROWS))


def test_a_unit_that_is_none_is_refused(tmp_path):
    (tmp_path / "a.xyz").write_text("# unit furlong\n" + text())
    for unit in (None, "mm"):
        with pytest.raises(MeshError, match=r"a\.xyz.*'furlong'.*none of mm"):
            read_scan(tmp_path / "a.xyz", unit)


@pytest.mark.parametrize("suffix", [".xyz", ".asc", ".pts"])
def test_the_unit_is_required(tmp_path, suffix):
    file = tmp_path / f"a{suffix}"
    file.write_text((f"{len(ROWS)}\n" if suffix == ".pts" else "") + text())
    with pytest.raises(MeshError, match=rf"a\{suffix}.*unit"):
        read_scan(file)
    np.testing.assert_array_equal(
        read_scan(file, "inch").cloud.points, 25.4 * np.array(ROWS)
    )


@pytest.mark.parametrize("separator", [" ", ";"])
@pytest.mark.parametrize("row", ["1,5{0}2,5{0}3,5", "1{0}2,25{0}-3,5e2"])
def test_decimal_commas_are_refused_not_guessed(tmp_path, row, separator):
    (tmp_path / "a.xyz").write_text(row.format(separator) + "\n")
    with pytest.raises(MeshError, match=r"a\.xyz line 1.*decimal comma"):
        read_scan(tmp_path / "a.xyz", "mm")


def test_names_say_which_columns_are_the_place(tmp_path):
    got = cloud(
        tmp_path / "a.xyz",
        "intensity, z, y, x, nx, ny, nz\n9, 3, 2, 1, 0, 0, 1\n9, 6, 5, 4, 0, -1, 0\n",
    )
    np.testing.assert_array_equal(got.points, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(got.normals, [[0, 0, 1], [0, -1, 0]])


def test_six_columns_are_normals_only_if_all_have_length_one(tmp_path):
    mesh = sphere(subdivisions=1)
    normals = topology.vertex_normals(*topology.arrays(mesh))
    rows = np.hstack([mesh.points, normals])
    got = cloud(tmp_path / "a.xyz", text(np.round(rows, 4)))
    np.testing.assert_allclose(got.points, mesh.points, atol=1e-4)
    np.testing.assert_allclose(got.normals, normals, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(got.normals, axis=1), 1, rtol=1e-14)
    coloured = rows.copy()
    coloured[5, 3:] = [255, 0, 1]
    assert cloud(tmp_path / "a.xyz", text(coloured)).normals is None


FAULTS = {
    "a word": ("1 2 3\n4 five 6\n", "line 2.*'five' is no number"),
    "too few": ("1 2 3\n\n4 5\n", "line 3.*expected 3 numbers, got 2"),
    "too many": ("1 2 3\n4 5 6 7\n", "line 2.*expected 3 numbers, got 4"),
    "two columns": ("1 2\n3 4\n", "line 1.*expected x, y and z, got 2"),
    "NaN": ("1 2 3\n4 nan 6\n", "line 2.*not finite"),
    "infinite": ("1 2 3\n4 -inf 6\n", "line 2.*not finite"),
    "beyond float64": ("1 2 3\n4 1e999 6\n", "line 2.*not finite"),
    "beyond the earth": ("1 2 3\n4 1e200 6\n", "point 1 lies more than"),
    "empty cell": ("1,2,3\n4,,6\n", "line 2.*'' is no number"),
    "another separator": ("1,2,3\n4;5;6\n", "line 2.*expected 3 numbers"),
    "only comments": ("# nothing\n", "no line but"),
    "only names": ("x y z\n", "no points"),
    "twice a name": ("x y z z\n1 2 3 4\n", "line 1.*same name"),
    "more names": ("x y z i\n1 2 3\n", "3 numbers under 4 names"),
    "binary": (b"1 2 3\n\0\1\2\n", "line 2.*binary"),
    "underscores": ("1_0 2 3\n", "line 1.*'1_0' is no number"),
    "hexadecimal": ("0x10 2 3\n", "line 1.*no number"),
    "another count": ("3\n1 2 3\n4 5 6\n", "line 1.*'3' points expected, 2 follow"),
    "normals of no length": ("x y z nx ny nz\n1 2 3 0 0 0\n", "not of length 1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_file_is_refused_with_its_line(tmp_path, fault):
    content, message = FAULTS[fault]
    with pytest.raises(MeshError, match=rf"a\.xyz.*{message}"):
        cloud(tmp_path / "a.xyz", content)


def test_pts_gives_all_points_of_all_clouds(tmp_path):
    # VTK drops the last points of such a file, and pymeshlab gives none.
    content = f"3\n{text(ROWS[:3], tail=' -1200 9 8 7')}1\n{text(ROWS[3:])}"
    got = cloud(tmp_path / "a.pts", content)
    np.testing.assert_array_equal(got.points, ROWS)


PTS_FAULTS = {
    "too few lines": ("5\n" + text(), "line 1.*5 points expected, 4 lines left"),
    "too many lines": ("3\n" + text(), "line 5.*expected the number of points"),
    "no count": (text(), "line 1.*expected the number of points"),
    "huge count": ("1000000000000000000\n" + text(), "line 1.*expected, 4 lines"),
    "longer than any count": ("9" * 5000 + "\n" + text(), "line 1.*expected"),
    "negative count": ("-4\n" + text(), "line 1.*expected the number"),
    "no points": ("0\n", "no points"),
    "landmarks": ("version: 1\nn_points: 68\n{\n", "line 1.*expected the number"),
}


@pytest.mark.parametrize("fault", PTS_FAULTS)
def test_a_broken_pts_file_is_refused(tmp_path, fault):
    content, message = PTS_FAULTS[fault]
    with pytest.raises(MeshError, match=rf"a\.pts.*{message}"):
        cloud(tmp_path / "a.pts", content)


def test_a_ply_file_without_faces_holds_points(tmp_path):
    points = np.asarray(wave(5).points, dtype=np.float32)
    mesh = pv.PolyData(points)
    mesh.save(tmp_path / "a.ply")
    got = read_scan(tmp_path / "a.ply", "mm").cloud
    np.testing.assert_array_equal(got.points, points)
    assert got.normals is None


def test_a_ply_file_of_points_may_have_normals(tmp_path):
    head = "ply\nformat ascii 1.0\ncomment unit m\nelement vertex 2\n"
    names = "".join(f"property float {k}\n" for k in ("x", "y", "z", "nx", "ny", "nz"))
    body = "end_header\n0 0 0 0 0 1\n1 2 3 0 -1 0\n"
    got = cloud(tmp_path / "a.ply", head + names + body, None)
    np.testing.assert_array_equal(got.points, [[0, 0, 0], [1000, 2000, 3000]])
    np.testing.assert_array_equal(got.normals, [[0, 0, 1], [0, -1, 0]])


def test_points_are_no_surface_and_the_error_says_what_to_do(tmp_path):
    (tmp_path / "a.xyz").write_text(text())
    told = r"a\.xyz has 4 points but no faces.*write the scan as range views"
    with pytest.raises(MeshError, match=told):
        read_mesh(tmp_path / "a.xyz", "mm")
    with pytest.raises(MeshError, match=told):
        clean_scan(read_scan(tmp_path / "a.xyz", "mm"))


GRID = "ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9\n"


def test_an_esri_grid_is_a_view_with_the_north_first(tmp_path):
    (tmp_path / "a.asc").write_text("# unit cm\n" + GRID + "1 2 3\n4 -9 6\n")
    (view,) = read_scan(tmp_path / "a.asc").views
    assert view.eye is None
    np.testing.assert_array_equal(view.pose, np.eye(4))
    x, y, z = np.moveaxis(view.points / 10, -1, 0)
    np.testing.assert_allclose(x, [[11, 13, 15], [11, np.nan, 15]], rtol=1e-15)
    np.testing.assert_allclose(y, [[23, 23, 23], [21, np.nan, 21]], rtol=1e-15)
    np.testing.assert_allclose(z, [[1, 2, 3], [4, np.nan, 6]], rtol=1e-15)


def test_an_esri_grid_may_name_the_centre_and_break_its_rows(tmp_path):
    (tmp_path / "a.asc").write_text(
        GRID.replace("corner", "center") + "1\n2 3 4\n-9 6\n"
    )
    (view,) = read_scan(tmp_path / "a.asc", "mm").views
    np.testing.assert_array_equal(view.points[0, 0], [10, 22, 1])
    np.testing.assert_array_equal(view.valid, [[True, True, True], [True, False, True]])


GRID_FAULTS = {
    "too few": (GRID + "1 2 3\n4 5\n", "line 8.*expected 3 numbers, got 2"),
    "too few rows": (GRID + "1 2 3\n", "2 x 3 cells, the file has 3"),
    "a word": (GRID + "1 2 3 4 5 six\n", "'six' is no number"),
    "NaN": (GRID + "1 2 3 4 5 nan\n", "not finite"),
    "no return": (GRID + "-9 -9 -9\n-9 -9 -9\n", "no return"),
    "huge": (
        GRID.replace("nrows 2", "nrows 1e18") + "1 2 3\n",
        "cells, the file has 3",
    ),
    "no size": (GRID.replace("cellsize 2\n", "") + "1 2 3\n4 5 6\n", "cellsize"),
    "half a row": (GRID.replace("nrows 2", "nrows 2.5") + "1 2 3\n", "whole number"),
    "twice": ("ncols 3\n" + GRID + "1 2 3\n4 5 6\n", "line 2.*ncols, once"),
    "nothing after a key": (GRID.replace("2\nx", "\nx") + "1 2\n", "line 2.*nrows"),
}


@pytest.mark.parametrize("fault", GRID_FAULTS)
def test_a_broken_esri_grid_is_refused(tmp_path, fault):
    content, message = GRID_FAULTS[fault]
    (tmp_path / "a.asc").write_text(content)
    with pytest.raises(MeshError, match=rf"a\.asc.*{message}"):
        read_scan(tmp_path / "a.asc", "mm")
