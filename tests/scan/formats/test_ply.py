"""The PLY container: read as plyfile reads it, and never beyond its bytes."""

import warnings

import numpy as np
import plyfile
import pytest

from skinviz.errors import MeshError
from skinviz.scan.formats.ply import read_ply

KINDS = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")


def random_rows(rng, n, lists):
    """Rows of every kind of number, with lists of the lengths that are drawn."""
    rows = np.zeros(n, dtype=[(k, k) for k in KINDS] + [(f"l{i}", "O") for i in lists])
    for kind in KINDS:
        rows[kind] = rng.integers(0, 100, n)
    for i, most in lists.items():
        rows[f"l{i}"] = [
            rng.integers(0, 90, rng.integers(0, most + 1) if i != "same" else most)
            for _ in range(n)
        ]
    return rows


@pytest.mark.parametrize("lists", [{}, {0: 4}, {"same": 3}, {0: 1, 1: 300, "same": 2}])
@pytest.mark.parametrize(("text", "order"), [(True, "="), (False, "<"), (False, ">")])
def test_all_that_plyfile_writes_is_read(tmp_path, text, order, lists):
    rng = np.random.default_rng(len(lists))
    rows = random_rows(rng, 23, lists)
    kinds = {f"l{i}": "i4" for i in lists}
    lengths = {f"l{i}": "u2" for i in lists}
    file = tmp_path / "a.ply"
    plyfile.PlyData(
        [
            plyfile.PlyElement.describe(
                rows, name, len_types=lengths, val_types=kinds, comments=["said"]
            )
            for name in ("vertex", "other")
        ],
        text=text,
        byte_order=order,
        obj_info=["num_rows 5"],
    ).write(str(file))
    with warnings.catch_warnings(action="ignore"):  # plyfile's, of empty lists
        expected = plyfile.PlyData.read(file)
    ply = read_ply(file)
    assert (ply.obj_info, ply.comments) == (("num_rows 5",), ("said", "said"))
    for name in ("vertex", "other"):
        element, rows = ply.elements[name], expected[name].data
        assert element.count == len(rows) == 23
        for kind in KINDS:
            np.testing.assert_array_equal(element.scalars[kind], rows[kind])
        for key in kinds:
            got = element.lists[key]
            np.testing.assert_array_equal(got.counts, [len(x) for x in rows[key]])
            np.testing.assert_array_equal(got.values, np.concatenate(rows[key]))


HEAD = (
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
    "end_header\n"
)
BODY = "0 0 0\n1 0 0\n3 0 1 0\n"


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_lines_may_end_as_on_any_system(tmp_path, ending):
    (tmp_path / "a.ply").write_bytes((HEAD + BODY).replace("\n", ending).encode())
    ply = read_ply(tmp_path / "a.ply")
    np.testing.assert_array_equal(ply.elements["vertex"].scalars["x"], [0, 1])
    np.testing.assert_array_equal(
        ply.elements["face"].lists["vertex_indices"].values, [0, 1, 0]
    )


def test_a_carriage_return_that_is_data_is_not_taken_for_an_ending(tmp_path):
    # 13 and 10 begin the first number, right after the header's own line feed.
    value = np.frombuffer(b"\r\n\r\n", "<f4")
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
    (tmp_path / "a.ply").write_bytes(head + b"end_header\n" + value.tobytes())
    x = read_ply(tmp_path / "a.ply").elements["vertex"].scalars["x"]
    np.testing.assert_array_equal(x, value)


def test_what_is_not_finite_is_left_to_who_needs_it(tmp_path):
    head = HEAD.replace("float z\n", "float z\nproperty float quality\n")
    (tmp_path / "a.ply").write_text(head + "0 0 0 nan\n1 0 0 inf\n3 0 1 0\n")
    vertex = read_ply(tmp_path / "a.ply").elements["vertex"]
    np.testing.assert_array_equal(vertex.scalars["quality"], [np.nan, np.inf])


