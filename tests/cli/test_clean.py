"""``skinviz clean``: steps from a file, a report, a picture, several files."""

import json

import pytest

from meshes import toy_hand
from skinviz.cli.main import DONE, FAILED, MISUSED, main
from skinviz.scan.formats import read_mesh, write_mesh

STEPS = """
[[step]]
name = "repair"
[[step]]
name = "remesh"
edge_length = 6.0
[[step]]
name = "check"
"""


@pytest.fixture
def hand(tmp_path):
    return write_mesh(tmp_path / "hand.ply", toy_hand())


def test_steps_report_and_preview_are_as_asked(tmp_path, hand, capsys):
    (tmp_path / "steps.toml").write_text(STEPS)
    out, report, picture = (tmp_path / n for n in ("out.ply", "r.json", "p.png"))
    words = [
        "clean",
        str(hand),
        "-o",
        str(out),
        "--steps",
        str(tmp_path / "steps.toml"),
    ]
    words += ["--report", str(report), "--preview", str(picture), "--memory", "2"]
    assert main(words) == DONE
    done = json.loads(report.read_text())["steps"]
    assert [step["name"] for step in done] == ["repair", "remesh", "check"]
    mean = done[1]["counts"]["mean_edge_mm"]
    assert mean == pytest.approx(6, rel=0.15)
    assert read_mesh(out).n_points == done[1]["counts"]["points"]
    assert picture.read_bytes().startswith(b"\x89PNG")
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:2]] == ["repair", "remesh"]


def test_a_wrong_step_is_told_in_one_line_before_any_work(tmp_path, hand, capsys):
    (tmp_path / "steps.toml").write_text("[[step]]\nname = 'polish'\n")
    words = ["clean", str(hand), "-o", str(tmp_path / "out.ply")]
    assert main([*words, "--steps", str(tmp_path / "steps.toml")]) == FAILED
    told = capsys.readouterr().err
    assert "there is no step 'polish'" in told
    assert "choose from triangulate, align" in told
    assert not (tmp_path / "out.ply").exists()


def test_two_meshes_are_not_cleaned_together(tmp_path, hand, capsys):
    words = ["clean", str(hand), str(hand), "-o", str(tmp_path / "out.ply")]
    assert main(words) == FAILED
    assert (
        "only files of range views can be cleaned together" in capsys.readouterr().err
    )


def test_no_file_is_wrong_usage(tmp_path):
    assert main(["clean", "-o", str(tmp_path / "out.ply")]) == MISUSED
