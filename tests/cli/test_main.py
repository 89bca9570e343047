"""The program as a user meets it: exit codes, one-line errors, help, JSON."""

import json

import numpy as np
import pytest

from skinviz.cli.main import VERBS, main
from skinviz.skin.models import skin_model

WAVELENGTHS = np.arange(400, 701, 10)


@pytest.fixture
def spectrum_file(tmp_path):
    model = skin_model(site="cheek", specular="included")
    values = model.measured([[0.1, 0.008, 0.004], [0.3, 0.01, 0.0]], WAVELENGTHS).T
    rows = ["wavelength_nm,first,second"]
    rows += [
        f"{nm},{a:.9f},{b:.9f}" for nm, (a, b) in zip(WAVELENGTHS, values, strict=True)
    ]
    path = tmp_path / "skin.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


FIT = ["--site", "cheek", "--specular", "included"]


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help_with_an_example(verb, capsys):
    assert main([verb, "--help"]) == 0
    said = capsys.readouterr().out
    assert f"Example: skinviz {verb}" in said.replace("\n", " ").replace("  ", " ")
    assert "--json" in said


def test_help_lists_the_verbs(capsys):
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    assert all(verb in said for verb in VERBS)


@pytest.mark.parametrize(
    "words",
    [
        ["frobnicate"],
        ["fit"],
        ["fit", "x.csv", "--nonsense"],
        ["clean", "x.ply"],
        ["clean", "x.ply", "-o", "y.ply", "--edge-length", "long"],
    ],
)
def test_wrong_usage_ends_with_2(words, capsys):
    assert main(words) == 2
    told = capsys.readouterr()
    assert (told.out + told.err).strip()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["fit", "missing.csv", *FIT], "missing.csv: no such file"),
        (["clean", "missing.ply", "-o", "x.ply"], "missing.ply: no such file"),
        (["render", "missing.toml", "-o", "x.png"], "missing.toml: no such file"),
        (["info", "missing.toml"], "missing.toml: no such file"),
        (["clean", "missing.ply", "-o", "x.docx"], "choose one of: .ply, .vtp"),
        (["render", "missing.toml", "-o", "x.bmp"], "choose one of: .png, .tif"),
    ],
)
def test_an_error_is_one_line_and_ends_with_1(words, expected, capsys):
    assert main(words) == 1
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("skinviz: ")
    assert expected in last


def test_fit_prints_json_and_writes_what_a_scene_can_read(
    spectrum_file, tmp_path, capsys
):
    out = tmp_path / "fit.json"
    assert main(["fit", str(spectrum_file), *FIT, "-o", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert [fit["label"] for fit in said["fits"]] == ["first", "second"]
    weights = said["fits"][0]["parameters"]
    found = [weights[name]["value"] for name in ("w_m", "w_h", "w_dh")]
    np.testing.assert_allclose(found, [0.1, 0.008, 0.004], rtol=1e-4)
    assert said["fits"][1]["status"] == "at_bound"
    assert json.loads(out.read_text("utf-8"))["format"] == "skinviz fit 1"


def test_fit_writes_csv_and_a_plot(spectrum_file, tmp_path, capsys):
    out, plot = tmp_path / "fit.csv", tmp_path / "fit.png"
    words = ["fit", str(spectrum_file), *FIT, "-o", str(out), "--plot", str(plot)]
    assert main(words) == 0
    header, *rows = out.read_text("utf-8").splitlines()
    assert header.startswith("label,status,")
    assert len(rows) == 2
    assert plot.read_bytes().startswith(b"\x89PNG")
    said = capsys.readouterr().out
    assert str(out) in said
    assert str(plot) in said


def test_a_refused_fit_leaves_no_output(tmp_path, capsys):
    bad, out = tmp_path / "bad.csv", tmp_path / "fit.json"
    rows = [f"{nm},{25 + nm / 100:.2f}" for nm in WAVELENGTHS]
    bad.write_text("wavelength_nm,a\n" + "\n".join(rows), encoding="utf-8")
    assert main(["fit", str(bad), *FIT, "-o", str(out)]) == 1
    assert "--scale percent" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv"]
    assert main(["fit", str(bad), *FIT, "-o", str(out), "--scale", "percent"]) == 0


def test_the_file_may_say_how_the_surface_was_measured(spectrum_file, capsys):
    site = ["--site", "cheek"]
    assert main(["fit", str(spectrum_file), *site]) == 1
    assert "--specular" in capsys.readouterr().err
    noted = "# specular: included\n" + spectrum_file.read_text("utf-8")
    spectrum_file.write_text(noted, encoding="utf-8")
    assert main(["fit", str(spectrum_file), *site, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["specular"] == "included"


def test_an_interrupt_is_one_line_and_ends_with_130(monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("skinviz.view.gallery.catalogue.recipe_of", interrupted)
    assert main(["figure", "5", "--out", "x"]) == 130
    assert capsys.readouterr().err == "skinviz: interrupted\n"