FAULTS = {
    "another kind": ("solid\n", "does not begin with 'ply'"),
    "no end": (HEAD.replace("end_header\n", ""), "no line 'end_header'"),
    "no format": (HEAD.replace("format ascii 1.0\n", "") + BODY, "lines 'format'"),
    "two formats": (HEAD.replace("ply\n", "ply\nformat ascii 1.0\n", 1), "2 lines"),
    "another format": (HEAD.replace("ascii", "morse") + BODY, "line 2.*no line of a"),
    "another kind of number": (HEAD.replace("float x", "long x"), "line 4.*long x"),
    "lengths with a point": (HEAD.replace("uchar int", "float int"), "line 8.*list"),
    "a property of nothing": ("ply\nformat ascii 1.0\nproperty int x\n" + HEAD[25:],
                              "line 3.*property int x"),
    "a negative count": (HEAD.replace("vertex 2", "vertex -2"), "line 3.*vertex -2"),
    "a huge count": (HEAD.replace("vertex 2", f"vertex 1{'0' * 18}") + BODY,
                     "1000000000000000000 rows of 'vertex', the file has 3 lines"),
    "an endless count": (HEAD.replace("vertex 2", f"vertex {'9' * 9999}") + BODY,
                         "rows of 'vertex', the file has 3 lines"),
    "more rows": (HEAD + BODY + "3 0 1 0\n", "line 13.*more rows"),
    "twice a name": (HEAD.replace("float y", "float x") + BODY, "two are called 'x'"),
    "twice an element": (HEAD.replace("face", "vertex") + BODY, "called 'vertex'"),
    "a short list": (HEAD + BODY.replace("3 0 1 0", "4 0 1 0"), "line 12.*not as long"),
    "a long list": (HEAD + BODY.replace("3 0 1 0", "2 0 1 0"), "line 12.*longer"),
    "an endless list": (HEAD + BODY.replace("3 0 1", f"{'9' * 5000} 0 1"), "line 12"),
    "half a corner": (HEAD + BODY.replace("3 0 1", "3 0 1.5"), "whole numbers.*'1.5'"),
    "a word": (HEAD + BODY.replace("1 0 0", "1 zero 0"), "line 11.*'zero'"),
    "a short row": (HEAD + BODY.replace("1 0 0", "1 0"), "line 11.*expected 3"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_file_is_refused(tmp_path, fault):
    content, message = FAULTS[fault]
    (tmp_path / "a.ply").write_text(content)
    with pytest.raises(MeshError, match=rf"a\.ply.*{message}"):
        read_ply(tmp_path / "a.ply")


BINARY = HEAD.replace("ascii", "binary_little_endian").encode()
ROWS = np.zeros(6, "<f4").tobytes() + b"\x03" + np.array([0, 1, 0], "<i4").tobytes()

BINARY_FAULTS = {
    "huge count": (BINARY.replace(b"vertex 2", b"vertex 1" + b"0" * 18) + ROWS, "room"),
    "huge count of lists": (BINARY.replace(b"face 1", b"face 1" + b"0" * 18) + ROWS,
                            "has room for 13"),
    "more lists": (BINARY.replace(b"face 1", b"face 2") + ROWS, "ends before the 2"),
    "list too long": (BINARY + ROWS[:24] + b"\xff" + ROWS[25:], "ends before the 1"),
    "huge list": (BINARY.replace(b"uchar int", b"uint int") + ROWS[:24] + b"\xff" * 16,
                  "ends before the 1"),
    "negative list": (BINARY.replace(b"uchar", b"int") + ROWS[:24] + b"\xff" * 16,
                      "ends before the 1"),
    "bytes left": (BINARY + ROWS + b"1234", "4 bytes follow"),
}  # fmt: skip


@pytest.mark.parametrize("fault", BINARY_FAULTS)
def test_a_binary_file_is_never_read_beyond_its_end(tmp_path, fault):
    content, message = BINARY_FAULTS[fault]
    (tmp_path / "a.ply").write_bytes(content)
    with pytest.raises(MeshError, match=rf"a\.ply.*{message}"):
        read_ply(tmp_path / "a.ply")
