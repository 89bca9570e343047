"""Stanford range views: what is written is read back, and what is broken refused."""

import struct
from dataclasses import replace

import numpy as np
import plyfile
import pytest

from meshes import pose
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan.formats import read_mesh, read_scan, write_scan
from skinviz.scan.scan import RangeView, Scan, transform


def some_view(name="front", rows=6, columns=9, where=None, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-100, 100, (rows, columns, 3))
    points[rng.random((rows, columns)) < 0.3] = np.nan
    points[0, 0] = np.nan  # the first cell counts too
    return RangeView(name, points, np.eye(4) if where is None else where)


def write_grid(
    path, cells, vertices, *, rows=2, columns=2, comments=(), info=None, text=False
):
    """A range-grid PLY file, written byte by byte."""
    if info is None:
        info = [f"obj_info num_cols {columns}", f"obj_info num_rows {rows}"]
    head = [
        "ply",
        f"format {'ascii' if text else 'binary_little_endian'} 1.0",
        *(f"comment {c}" for c in comments),
        *info,
        f"element vertex {len(vertices)}",
        "property float x",
        "property float y",
        "property float z",
        f"element range_grid {len(cells)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    if text:
        body = [" ".join(map(str, v)) for v in vertices]
        body += [" ".join(map(str, (len(c), *c))) for c in cells]
        path.write_text("\n".join(head + body) + "\n")
        return path
    body = [struct.pack("<3f", *map(float, v)) for v in vertices]
    body += [struct.pack(f"<B{len(c)}i", len(c), *c) for c in cells]
    path.write_bytes("\n".join(head).encode() + b"\n" + b"".join(body))
    return path


GOOD = [(0.0, 0, 0), (1, 0, 0), (0, 1, 0)]


def test_views_and_poses_come_back_as_they_were_written(tmp_path):
    rng = np.random.default_rng(1)
    views = tuple(
        some_view(
            f"view_{i}",
            rows=5 + i,
            columns=9 - i,
            where=pose(rng.uniform(-2, 2, 3), rng.uniform(-600, 600, 3)),
            seed=i,
        )
        for i in range(3)
    )
    files = write_scan(tmp_path / "hand.conf", Scan(views=views), ("seed 1", "80 mm"))
    assert [f.name for f in files] == [
        *(f"view_{i}.ply" for i in range(3)),
        "hand.conf",
    ]
    scan = read_scan(tmp_path / "hand.conf")
    assert scan.mesh is None
    for view, got in zip(views, scan.views, strict=True):
        assert got.name == view.name
        # Points are stored as float32, poses with 9 digits.
        np.testing.assert_array_equal(
            got.points, view.points.astype(np.float32).astype(np.float64)
        )
        np.testing.assert_allclose(got.pose[:3, :3], view.pose[:3, :3], atol=5e-9)
        np.testing.assert_allclose(got.pose[:3, 3], view.pose[:3, 3], atol=5e-7)
        np.testing.assert_array_equal(got.pose[3], [0, 0, 0, 1])


def test_writing_what_was_read_changes_no_byte_of_the_views(tmp_path):
    first, second = tmp_path / "a", tmp_path / "b"
    scan = Scan(views=(some_view(where=pose((0.1, -2.0, 0.7), (10, 20, -30))),))
    write_scan(first / "hand.conf", scan)
    write_scan(second / "hand.conf", read_scan(first / "hand.conf"))
    assert (first / "front.ply").read_bytes() == (second / "front.ply").read_bytes()


def test_a_quarter_turn_is_read_as_the_inverse_of_its_quaternion(tmp_path):
    # (0, 0, sin 45°, cos 45°) turns points by +90° about z; in a .conf it turns the
    # frame, so that the view's points turn by -90°: x goes to -y.
    write_grid(tmp_path / "v.ply", [[0], [1], [2], []], GOOD, comments=["unit mm"])
    half = np.sqrt(0.5)
    (tmp_path / "a.conf").write_text(f"bmesh v.ply 10 20 30 0 0 {half} {half}\n")
    where = read_scan(tmp_path / "a.conf").views[0].pose
    np.testing.assert_allclose(
        transform(where, np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])),
        [[10, 19, 30], [11, 20, 30], [10, 20, 31]],
        atol=1e-12,
    )


def test_a_quarter_turn_is_written_as_the_inverse_quaternion(tmp_path):
    turn = pose((0, 0, np.pi / 2), (1, 2, 3))
    write_scan(tmp_path / "a.conf", Scan(views=(some_view(where=turn),)))
    words = (tmp_path / "a.conf").read_text().split()
    assert words[:2] == ["bmesh", "front.ply"]
    numbers = np.array(words[2:], dtype=float)
    np.testing.assert_array_equal(numbers[:3], [1, 2, 3])
    np.testing.assert_allclose(
        numbers[3:] * np.sign(numbers[6]),
        [0, 0, -np.sqrt(0.5), np.sqrt(0.5)],
        atol=1e-8,
    )


