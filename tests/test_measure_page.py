"""The page on measuring: its commands run as they stand, and lead where it says."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import skinviz
from skinviz.cli.main import main

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "measure.md").read_text("utf-8")


def _blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.M | re.S)


def _commands():
    for block in _blocks("bash"):
        for command in block.replace("\\\n", " ").splitlines():
            name, *words = shlex.split(command)
            assert name == "skinviz"
            yield words


@pytest.mark.slow
def test_the_page_leads_from_the_bench_to_a_hand(tmp_path, monkeypatch, capsys):
    for name in ("docs", "meshes"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    (scene,) = _blocks("toml")
    Path("measured.toml").write_text(scene, "utf-8")
    said = ""
    for words in _commands():
        assert main(words) == 0, words
        said += capsys.readouterr().out

    truth = skinviz.read_scene("docs/examples/scene.toml")
    weights = json.loads(Path("hand.json").read_text("utf-8"))["fits"][0]["parameters"]
    for value, weight in zip(truth.skin.values, weights.values(), strict=True):
        assert weight["lower"] <= value <= weight["upper"]
    measured = skinviz.read_scene("measured.toml").surface
    assert measured.gamma == pytest.approx(truth.surface.gamma, rel=0.005)
    assert "gamma 0.27" in said
    assert Path("hand.png").read_bytes().startswith(b"\x89PNG")
    assert skinviz.read_spectra("hand.spdx").sizes["record"] == 1

    (code,) = _blocks("python")
    names = {}
    exec(compile(code, "docs/measure.md", "exec"), names)
    inside = np.isfinite(names["spectra"].uncertainty.values)
    assert inside.all()
    assert names["derived"].parts
