"""A folder of figures: made anew only where something has changed."""

import json
import os
import subprocess
import sys

import pytest

from skinviz.errors import DataError
from skinviz.view.gallery import book, dependencies
from skinviz.view.gallery.book import MANIFEST, digest_of, make_figures
from skinviz.view.gallery.catalogue import NAMES, recipe_of, settings_for
from skinviz.view.gallery.dependencies import data_path, modules_behind


def asked(*names, **changes):
    settings = {"width": None, "seed": 0, "dots": 30} | changes
    return [(recipe_of(n), settings_for(recipe_of(n), **settings)) for n in names]


def fresh(folder, *names, force=False, **changes):
    """Return the names of those figures that were made now."""
    made = make_figures(asked(*names, **changes), folder, force=force)
    return [own.name for own in made if own.fresh]


def test_only_what_changed_is_made_anew(tmp_path):
    both = ("5", "table-1")
    assert fresh(tmp_path, *both) == ["5", "table-1"]
    assert fresh(tmp_path, *both) == []
    assert fresh(tmp_path, *both, force=True) == ["5", "table-1"]
    (tmp_path / "fig_5.csv").write_text("changed", "utf-8")
    assert fresh(tmp_path, *both) == ["5"]
    (tmp_path / "table_1.txt").unlink()
    assert fresh(tmp_path, *both) == ["table-1"]
    assert fresh(tmp_path, "5", width=120.0) == ["5"]


def test_a_changed_source_reaches_those_that_import_it(monkeypatch):
    before = {name: digest_of(*asked(name)[0]) for name in NAMES}
    changed = data_path("skin/data/thickness.csv").parents[1] / "kubelka_munk.py"
    own = book._digest_of_file
    monkeypatch.setattr(
        book,
        "_digest_of_file",
        lambda path: "other" if path == changed else own(path),
    )
    moved = {name for name in NAMES if digest_of(*asked(name)[0]) != before[name]}
    assert {"7", "8", "10", "table-2", "population"} <= moved
    assert "transport" not in moved


def test_a_changed_table_reaches_those_that_read_it(monkeypatch):
    before = {name: digest_of(*asked(name)[0]) for name in NAMES}
    changed = data_path("skin/data/textbook.csv")
    own = book._digest_of_file
    monkeypatch.setattr(
        book,
        "_digest_of_file",
        lambda path: "other" if path == changed else own(path),
    )
    moved = {name for name in NAMES if digest_of(*asked(name)[0]) != before[name]}
    assert moved == {"5", "6", "table-2", "table-3"}


def test_imports_are_followed_into_functions_but_not_into_what_checkers_read():
    behind = {path.name for path in modules_behind("skinviz.view.gallery.fig_7")}
    assert {"fig_7.py", "kubelka_munk.py", "solver.py", "page.py"} <= behind
    assert "tradeoff.py" not in behind
    assert dependencies._file_of("skinviz.nothing") is None


@pytest.mark.parametrize("name", ["1a", "6", "transport", "table-1"])
def test_what_is_read_is_what_is_declared(name):
    """Shipped files that making a figure opens, seen by Python itself."""
    program = (
        "import sys, pathlib, skinviz\n"
        "from skinviz.view.gallery.catalogue import figure\n"
        "seen = set()\n"
        "sys.addaudithook(lambda event, args: seen.add(str(args[0]))"
        " if event == 'open' else None)\n"
        f"figure({name!r}, dots=30).draw()\n"
        "print(*(p for p in seen if '/skinviz/' in p and '/data/' in p), sep='\\n')"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    told = subprocess.run(
        [sys.executable, "-c", program],
        check=True,
        capture_output=True,
        text=True,
        env=environment,
    ).stdout.split()
    declared = {str(data_path(file)) for file in recipe_of(name).files}
    assert told
    assert set(told) <= declared


def test_the_manifest_tells_what_was_asked(tmp_path):
    fresh(tmp_path, "6", width=100.0)
    entry = json.loads((tmp_path / MANIFEST).read_text("utf-8"))["figures"]["6"]
    assert (entry["width_mm"], entry["dots"], entry["seed"]) == (100.0, 30, 0)
    assert set(entry["files"]) == {
        f"fig_6.{s}" for s in ("png", "svg", "pdf", "csv", "txt")
    }


@pytest.mark.parametrize("content", ["no json", "[]", '{"format": "other"}', "{}"])
def test_a_manifest_that_is_none_is_refused(tmp_path, content):
    (tmp_path / MANIFEST).write_text(content, "utf-8")
    with pytest.raises(DataError, match="remove it"):
        fresh(tmp_path, "table-1")
    assert [file.name for file in tmp_path.iterdir()] == [MANIFEST]


def test_progress_is_told(tmp_path):
    told = []
    list(make_figures(asked("table-1", "5"), tmp_path, begin=told.append))
    assert told == ["table-1", "5"]
    parts = []

    def counting(total):
        parts.append(total)
        return parts.append

    list(make_figures(asked("8"), tmp_path, counting=counting))
    assert parts == [2, 1, 1]


def test_a_missing_shipped_file_is_told():
    with pytest.raises(DataError, match="install skinviz anew"):
        data_path("skin/data/none.csv")