def test_a_quaternion_is_scaled_to_length_one(tmp_path):
    write_grid(tmp_path / "v.ply", [[0], [1], [2], []], GOOD, comments=["unit mm"])
    (tmp_path / "a.conf").write_text("bmesh v.ply 0 0 0 0 0 1.4 1.4\n")
    rotation = read_scan(tmp_path / "a.conf").views[0].pose[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)


def test_cells_keep_their_row_and_column(tmp_path):
    file = write_grid(
        tmp_path / "v.ply",
        [[2], [], [], [0], [1], []],
        GOOD,
        rows=2,
        columns=3,
        comments=["unit mm"],
    )
    grid = read_scan(file).views[0].points
    assert grid.shape == (2, 3, 3)
    np.testing.assert_array_equal(grid[0, 0], GOOD[2])
    np.testing.assert_array_equal(grid[1, 0], GOOD[0])
    np.testing.assert_array_equal(grid[1, 1], GOOD[1])
    assert np.isnan(grid[0, 1:]).all()
    assert np.isnan(grid[1, 2]).all()


def test_a_grid_in_text_reads_as_the_binary_one_does(tmp_path):
    # Stanford's own range scans are text, most of their cells empty.
    files = [
        write_grid(tmp_path / f"{text}.ply", [[2], [], [0], [1]], GOOD, text=text)
        for text in (True, False)
    ]
    first, second = (read_scan(file, "mm").views[0].points for file in files)
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("unit", "scale"),
    [("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("um", 1e-3), ("inch", 25.4)],
)
def test_points_and_shifts_are_brought_to_millimetres(tmp_path, unit, scale):
    write_grid(tmp_path / "v.ply", [[0], [1], [2], []], GOOD)
    (tmp_path / "a.conf").write_text("bmesh v.ply 1 2 3 0 0 0 1\n")
    view = read_scan(tmp_path / "a.conf", unit).views[0]
    np.testing.assert_allclose(view.points[0, 1], [scale, 0, 0], rtol=1e-15)
    np.testing.assert_allclose(view.pose[:3, 3], np.array([1, 2, 3]) * scale)
    np.testing.assert_allclose(view.pose[:3, :3], np.eye(3), atol=1e-15)


def test_the_unit_is_required_unless_stated(tmp_path):
    silent = write_grid(tmp_path / "silent.ply", [[0], [1], [2], []], GOOD)
    with pytest.raises(MeshError, match=r"silent\.ply.*unit"):
        read_scan(silent)
    stated = write_grid(
        tmp_path / "stated.ply", [[0], [1], [2], []], GOOD, comments=["unit cm"]
    )
    assert read_scan(stated).views[0].points[0, 1, 0] == 10
    with pytest.raises(ArgumentError, match="unknown unit"):
        read_scan(silent, "furlong")


def test_files_written_by_skinviz_state_their_unit_and_comments(tmp_path):
    write_scan(tmp_path / "a.conf", Scan(views=(some_view(),)), ("seed 5",))
    ply = plyfile.PlyData.read(tmp_path / "front.ply")
    assert ply.comments == ["unit mm", "seed 5"]
    assert (tmp_path / "a.conf").read_text().startswith("# seed 5\n")


def test_a_conf_passes_over_comments_and_the_viewers_camera(tmp_path):
    write_grid(tmp_path / "v.ply", [[0], [1], [2], []], GOOD, comments=["unit mm"])
    (tmp_path / "a.conf").write_text(
        "# made by hand\n\ncamera -0.02 0.1 0.3 0 0 0 1\nbmesh v.ply 0 0 0 0 0 0 1\n"
    )
    assert len(read_scan(tmp_path / "a.conf").views) == 1


CONF_FAULTS = {
    "too few numbers": ("bmesh v.ply 0 0 0 0 0 1", "line 1.*expected 'bmesh FILE"),
    "too many numbers": ("bmesh v.ply 0 0 0 0 0 0 1 5", "line 1.*expected"),
    "a word": ("# x\nbmesh v.ply 0 0 zero 0 0 0 1", "line 2.*zero"),
    "zero quaternion": ("bmesh v.ply 0 0 0 0 0 0 0", "line 1.*quaternion"),
    "NaN": ("bmesh v.ply 0 nan 0 0 0 0 1", "line 1.*not finite"),
    "infinite": ("bmesh v.ply 0 0 0 inf 0 0 1", "line 1.*not finite"),
    "missing file": ("bmesh gone.ply 0 0 0 0 0 0 1", r"gone\.ply.*no such file"),
    "no view": ("camera 0 0 0 0 0 0 1", r"a\.conf.*no 'bmesh' line"),
    "a mesh": ("bmesh mesh.ply 0 0 0 0 0 0 1", r"mesh\.ply.*no range_grid"),
    "junk": ("bmesh junk.ply 0 0 0 0 0 0 1", r"junk\.ply.*PLY"),
    "binary": ("\x00\x01\xff\xfe", r"a\.conf"),
}


@pytest.mark.parametrize("fault", CONF_FAULTS)
def test_a_broken_conf_is_refused_with_its_line(tmp_path, fault):
    text, message = CONF_FAULTS[fault]
    write_grid(tmp_path / "v.ply", [[0], [1], [2], []], GOOD, comments=["unit mm"])
    (tmp_path / "mesh.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    )
    (tmp_path / "junk.ply").write_bytes(bytes(range(256)))
    (tmp_path / "a.conf").write_text(text, encoding="latin-1")
    with pytest.raises(MeshError, match=message):
        read_scan(tmp_path / "a.conf")


GRID_FAULTS = {
    "too few cells": ({"cells": [[0], [1], [2]]}, r"2 x 2 cells.*has 3"),
    "no rows said": ({"info": ["obj_info num_cols 2"]}, "num_rows"),
    "rows are no number": (
        {"info": ["obj_info num_cols 2", "obj_info num_rows two"]},
        "num_rows",
    ),
    "negative counts": ({"rows": -2, "columns": -2}, "cells"),
    "no cells": ({"rows": 0, "columns": 0, "cells": []}, "cells"),
    "vertex too high": ({"cells": [[0], [1], [3], []]}, "vertex 3 of 3"),
    "vertex negative": ({"cells": [[0], [-1], [2], []]}, r"names vertex -1 of 3"),
    "no return": ({"cells": [[], [], [], []]}, "no return"),
    "NaN return": ({"vertices": [("nan", 0, 0), *GOOD[1:]]}, "not finite"),
    "infinite return": ({"vertices": [("inf", 0, 0), *GOOD[1:]]}, "not finite"),
}


@pytest.mark.parametrize("fault", GRID_FAULTS)
def test_a_broken_grid_is_refused_by_name(tmp_path, fault):
    changes, message = GRID_FAULTS[fault]
    good = {"cells": [[0], [1], [2], []], "vertices": GOOD}
    file = write_grid(tmp_path / "v.ply", **{**good, **changes})
    with pytest.raises(MeshError, match=rf"v\.ply.*{message}"):
        read_scan(file, "mm")


def test_a_vertex_without_z_is_refused(tmp_path):
    file = write_grid(tmp_path / "v.ply", [[0], [1], [2], []], GOOD)
    file.write_bytes(file.read_bytes().replace(b" float z", b" float w"))
    with pytest.raises(MeshError, match=r"v\.ply.*x, y and z"):
        read_scan(file, "mm")


def test_a_truncated_range_view_is_refused_wherever_it_ends(tmp_path):
    write_scan(tmp_path / "a.conf", Scan(views=(some_view(rows=12, columns=15),)))
    whole = (tmp_path / "front.ply").read_bytes()
    cut = tmp_path / "cut.ply"
    for end in {*range(0, len(whole), 7), *range(len(whole) - 12, len(whole))}:
        cut.write_bytes(whole[:end])
        with pytest.raises(MeshError, match=r"cut\.ply"):
            read_scan(cut, "mm")


def test_range_views_are_no_mesh(tmp_path):
    write_scan(tmp_path / "a.conf", Scan(views=(some_view(),)))
    with pytest.raises(MeshError, match=r"a\.conf holds raw range views.*clean"):
        read_mesh(tmp_path / "a.conf")


def test_a_name_with_a_space_comes_back(tmp_path):
    scan = Scan(views=(some_view("view 1"),))
    write_scan(tmp_path / "a.conf", scan)
    got = read_scan(tmp_path / "a.conf").views[0]
    np.testing.assert_array_equal(got.valid, scan.views[0].valid)


def test_a_scan_without_views_is_not_written_as_an_unreadable_file(tmp_path):
    with pytest.raises(MeshError):
        write_scan(tmp_path / "a.conf", Scan())
    assert list(tmp_path.iterdir()) == []


def test_views_of_one_name_do_not_overwrite_each_other(tmp_path):
    twins = Scan(views=(some_view(seed=1), some_view(seed=2)))
    try:
        write_scan(tmp_path / "a.conf", twins)
    except MeshError:
        return
    got = read_scan(tmp_path / "a.conf").views
    for view, twin in zip(got, twins.views, strict=True):
        np.testing.assert_array_equal(view.valid, twin.valid)


def test_where_rays_meet_goes_there_and_back(tmp_path):
    view = replace(some_view(), eye=np.array([1.5, -2.0, 612.25]))
    write_scan(tmp_path / "a.conf", Scan(views=(view,)), ("eye of the beholder",))
    (back,) = read_scan(tmp_path / "a.conf").views
    np.testing.assert_array_equal(back.eye, view.eye)
    np.testing.assert_allclose(back.points, view.points, atol=1e-4)


def test_prose_that_speaks_of_eyes_says_no_place(tmp_path):
    write_scan(tmp_path / "a.conf", Scan(views=(some_view(),)), ("eye a b c",))
    assert read_scan(tmp_path / "a.conf").views[0].eye is None
