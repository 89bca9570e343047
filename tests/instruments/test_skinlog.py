"""Logs: whole lines, torn ends, damage, one writer, full disks."""

import contextlib
import errno
import json
import os
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinviz.errors import DataError, SkinvizError
from skinviz.instruments.skinlog import LogWriter, line_of, read_log, record_of

HEADER = {
    "utc": "2026-01-01T00:00:00+00:00",
    "plan": {},
    "certificate": {},
    "meter": {"maker": "λ", "model": "", "serial": ""},
}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.skinlog"


def _written(path, n=3):
    with LogWriter.create(path, HEADER) as log:
        for i in range(n):
            log.append({"kind": "note", "i": i})
    return path.read_bytes()


def test_what_is_written_is_read(path):
    content = _written(path)
    log = read_log(path)
    assert log.header == {"kind": "header", "schema": "skinlog 1", **HEADER}
    assert [r["i"] for r in log.records] == [0, 1, 2]
    assert log.torn == 0
    line = content.splitlines()[1]
    body, crc = line[: line.rindex(b',"crc"')], json.loads(line)["crc"]
    assert int(crc, 16) == zlib.crc32(body)


@given(st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False)))
def test_numbers_come_back_to_the_last_digit(record):
    assert record_of(line_of({"kind": "x"} | record)) == {"kind": "x"} | record


@given(data=st.data())
def test_any_cut_leaves_the_lines_before_it(data, tmp_path_factory):
    path = tmp_path_factory.mktemp("cut") / "a.skinlog"
    content = _written(path)
    ends = [i + 1 for i, byte in enumerate(content) if byte == ord("\n")]
    cut = data.draw(st.integers(ends[0], len(content)))
    path.write_bytes(content[:cut])
    log = read_log(path)
    whole = sum(end <= cut for end in ends) - 1
    assert [r["i"] for r in log.records] == list(range(whole))
    assert log.torn == cut - ends[whole]
    writer, before = LogWriter.reopen(path)
    with writer:
        assert before.torn == log.torn
        writer.append({"kind": "note", "i": 9})
    assert [r["i"] for r in read_log(path).records] == [*range(whole), 9]


@given(at=st.integers(0, 10_000), bit=st.integers(0, 7))
def test_damage_is_refused_or_cuts_the_end(tmp_path_factory, at, bit):
    path = tmp_path_factory.mktemp("bit") / "a.skinlog"
    content = bytearray(_written(path))
    content[at % len(content)] ^= 1 << bit
    path.write_bytes(content)
    with contextlib.suppress(DataError):
        log = read_log(path)
        assert log.torn
        assert [r["i"] for r in log.records] in ([0, 1], [0])


def test_a_damaged_line_in_the_middle_is_named(path):
    path.write_bytes(_written(path).replace(b'"i":1', b'"i":7'))
    with pytest.raises(DataError, match="line 3: damaged"):
        read_log(path)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "empty"),
        (b"hello\n", "not a session's log"),
        (line_of({"kind": "header", "schema": "skinlog 9"}), "skinlog 9"),
        (line_of({"kind": "note"}), "this version reads"),
    ],
)
def test_other_files_are_refused(path, content, told):
    path.write_bytes(content)
    with pytest.raises(DataError, match=told):
        read_log(path)


def test_a_log_is_never_overwritten_and_has_its_suffix(path):
    _written(path)
    with pytest.raises(SkinvizError, match="--resume"):
        LogWriter.create(path, HEADER)
    with pytest.raises(SkinvizError, match="skinlog"):
        LogWriter.create(path.with_suffix(".json"), {})
    assert [p.name for p in path.parent.iterdir()] == ["a.skinlog"]


def test_a_log_is_begun_where_files_have_one_name_only(path, monkeypatch):
    def refused(*_):
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", refused)
    with LogWriter.create(path, HEADER) as log:
        log.append({"kind": "note"})
    assert len(path.read_bytes().splitlines()) == 2
    with pytest.raises(SkinvizError, match="--resume"):
        LogWriter.create(path, HEADER)
    assert [p.name for p in path.parent.iterdir()] == ["a.skinlog"]


def test_only_one_program_writes(path):
    with LogWriter.create(path, HEADER), pytest.raises(SkinvizError, match="another"):
        LogWriter.reopen(path)
    LogWriter.reopen(path)[0].close()


def test_a_full_disk_leaves_whole_lines(path, monkeypatch):
    log = LogWriter.create(path, HEADER)
    write = os.write
    monkeypatch.setattr(os, "write", lambda handle, data: write(handle, data[:9]))
    with pytest.raises(SkinvizError, match="No space"):
        log.append({"kind": "note"})

    def full(*_):
        raise OSError(errno.EDQUOT, "Disk quota exceeded")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(SkinvizError, match="free some space"):
        log.append({"kind": "note"})
    monkeypatch.undo()
    log.append({"kind": "note", "i": 1})
    log.close()
    assert [r.get("i") for r in read_log(path).records] == [1]


READING = {"kind": "reading", "t": 1.0, "begun": 0.5, "segment": 0, "step": 0}
READING |= {"repeat": 0, "grid": 0, "radiance": [1.0, 2.0]}
GRID = {"kind": "grid", "grid": 0, "wavelengths": [400.0, 500.0]}


@pytest.mark.parametrize(
    ("records", "told"),
    [
        ([{"t": 1.0}], "line 2: it says no kind"),
        ([{"kind": "grid", "grid": 0}], "line 2: its grid has no right 'wavelengths'"),
        ([GRID, READING | {"step": None}], "line 3: its reading has no right 'step'"),
        ([READING], "line 2: its reading is on a grid"),
        ([GRID, READING | {"radiance": [1.0]}], "line 3: its reading is on a grid"),
    ],
)
def test_records_that_lack_what_is_read_are_refused_by_line(path, records, told):
    with LogWriter.create(path, HEADER) as log:
        for record in records:
            log.append(record)
    with pytest.raises(DataError, match=told):
        read_log(path)


@pytest.mark.parametrize("change", [{"plan": 3}, {"meter": {}}, {"certificate": None}])
def test_a_header_that_lacks_what_is_read_is_refused(path, change):
    LogWriter.create(path, HEADER | change).close()
    with pytest.raises(DataError, match=r"line 1: its .*version that wrote it"):
        read_log(path)


def test_kinds_of_later_versions_are_passed(path):
    with LogWriter.create(path, HEADER) as log:
        for record in (GRID, {"kind": "weather"}, READING):
            log.append(record)
    assert len(read_log(path).records) == 3
