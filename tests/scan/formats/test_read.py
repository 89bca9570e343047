"""The reader is chosen by the suffix, and what cannot be read is named."""

import numpy as np
import pytest

from meshes import tetrahedron
from skinviz.errors import MeshError
from skinviz.scan.formats import read_mesh, read_scan, write_mesh
from skinviz.scan.formats.read import _READERS

SUFFIXES = tuple(_READERS)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_missing_file_is_named(tmp_path, suffix):
    with pytest.raises(MeshError, match=rf"gone\{suffix}: no such file"):
        read_scan(tmp_path / f"gone{suffix}", "mm")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_empty_file_is_named(tmp_path, suffix):
    file = tmp_path / f"void{suffix}"
    file.touch()
    with pytest.raises(MeshError, match=rf"void\{suffix}: the file is empty"):
        read_scan(file, "mm")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_folder_is_no_file(tmp_path, suffix):
    (tmp_path / f"folder{suffix}").mkdir()
    with pytest.raises(MeshError, match=rf"folder\{suffix}: is a folder"):
        read_scan(tmp_path / f"folder{suffix}", "mm")


JUNK = {
    "zeros": bytes(400),
    "noise": np.random.default_rng(0).bytes(3000),
    "one byte": b"\n",
    "words": b"the quick brown fox\n" * 30,
    "magic words only": b"ply\nOFF\nsolid\n",
    "page": b"<!DOCTYPE html><html><body>404</body></html>",
    "latin": "état à côté\n".encode("latin-1") * 20,
}


@pytest.mark.parametrize("kind", JUNK)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_junk_is_refused_by_name(tmp_path, suffix, kind):
    file = tmp_path / f"junk{suffix}"
    file.write_bytes(JUNK[kind])
    with pytest.raises(MeshError, match=rf"junk\{suffix}"):
        read_scan(file, "mm")


@pytest.mark.parametrize("name", ["hand.xyzzy", "hand", "hand.las", "hand.ply.gz"])
def test_an_unknown_suffix_lists_the_known_ones(tmp_path, name):
    (tmp_path / name).write_text("something")
    with pytest.raises(MeshError, match=rf"{name}.*no reader.*\.conf.*\.vtp"):
        read_scan(tmp_path / name, "mm")


def test_the_suffix_counts_in_either_case(tmp_path):
    write_mesh(tmp_path / "a.ply", tetrahedron())
    (tmp_path / "a.ply").rename(tmp_path / "A.PLY")
    assert read_mesh(tmp_path / "A.PLY").n_cells == 4


def test_a_path_may_be_text(tmp_path):
    write_mesh(tmp_path / "a.ply", tetrahedron())
    scan = read_scan(str(tmp_path / "a.ply"))
    assert scan.source == str(tmp_path / "a.ply")
    assert scan.mesh.n_cells == 4


@pytest.mark.parametrize("suffix", [".ply", ".vtp"])
def test_a_unit_that_contradicts_the_file_is_refused(tmp_path, suffix):
    file = write_mesh(tmp_path / f"hand{suffix}", tetrahedron())
    assert read_scan(file, "mm").mesh.n_cells == 4
    with pytest.raises(MeshError, match=rf"hand\{suffix}.*states its unit as mm"):
        read_scan(file, "m")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_name_longer_than_any_file_has_is_refused(tmp_path, suffix):
    with pytest.raises(MeshError, match=r"xxx.*too long"):
        read_scan(tmp_path / f"{'x' * 5000}{suffix}", "mm")


def test_a_conf_may_not_make_us_open_a_name_too_long(tmp_path):
    for name in ("x" * 5000, "a " + "x" * 5000):
        (tmp_path / "a.conf").write_text(f"bmesh {name} 0 0 0 0 0 0 1\n")
        with pytest.raises(MeshError, match=r"a\.conf line 1"):
            read_scan(tmp_path / "a.conf", "mm")


def test_a_packed_file_is_to_be_unpacked(tmp_path):
    (tmp_path / "a.xyz.gz").write_bytes(b"\x1f\x8b")
    with pytest.raises(MeshError, match=r"a\.xyz\.gz: no reader.*unpack it first"):
        read_scan(tmp_path / "a.xyz.gz", "mm")
