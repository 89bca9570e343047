"""``skinviz figure``: figures by name into a folder."""

import json

import pytest

from skinviz.cli.main import main
from skinviz.view.gallery.catalogue import NAMES


def test_figures_are_made_and_then_left(tmp_path, capsys):
    words = ["figure", "6", "table-1", "--out", str(tmp_path), "--size", "100"]
    assert main(words) == 0
    told = capsys.readouterr()
    assert "[1/2] 6" in told.err
    assert str(tmp_path / "fig_6.svg") in told.out
    names = {file.name for file in tmp_path.iterdir()}
    assert {"fig_6.png", "fig_6.csv", "table_1.txt", "figures.json"} <= names
    assert main([*words, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["figures"]
    assert [(row["name"], row["made"]) for row in rows] == [
        ("6", False),
        ("table-1", False),
    ]
    assert main([*words, "--force", "--json"]) == 0
    assert all(row["made"] for row in json.loads(capsys.readouterr().out)["figures"])


def test_the_list_tells_all(capsys):
    assert main(["figure", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(NAMES)
    assert main(["figure", "7", "--list", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["figures"]
    assert row["formats"] == [".png", ".svg", ".pdf"]
    assert "CC BY 4.0" in row["credit"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["77", "--out", "x"], "unknown figure '77'"),
        (["populaton", "--out", "x"], "did you mean 'population'"),
        (["all", "77", "--out", "x"], "unknown figure '77'"),
        ([], "name a figure, or all"),
        (["7"], "--out"),
        (["7", "--out", "x", "--size", "20"], "width of a figure"),
    ],
)
def test_wrong_use_is_one_line(tmp_path, monkeypatch, capsys, words, told):
    monkeypatch.chdir(tmp_path)
    assert main(["figure", *words]) == 1
    error = capsys.readouterr().err.strip()
    assert told in error
    assert len(error.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_file_is_no_folder(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("x", "utf-8")
    assert main(["figure", "6", "--out", str(file)]) == 1
    assert "name a folder" in capsys.readouterr().err
