"""The shipped data files are the ones described, and can be rebuilt."""

import gzip
import hashlib
import runpy
from importlib.resources import files
from pathlib import Path

import pytest

DATA = Path(str(files("skinviz.spectra"))) / "data"
SCRIPT = Path(__file__).parents[2] / "scripts" / "make_archives.py"


@pytest.fixture(scope="module")
def make_archives():
    return runpy.run_path(str(SCRIPT))


def sums(folder):
    lines = (folder / "SHA256SUMS").read_text("utf-8").splitlines()
    return {
        name: digest for digest, _, name in (line.partition("  ") for line in lines)
    }


def test_every_shipped_file_has_its_checksum():
    tables = {path.name for path in DATA.iterdir() if ".csv" in path.suffixes}
    assert set(sums(DATA)) == tables
    for name, digest in sums(DATA).items():
        assert hashlib.sha256((DATA / name).read_bytes()).hexdigest() == digest, name


def test_every_shipped_file_has_source_and_licence_beside_it():
    readme = (DATA / "README.md").read_text("utf-8")
    for name in sums(DATA):
        assert f"`{name}`" in readme


def test_archives_are_rebuilt_from_their_sources(make_archives, tmp_path, capsys):
    source, out = tmp_path / "source", tmp_path / "out"
    source.mkdir()
    out.mkdir()
    issa, nist = make_archives["ISSA"], make_archives["NIST"]
    table = gzip.decompress((DATA / issa).read_bytes())
    (source / issa.removesuffix(".gz")).write_bytes(table.replace(b"\n", b"\r\n"))
    (source / nist).write_bytes((DATA / nist).read_bytes())
    make_archives["main"](source, out)
    assert gzip.decompress((out / issa).read_bytes()) == table
    assert (out / nist).read_bytes() == (DATA / nist).read_bytes()
    assert set(sums(out)) == {issa, nist}
    first = (out / issa).read_bytes()
    make_archives["main"](source, out)
    assert "as it was" in capsys.readouterr().out
    assert (out / issa).read_bytes() == first


def test_a_source_that_is_not_as_published_is_refused(make_archives, tmp_path):
    issa, nist = make_archives["ISSA"], make_archives["NIST"]
    (tmp_path / nist).write_bytes((DATA / nist).read_bytes())
    table = gzip.decompress((DATA / issa).read_bytes()).decode()
    for old, new, told in (
        ("0.0877,", "8.77,", "record 1: 8.77 is no reflectance"),
        ("\n8,", "\n7,", "a record is there twice"),
        ("record,origin", "record,source", "the columns are others"),
    ):
        (tmp_path / issa).write_bytes(
            gzip.compress(table.replace(old, new, 1).encode())
        )
        with pytest.raises(SystemExit, match=told):
            make_archives["main"](tmp_path, tmp_path)
        assert not (tmp_path / "SHA256SUMS").exists()
