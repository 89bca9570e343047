"""What all files of pictures have in common, whatever the format."""

import json
import os
import resource

import numpy as np
import pytest
from pictures import METADATA, MadePicture

from skinviz.errors import ArgumentError, DataError, SkinvizError
from skinviz.rendering.files import read_picture_metadata, write_picture
from skinviz.rendering.formats import FORMATS

SUFFIXES = list(FORMATS)


def contents(folder):
    return {entry.name: entry.read_bytes() for entry in folder.iterdir()}


@pytest.fixture(params=SUFFIXES)
def suffix(request):
    """Every suffix that a picture can have."""
    return request.param


# --- how it was made -----------------------------------------------------------


def test_how_it_was_made_comes_back(tmp_path, suffix):
    file = write_picture(tmp_path / "new" / f"hände{suffix.upper()}", MadePicture())
    assert read_picture_metadata(str(file)) == METADATA


@pytest.mark.parametrize(
    "metadata",
    [
        {},
        {"title": None},
        {"title": "a" * 100_000},
        {"title": "two\nlines\x00 and \x1b[31m more \u2028"},
        {"path": os.fsdecode(b"\xff.ply"), "title": os.fsdecode(b"\xff")},
        {"text": "\U0001f590 " * 1000, "units": "none"},
        {"units": {"radiance": "}{"}, "numbers": [1e308, -5e-324, 2**70, True, 0.1]},
        {"a" * 1000: {"b": [{"c": []}, {}, [None]]}},
        {"": ""},
        {"whole": "x" * (2**20 - 13)},
    ],
)
def test_whatever_json_can_hold_comes_back(tmp_path, suffix, metadata):
    file = write_picture(tmp_path / f"a{suffix}", MadePicture(metadata=metadata))
    assert read_picture_metadata(file) == metadata


@pytest.mark.parametrize(
    ("metadata", "told"),
    [
        ({"a": {"b": [0, np.nan]}}, r"metadata\.a\.b\[1\] is nan \(float\)"),
        ({"a": -np.inf}, r"metadata\.a is -inf"),
        ({"a": np.zeros(3)}, r"metadata\.a is .* \(ndarray\)"),
        ({"a": ({"b": {1, 2}},)}, r"metadata\.a\[0\]\.b is .* \(set\)"),
        ({"a": {3: 4}}, r"a key of metadata\.a is 3 \(int\)"),
        ({"a": np.float32(1)}, r"metadata\.a is 1\.0 \(float32\)"),
        (
            {"few": [1] * 9, "skin": {"name": "x", "weights": [0.25] * 300_000}},
            r"are 1\.7 MiB, at most of it in metadata\.skin\.weights; .* name a file",
        ),
    ],
)
def test_what_it_cannot_hold_is_refused_by_name(tmp_path, suffix, metadata, told):
    with pytest.raises(ArgumentError, match=told):
        write_picture(tmp_path / f"a{suffix}", MadePicture(metadata=metadata))
    assert not list(tmp_path.iterdir())


def test_a_file_of_others_does_not_say_how_it_was_made(tmp_path, suffix):
    file = write_picture(tmp_path / f"a{suffix}", MadePicture())
    text = json.dumps(METADATA).encode()
    if suffix == ".hdr":
        content = file.read_bytes().replace(b"skinviz picture", b"another picture")
    else:  # the text loses its braces
        assert text in file.read_bytes()
        content = file.read_bytes().replace(text, b"[" + text[1:-1] + b"]")
    file.write_bytes(_with_checksum(content) if suffix == ".png" else content)
    with pytest.raises(DataError, match="does not say how it was made"):
        read_picture_metadata(file)


def _with_checksum(content):
    """Return a PNG file's content with the checksums of its chunks as they must be."""
    import struct
    import zlib

    at, parts = 8, [content[:8]]
    while at < len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        body = content[at + 4 : at + 8 + length]
        parts += [content[at : at + 4], body, struct.pack(">I", zlib.crc32(body))]
        at += 12 + length
    return b"".join(parts)


