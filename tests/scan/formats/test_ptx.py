"""PTX grids: several scans of a file, their cells, poses and eyes."""

import numpy as np
import pytest
from scan_files import grid_view, ptx_text

from meshes import pose
from skinviz.errors import MeshError
from skinviz.scan.formats import read_scan, write_scan
from skinviz.scan.grid import triangulate
from skinviz.scan.scan import Scan, transform

POINTS = grid_view(rows=4, columns=6).points - [30, -20, 400]
TURNED = pose((0.3, -0.2, 1.1), (100, 200, -50))


def write(path, *scans, **options):
    path.write_text(ptx_text(scans, **options))
    return path


def test_views_and_poses_come_back_as_they_were_written(tmp_path):
    file = write(
        tmp_path / "hand.ptx",
        (POINTS, TURNED, TURNED[:3, 3]),
        (POINTS[::-1, :3], np.eye(4), np.zeros(3)),
        colour=" 1 2 3",
    )
    first, second = read_scan(file, "mm").views
    assert [first.name, second.name] == ["hand_00", "hand_01"]
    np.testing.assert_array_equal(first.points, POINTS)
    np.testing.assert_array_equal(second.points, POINTS[::-1, :3])
    np.testing.assert_allclose(first.pose, TURNED, atol=1e-13)
    np.testing.assert_array_equal(second.pose, np.eye(4))
    np.testing.assert_allclose(first.eye, 0, atol=1e-12)


def test_the_matrix_takes_points_as_rows_and_cells_run_down_the_columns(tmp_path):
    # Written out by hand: a quarter turn about z takes the row (1, 0, 0) to (0, 1, 0).
    (tmp_path / "a.ptx").write_text(
        "2\n2\n5 6 7\n1 0 0\n0 1 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 6 7 1\n"
        "1 0 0 0.5\n2 0 0 0.5\n0 0 0 0.5\n4 0 0 0.5\n"
    )
    (view,) = read_scan(tmp_path / "a.ptx", "mm").views
    np.testing.assert_array_equal(view.points[:, 0], [[1, 0, 0], [2, 0, 0]])
    np.testing.assert_array_equal(view.points[1, 1], [4, 0, 0])
    assert np.isnan(view.points[0, 1]).all()  # 0 0 0 is no return
    np.testing.assert_allclose(
        transform(view.pose, np.array([1.0, 0, 0])), [5, 7, 7], atol=1e-15
    )


def test_points_written_in_place_are_seen_from_where_the_scanner_stood(tmp_path):
    file = write(tmp_path / "a.ptx", (POINTS, np.eye(4), np.array([3.0, 4, 500])))
    (view,) = read_scan(file, "mm").views
    np.testing.assert_array_equal(view.eye, [3, 4, 500])


def test_lengths_are_scaled_and_rotations_are_not(tmp_path):
    file = write(tmp_path / "a.ptx", (POINTS / 1000, TURNED, TURNED[:3, 3] + 1))
    (view,) = read_scan(file, "m").views
    np.testing.assert_allclose(view.points, POINTS, rtol=1e-14)
    np.testing.assert_allclose(view.pose[:3, :3], TURNED[:3, :3], atol=1e-14)
    np.testing.assert_allclose(view.pose[:3, 3], 1000 * TURNED[:3, 3], rtol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(view.eye), 1000 * np.sqrt(3), rtol=1e-12)


def test_the_unit_is_required(tmp_path):
    file = write(tmp_path / "a.ptx", (POINTS, TURNED, TURNED[:3, 3]))
    with pytest.raises(MeshError, match=r"a\.ptx.*unit"):
        read_scan(file)


def test_a_scan_without_a_return_may_stand_beside_another(tmp_path):
    none = np.full((3, 2, 3), np.nan)
    file = write(
        tmp_path / "a.ptx",
        (none, np.eye(4), np.zeros(3)),
        (POINTS, np.eye(4), np.zeros(3)),
    )
    assert [v.valid.any() for v in read_scan(file, "mm").views] == [False, True]
    write(file, (none, np.eye(4), np.zeros(3)))
    with pytest.raises(MeshError, match=r"a\.ptx.*no scan in it has any return"):
        read_scan(file, "mm")


