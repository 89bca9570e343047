"""``skinviz tradeoff``: a scene file to a table and a figure, all or nothing."""

import csv
import io
import json

import pytest
from PIL import Image

from meshes import sphere
from skinviz.cli.main import main
from skinviz.cli.tradeoff import SETTINGS
from skinviz.rendering.plan import Plan
from skinviz.scan.formats import write_mesh

BALL = """
[mesh]
path = "ball.ply"
unit = "mm"
[skin]
weights = [0.1, 0.008, 0.004]
site = "back of hand"
specular = "included"
[[lights]]
illuminant = "D65"
direction = [0.2, 0, 1]
[view]
direction = [0, 0, 1]
up = [0, 1, 0]
size = [48, 32]
"""


@pytest.fixture
def scene(tmp_path):
    """A scene file of a sphere."""
    write_mesh(tmp_path / "ball.ply", sphere(40, 2))
    file = tmp_path / "scene.toml"
    file.write_text(BALL, encoding="utf-8")
    return file


def test_a_scene_becomes_a_table_and_figures(scene, tmp_path, capsys):
    out = tmp_path / "trade"
    assert main(["tradeoff", str(scene), "-o", str(out), "--size", "24"]) == 0
    told = capsys.readouterr()
    names = ["tradeoff.csv", "tradeoff.png", "tradeoff.svg"]
    assert sorted(file.name for file in out.iterdir()) == names
    assert all(str(out / name) in told.out for name in names)
    for tolerance in ("0.1", "0.2", "0.5", "1", "2", "5"):
        assert f"plan for ΔE00 {tolerance} " in told.out
    assert "NOT KEPT" not in told.out
    assert "[4/4] write" in told.err
    with Image.open(out / "tradeoff.png") as picture:
        assert picture.width > 1500
    assert (out / "tradeoff.svg").read_bytes().startswith(b"<?xml")

    text = (out / "tradeoff.csv").read_text("utf-8")
    head = [line for line in text.splitlines() if line.startswith("# ")]
    assert "scene.toml, 24 × 16 pixels, 61 bands" in head[0]
    assert any(line.startswith("# machine: ") for line in head)
    rows = list(csv.DictReader(io.StringIO(text[text.index("group,") :])))
    first = rows[0]
    assert first["group"] == "reference"
    assert float(first["delta_e_max_filled"]) == float(first["spectral_rmse"]) == 0
    for name in SETTINGS:
        value = getattr(Plan(), name)
        assert first[name] == ("" if value is None else str(value))
    planned = [row for row in rows if row["group"] == "tolerance"]
    assert [float(row["tolerance"]) for row in planned] == [0.1, 0.2, 0.5, 1, 2, 5]
    for row in planned:
        assert row["kept"] == "True"
        assert float(row["delta_e_max_filled"]) <= float(row["tolerance"])
        assert float(row["ms"]) > 0
        assert float(row["planning_ms"]) > 0
    assert any(row["on_front"] == "True" for row in rows)


def test_json_holds_the_rows(scene, tmp_path, capsys):
    out = tmp_path / "trade"
    words = ["tradeoff", str(scene), "-o", str(out), "--size", "16", "--json"]
    assert main(words) == 0
    told = json.loads(capsys.readouterr().out)
    assert [file.rsplit(".")[-1] for file in told["files"]] == ["csv", "png", "svg"]
    groups = {row["group"] for row in told["ways"]}
    assert groups >= {"reference", "plain", "uniform", "one knob", "tolerance"}
    assert told["ways"][0]["samples"] == 16
    assert "processors" in told["machine"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("direction = [0.2, 0, 1]", "direction = [0, 0, -1]", "no light to compare"),
        ('"D65"', '"D66"', "D65"),
        ("size = [48, 32]", "size = [0, 32]", "camera size"),
    ],
)
def test_a_scene_without_a_picture_leaves_no_file(
    scene, tmp_path, capsys, old, new, told
):
    scene.write_text(BALL.replace(old, new), encoding="utf-8")
    out = tmp_path / "trade"
    assert main(["tradeoff", str(scene), "-o", str(out)]) == 1
    assert told in capsys.readouterr().err.strip().splitlines()[-1]
    assert not out.exists()


def test_a_file_is_no_folder(scene, capsys):
    assert main(["tradeoff", str(scene), "-o", str(scene)]) == 1
    assert "name a folder" in capsys.readouterr().err
    assert scene.read_text("utf-8") == BALL