def test_broken_files_are_refused(tmp_path, suffix):
    """Whatever bytes a file has: what it says comes back, or one DataError."""
    file = write_picture(tmp_path / f"a{suffix}", MadePicture())
    whole = file.read_bytes()
    rng = np.random.default_rng(0)
    cut = [whole[: int(n)] for n in rng.integers(1, len(whole), 60)]
    other = [rng.bytes(200), b"x", bytes(300)]
    changed = []
    for _ in range(300):
        content = bytearray(whole)
        for _ in range(3):
            content[rng.integers(min(len(whole), 1200))] = rng.integers(256)
        changed.append(bytes(content))
    refused = 0
    for content in cut + other + changed:
        file.write_bytes(content)
        try:
            read_picture_metadata(file)
        except DataError:
            refused += 1
    assert refused >= len(other)


# --- names ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("a.pgn", r"'\.pgn' is none of them; did you mean '\.png'\?"),
        ("a.tfi", r"did you mean '\.tif'\?"),
        ("a.jpg", r"pictures are \.png, \.tif, \.tiff, \.exr, \.hdr; '\.jpg' is none"),
        ("a", "'no suffix' is none of them"),
        ("a.bip", r"give a\.hdr"),
        ("a.IMG", r"give a\.hdr"),
    ],
)
def test_an_unknown_suffix_lists_the_known(tmp_path, name, told):
    with pytest.raises(ArgumentError, match=told):
        write_picture(tmp_path / name, MadePicture())
    assert not list(tmp_path.iterdir())
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(DataError, match=told):
        read_picture_metadata(tmp_path / name)


def test_a_missing_or_empty_file_has_no_metadata(tmp_path, suffix):
    with pytest.raises(DataError, match="no such file"):
        read_picture_metadata(tmp_path / f"a{suffix}")
    (tmp_path / f"a{suffix}").touch()
    with pytest.raises(DataError, match="the file is empty"):
        read_picture_metadata(tmp_path / f"a{suffix}")


# --- whole or not at all -------------------------------------------------------


@pytest.fixture
def full_disk():
    """Let no file become larger than some bytes, as the end of a disk would."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def limit(size):
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))

    yield limit
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("existed", [True, False])
@pytest.mark.parametrize("size", [1, 500, 40_000])
def test_a_full_disk_leaves_what_was_there(tmp_path, suffix, full_disk, existed, size):
    file = tmp_path / f"a{suffix}"
    large = MadePicture((128, 128))
    write_picture(tmp_path / f"warm{suffix}", large)  # libraries are loaded
    if existed:
        write_picture(file, MadePicture())
    before = contents(tmp_path)
    full_disk(size)
    with pytest.raises(SkinvizError, match=r"cannot write .*: File too large; write t"):
        write_picture(file, large)
    full_disk(resource.RLIM_INFINITY)
    assert contents(tmp_path) == before


def test_a_picture_that_breaks_off_leaves_what_was_there(tmp_path, suffix):
    """Rows and colours are computed while they are written."""

    class StoppedError(Exception):
        pass

    class Broken(MadePicture):
        def _stop(self, *_):
            raise StoppedError

        def rows(self, advance=None):  # noqa: ARG002
            yield self.radiance[:2]
            raise StoppedError

        rgb = rgb16 = property(_stop)

    file = write_picture(tmp_path / f"a{suffix}", MadePicture())
    before = contents(tmp_path)
    with pytest.raises(StoppedError):
        write_picture(file, Broken())
    assert contents(tmp_path) == before


def test_a_folder_of_that_name_is_told_before_anything_is_computed(tmp_path, suffix):
    (tmp_path / f"a{suffix}").mkdir()

    class Asked(MadePicture):
        def rows(self, advance=None):  # noqa: ARG002
            pytest.fail("nothing may be computed")

    with pytest.raises(SkinvizError, match="it is a folder; give the name of a file"):
        write_picture(tmp_path / f"a{suffix}", Asked())


def test_a_folder_that_cannot_be_written_is_told(suffix):
    with pytest.raises(SkinvizError, match="cannot write /proc/skinviz/a"):
        write_picture(f"/proc/skinviz/a{suffix}", MadePicture())


def test_every_row_is_told_once(tmp_path, suffix):
    told = []
    write_picture(tmp_path / f"a{suffix}", MadePicture(), told.append)
    assert sum(told) == 5


def test_the_same_picture_makes_the_same_file(tmp_path, suffix):
    first = write_picture(tmp_path / f"a{suffix}", MadePicture())
    other = write_picture(tmp_path / f"b{suffix}", MadePicture())
    assert first.read_bytes() == other.read_bytes()