def test_rays_that_meet_see_a_wall_whole_that_parallel_ones_would_graze(tmp_path):
    # Cells of equal angles on a plane, out to 80 degrees from its normal: all of it
    # faces the eye within 80 degrees, and a box about the eye faces it everywhere.
    angle = np.deg2rad(np.linspace(-80, 80, 41))
    x, y = np.meshgrid(np.tan(angle), np.linspace(-1, 1, 9))
    wall = np.stack([x, y, -np.ones_like(x)], axis=-1) * 100
    eye = np.zeros(3)
    _, faces, dropped = triangulate(wall, np.deg2rad(89), eye)
    assert (len(faces), dropped) == (2 * 40 * 8, 0)
    sideways = wall[..., [2, 1, 0]]  # now parallel to z
    _, faces, dropped = triangulate(sideways, np.deg2rad(89), eye)
    assert (len(faces), dropped) == (2 * 40 * 8, 0)
    assert triangulate(sideways, np.deg2rad(89))[2] == 2 * 40 * 8


def test_no_bridge_spans_a_depth_jump_along_the_rays():
    direction = np.stack(
        [*np.meshgrid(np.linspace(-0.5, 0.5, 21), np.linspace(-0.2, 0.2, 9)),
         -np.ones((9, 21))],
        axis=-1,
    )  # fmt: skip
    near_and_far = np.where(np.arange(21) < 10, 300.0, 500.0)[None, :, None]
    points, faces, dropped = triangulate(
        direction * near_and_far, np.deg2rad(75), np.zeros(3)
    )
    assert dropped == 2 * 8
    assert np.ptp(points[faces][..., 2], axis=1).max() < 1e-9


FAULTS = {
    "cut in the head": (
        lambda t: "\n".join(t.split("\n")[:7]),
        "begins with ten lines",
    ),
    "cut in the cells": (lambda t: t[: len(t) // 2], "not a whole PTX file"),
    "one line more": (lambda t: t + "1 2 3 0.5\n", "begins with ten lines"),
    "huge": (lambda t: "1000000000000000000" + t[1:], "1000000000000000000 x 4 cells"),
    "no columns": (lambda t: "0" + t[1:], "line 1.*above 0"),
    "negative": (lambda t: "-6" + t[1:], "line 1.*above 0"),
    "a word": (lambda t: t.replace("400 0.5", "4oo 0.5", 1), "no number"),
    "NaN": (lambda t: t.replace("0.5\n", "0.5\nnan nan nan ", 1), "not finite"),
    "a matrix of zeros": (lambda t: _line(t, 6, "0 0 0 0"), "line 7.*no rotation"),
    "a mirror": (lambda t: _line(t, 6, "-1 0 0 0"), "line 7.*no rotation"),
    "a stretch": (lambda t: _line(t, 6, "1.1 0 0 0"), "line 7.*no rotation"),
    "a huge matrix": (lambda t: _line(t, 6, "1e300 0 0 0"), "line 7.*no rotation"),
    "a perspective": (lambda t: _line(t, 6, "1 0 0 0.5"), "line 7.*no rotation"),
    "a scanner beyond": (lambda t: _line(t, 2, "1e300 0 0"), "scanner.*lies more"),
    "a short matrix": (lambda t: _line(t, 8, "0 0 1"), "line 9.*expected 4 numbers"),
}


def _line(text, index, new):
    lines = text.split("\n")
    lines[index] = new
    return "\n".join(lines)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_file_is_refused(tmp_path, fault):
    change, message = FAULTS[fault]
    whole = ptx_text([(POINTS, np.eye(4), np.zeros(3))])
    (tmp_path / "a.ptx").write_text(change(whole))
    with pytest.raises(MeshError, match=rf"a\.ptx.*{message}"):
        read_scan(tmp_path / "a.ptx", "mm")


def test_a_conf_holds_where_rays_meet(tmp_path):
    file = write(tmp_path / "a.ptx", (POINTS, np.eye(4), np.zeros(3)))
    views = read_scan(file, "mm").views
    write_scan(tmp_path / "b.conf", Scan(views=views))
    (again,) = read_scan(tmp_path / "b.conf", "mm").views
    np.testing.assert_allclose(again.eye, views[0].eye, atol=1e-6)
