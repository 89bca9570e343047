"""A machine's rates: measured once, kept, read back, and never believed blindly."""

import dataclasses
import json
import os
import stat
from pathlib import Path

import pytest

from skinviz.rendering import rates
from skinviz.rendering.rates import Rates, machine_rates, measure_rates
from skinviz.rendering.rates_scene import trials

NAMES = [field.name for field in dataclasses.fields(Rates)]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache folder, and rates that nobody has asked for yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    machine_rates.cache_clear()
    yield tmp_path / "cache"
    machine_rates.cache_clear()


@pytest.fixture
def measured(monkeypatch):
    """Rates in the place of measured ones, and how often they were measured."""
    times = []

    def measure():
        times.append(1)
        return Rates(*(float(10 * len(times) + k) for k in range(len(NAMES))))

    monkeypatch.setattr(rates, "measure_rates", measure)
    return times


def kept_file(folder):
    (file,) = (folder / "skinviz").iterdir()
    return file


def again():
    """What another process would be told."""
    machine_rates.cache_clear()
    return machine_rates()


# Kept ---------------------------------------------------------------------------


def test_rates_are_measured_once_and_read_back(folder, measured):
    first = machine_rates()
    assert machine_rates() is first
    assert again() == first
    assert len(measured) == 1
    told = json.loads(kept_file(folder).read_text(encoding="utf-8"))
    assert told == dataclasses.asdict(first)


def test_the_file_tells_version_machine_and_processors(folder, measured, monkeypatch):
    machine_rates()
    name = kept_file(folder).name
    import platform

    import skinviz

    assert skinviz.__version__ in name
    assert platform.machine() in name
    monkeypatch.setattr(rates, "processors", lambda: 1234)
    again()
    assert len(measured) == 2
    assert any("1234" in file.name for file in (folder / "skinviz").iterdir())


def test_without_a_cache_folder_of_its_own_it_is_the_users(tmp_path, monkeypatch):
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    assert rates._cache_file().is_relative_to(tmp_path / ".cache" / "skinviz")
    monkeypatch.setenv("XDG_CACHE_HOME", "")  # which counts as none
    assert rates._cache_file().is_relative_to(tmp_path / ".cache" / "skinviz")


def test_tests_have_a_cache_folder_of_their_own():
    assert not rates._cache_file().is_relative_to(Path.home() / ".cache")


# Broken files -------------------------------------------------------------------


def good():
    return dict.fromkeys(NAMES, 10.0)


BROKEN = {
    "empty": "",
    "half": json.dumps(good())[:40],
    "no object": "[1, 2, 3]",
    "a number": "3.5",
    "nothing": "null",
    "no json": "rates = {}",
    "one missing": json.dumps({k: v for k, v in good().items() if k != "ray"}),
    "one more": json.dumps(good() | {"more": 1.0}),
    "zero": json.dumps(good() | {"ray": 0.0}),
    "negative": json.dumps(good() | {"mix": -1.0}),
    "nan": json.dumps(good() | {"look": float("nan")}),
    "infinite": json.dumps(good() | {"look": float("inf")}),
    "huge": json.dumps(good() | {"bounce": 1e300}),
    "text": json.dumps(good() | {"ray": "fast"}),
    "true": json.dumps(good() | {"ray": True}),
    "a list": json.dumps(good() | {"ray": [1.0]}),
    "an object": json.dumps(good() | {"ray": {"a": 1}}),
    "null": json.dumps(good() | {"ray": None}),
    "deep": "[" * 100_000,
    "large number": '{"ray": 1' + "0" * 5000 + "}",
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_are_no_rates_is_measured_anew_and_written_over(folder, measured, name):
    machine_rates()
    file = kept_file(folder)
    file.write_text(BROKEN[name], encoding="utf-8")
    found = again()
    assert len(measured) == 2
    assert again() == found
    assert len(measured) == 2


@pytest.mark.parametrize("content", [b"\xff\xfe\x00\x01", b"\x00" * 10_000])
def test_bytes_that_are_no_text_are_no_rates(folder, measured, content):
    machine_rates()
    kept_file(folder).write_bytes(content)
    again()
    assert len(measured) == 2


# Folders ------------------------------------------------------------------------


def test_a_folder_in_the_place_of_the_file_is_no_rates(folder, measured):
    machine_rates()
    file = kept_file(folder)
    file.unlink()
    file.mkdir()
    assert again() == Rates(*(20.0 + k for k in range(len(NAMES))))
    assert file.is_dir()


def test_a_file_in_the_place_of_the_folder_costs_a_moment_each_time(folder, measured):
    folder.write_text("no folder")
    machine_rates()
    again()
    assert len(measured) == 2
    assert folder.read_text() == "no folder"


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is unwritable to root")
def test_a_folder_that_cannot_be_written_costs_a_moment_each_time(folder, measured):
    folder.mkdir()
    folder.chmod(stat.S_IRUSR | stat.S_IXUSR)
    try:
        machine_rates()
        again()
        assert len(measured) == 2
    finally:
        folder.chmod(stat.S_IRWXU)


def test_a_full_disk_costs_a_moment_each_time(folder, measured, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    machine_rates()
    again()
    assert len(measured) == 2
    # Nor does half a file stay.
    assert not list((folder / "skinviz").iterdir())


def test_a_user_without_a_folder_keeps_rates_with_temporary_files(
    tmp_path, measured, monkeypatch
):
    def unknown(_):
        raise KeyError

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.delenv("HOME")
    monkeypatch.setattr("pwd.getpwuid", unknown)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    machine_rates()
    again()
    assert len(measured) == 1
    assert list((tmp_path / ".cache" / "skinviz").iterdir())


# Measured -----------------------------------------------------------------------


def test_measured_rates_are_rates():
    found = dataclasses.asdict(measure_rates())
    assert list(found) == NAMES
    # A nanosecond is a few steps of a processor; nothing of these takes a tenth of a
    # millisecond.
    for name, value in found.items():
        assert 0.01 < value < 1e5, name


def test_each_rate_is_measured_of_some_work():
    found = {name: n for name, _, n in trials(16)}
    assert sorted(found) == sorted(NAMES)
    assert all(n > 0 for n in found.values())


def test_the_shortest_time_counts_and_not_the_first(monkeypatch):
    # The first includes compiling.
    clock = iter([0, 1, 10, 19, 20, 25, 30, 37])
    monkeypatch.setattr(rates.time, "perf_counter", lambda: next(clock))
    assert rates._shortest(lambda: None) == 5
    clock = iter([0, 1, 10, 19, 20, 28, 30, 37])
    assert rates._shortest(lambda: None) == 7
