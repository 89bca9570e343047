"""``skinviz measure`` as a user meets it, at simulated instruments."""

import io
import json
import os
import sys

import numpy as np
import pytest
from benches import bench

import skinviz
from skinviz.cli.main import main
from skinviz.cli.measure_hands import Asking, in_words, requests
from skinviz.cli.measure_screen import LiveScreen, Screen, plotted, scatter, screen
from skinviz.instruments.arrangement import Arrangement
from skinviz.instruments.errors import NoReply, Stopped
from skinviz.instruments.meters import Reading
from skinviz.instruments.plan import Step
from skinviz.instruments.simulate.pr655 import SimulatedPR655
from skinviz.instruments.simulate.serve import serve
from skinviz.skin.scale_error import fit_uncertain_scale

SIM = ["--port", "sim://pr655"]
QUICK = """
[session]
subject = "P07"
sites = ["cheek"]
[geometry]
illumination = {geometry}
states = {states}
viewing = {viewing}
[readings]
repeats = 2
warm_up = false
"""


@pytest.fixture
def log(tmp_path):
    return tmp_path / "a.skinlog"


def _plan(tmp_path, geometry="[45]", states='["open"]', viewing=0):
    path = tmp_path / "plan.toml"
    path.write_text(QUICK.format(geometry=geometry, states=states, viewing=viewing))
    return ["--plan", str(path)]


def test_a_session_is_measured_exported_and_told(log, tmp_path, capsys):
    out = tmp_path / "hand.nc"
    words = ["measure", str(log), *SIM, "--yes", "--export", str(out)]
    assert main([*words, "--site", "back of hand", "--subject", "P01"]) == 0
    said = capsys.readouterr()
    assert "P01: " in said.out
    assert "back of hand" in said.out
    assert str(out) in said.out
    assert "[5/5] white after, 45/0 degrees" in said.err
    spectra = skinviz.read_spectra(out)
    assert spectra.attrs["specular"] == "excluded"
    assert spectra.attrs["source"] == str(log)


def test_a_fit_takes_the_measured_uncertainty(log, tmp_path, capsys):
    out = tmp_path / "hand.nc"
    plan = _plan(tmp_path, states='["parallel", "crossed"]')
    assert main(["measure", str(log), *SIM, *plan, "--yes", "--export", str(out)]) == 0
    capsys.readouterr()
    assert main(["fit", str(out), "--site", "back of hand", "--json"]) == 0
    weights = json.loads(capsys.readouterr().out)["fits"][0]["parameters"]
    truth = dict(zip(("w_m", "w_h", "w_dh"), (0.12, 0.006, 0.004), strict=True))
    spectra = skinviz.read_spectra(out)
    model = skinviz.skin_model(site="back of hand", specular="excluded")
    assert spectra.attrs["scale_uncertainty"] == pytest.approx(0.002 / 0.985)
    expected = fit_uncertain_scale(
        spectra.reflectance.values[0],
        spectra.wavelength.values,
        model,
        scale=spectra.attrs["scale_uncertainty"],
        uncertainty=spectra.uncertainty.values[0],
    )
    for i, (name, weight) in enumerate(weights.items()):
        assert weight["lower"] == pytest.approx(expected.interval[i, 0], rel=1e-9)
        assert weight["value"] == pytest.approx(truth[name], rel=0.15)


def test_a_lobe_is_measured_with_a_stage_and_fitted(log, tmp_path, capsys):
    plan = _plan(tmp_path, "{from = 0, to = 80, step = 20}", '["s", "p"]', 60)
    out = tmp_path / "gonio.csv"
    words = ["measure", str(log), *SIM, "--stage", "sim://zaber", "--home", *plan]
    assert main([*words, "--yes", "--gonio", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["lobe"]["gamma"]["value"] == pytest.approx(0.27, rel=0.05)
    assert said["lobe"]["surface"]["model"] == "torrance-sparrow"
    assert skinviz.read_gonio(out).specular.size == 5
    assert main(["measure", str(log), "--gonio", str(out)]) == 0
    assert "[surface]" in capsys.readouterr().out


def test_the_skin_of_a_scene_is_simulated(log, tmp_path, capsys):
    scene = tmp_path / "s.toml"
    mesh = "docs/../meshes/makehuman_male_right.ply"
    scene.write_text(
        f'[mesh]\npath = "{_root() / mesh}"\nunit = "m"\n'
        '[skin]\nweights = [0.3, 0.01, 0.004]\nsite = "cheek"\nspecular = "excluded"\n'
        '[surface]\nmodel = "lambert"\n'
        '[[lights]]\nilluminant = "D65"\n[view]\nangles = "0/0"\n',
        "utf-8",
    )
    words = ["measure", str(log), *SIM, *_plan(tmp_path), "--yes", "--json"]
    assert main([*words, "--simulate", str(scene), "--seed", "3"]) == 0
    told = json.loads(capsys.readouterr().out)["spectra"][0]
    model = skinviz.skin_model(site="cheek", specular="excluded")
    expected = model.measured([0.3, 0.01, 0.004], np.arange(380, 781, 4))
    assert told["reflectance_median"] == pytest.approx(np.median(expected), rel=0.02)


def _root():
    from pathlib import Path

    return Path(__file__).parents[2]


def test_an_interrupted_session_goes_on(log, tmp_path, capsys):
    port = "sim://pr655?fault=&fault=&fault=&fault=&fault=over"
    words = ["measure", str(log), "--yes", *_plan(tmp_path), "--port"]
    assert main([*words, port]) == 1
    assert "too much light" in capsys.readouterr().err
    assert main(["measure", str(log)]) == 1
    assert "--resume" in capsys.readouterr().err
    assert main([*words, port]) == 1
    assert "exists" in capsys.readouterr().err
    assert main(["measure", str(log), *SIM, "--yes", "--resume"]) == 0
    assert "P07: 12 readings" in capsys.readouterr().out


def test_a_log_without_a_name_is_named_by_its_time(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["measure", *SIM, "--yes", *_plan(tmp_path)]) == 0
    (made,) = tmp_path.glob("20*.skinlog")
    assert made.name in capsys.readouterr().out


def test_ports_are_listed(monkeypatch, capsys):
    from skinviz.instruments import serial_ports as ports

    assert main(["measure", "--list", "--json"]) == 0
    assert "sim://pr655" in json.loads(capsys.readouterr().out)["simulated"]
    found = (ports.Port("/dev/ttyACM0", "PR-655", "0861:1003", "612"),)
    monkeypatch.setattr(ports, "list_ports", lambda: found)
    assert main(["measure", "--list"]) == 0
    assert "/dev/ttyACM0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "name the session's log"),
        (["a.log"], ".skinlog"),
        (["a.skinlog"], "no such file"),
        (["a.skinlog", "--yes"], "--yes is for measuring"),
        (["a.skinlog", "--port", "/dev/no", "--yes"], "simulated instruments"),
        (["a.skinlog", "--port", "/dev/no"], "--white"),
        (["a.skinlog", "--port", "/dev/no", "--resume"], "no such file"),
        (["a.skinlog", "--port", "auto", "--meter", "pr650"], "--port"),
        (["a.skinlog", *SIM, "--stage", "/dev/no", "--yes"], "both be"),
        (["a.skinlog", *SIM, "--resume", "--site", "x"], "--resume"),
        (["a.skinlog", "--port", "sim://pr9"], "choose one of"),
        (["a.skinlog", *SIM, "--stage", "sim://pr650"], "one of: zaber"),
        (["a.skinlog", *SIM, "--export", "a.doc"], "suffix of --export"),
        (["a.skinlog", *SIM, "--gonio", "a.nc"], "suffix of --gonio"),
        (["a.skinlog", "--port", "sim://pr655?time=slow"], "quick, real"),
    ],
)
def test_wrong_words_are_one_line(words, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["measure", *words]) == 1
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("skinviz: ")
    assert told in last
    assert not list(tmp_path.iterdir())


def test_a_person_is_asked_and_may_stop(log, tmp_path, monkeypatch, capsys):
    words = ["measure", str(log), *SIM, *_plan(tmp_path)]
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n" * 20))
    assert main(words) == 0
    asked = capsys.readouterr().err
    assert asked.index("white tile") < asked.index("Place the skin, cheek")
    assert "Shutter the lamp" in asked
    assert asked.count("Turn the lamp to 45 degrees") == 1
    log.unlink()
    monkeypatch.setattr(sys, "stdin", io.StringIO("\nq\n"))
    assert main(words) == 1
    assert "--resume" in capsys.readouterr().err
    log.unlink()
    for nobody in (io.StringIO(""), None):
        monkeypatch.setattr(sys, "stdin", nobody)
        assert main(words) == 1
        assert "--yes" in capsys.readouterr().err
        log.unlink()


def test_a_port_by_its_name_is_measured_at_with_a_certificate(
    log, tmp_path, monkeypatch, capsys
):
    on = bench()
    tile = tmp_path / "tile.csv"
    rows = [f"{nm:g},{factor:.6f},0.001" for nm, factor in zip(*on.tile, strict=True)]
    tile.write_text("wavelength_nm,factor,uncertainty\n" + "\n".join(rows), "utf-8")
    plan = _plan(tmp_path)
    text = (tmp_path / "plan.toml").read_text() + "ambient = false\n"
    (tmp_path / "plan.toml").write_text(text)
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n" * 9))
    out = tmp_path / "a.nc"
    with serve(SimulatedPR655(on)) as server:
        words = ["measure", str(log), "--port", server.url, *plan, "--export", str(out)]
        assert main([*words, "--white", str(tile)]) == 0
    # Nobody moved the white tile away, so the sample is the tile.
    found = skinviz.read_spectra(out)
    expected = np.interp(found.wavelength, *on.tile)
    np.testing.assert_allclose(found.reflectance.values[0], expected, rtol=3e-3)
    assert "61234567" in capsys.readouterr().out


def test_only_what_differs_is_asked_for():
    asked = []
    hands = Asking(asked.append, None, turns=True)
    first = Arrangement("white", True, 45.0, 0.0, "crossed")
    hands.arrange(first, "white before")
    assert len(asked.pop()) == 5
    hands.arrange(first, "white before")
    assert not asked
    hands.arrange(Arrangement("sample", True, -30.0, 0.0, "open"), "cheek")
    skin, lamp, off = asked.pop()
    assert "cheek" in skin
    assert "meter's side" in lamp
    assert "polarisers off" in off
    silent = requests(
        (first, "x"), Arrangement("white", True, 10.0, 0.0, "crossed"), "x", turns=False
    )
    assert not list(silent)
    assert in_words(first, "cheek") == "cheek, 45/0 degrees, polarisers crossed"


def test_a_spectrum_is_drawn_to_its_size():
    nm = np.linspace(380, 780, 101)
    lines = plotted(nm, np.sin((nm - 380) / 400 * np.pi), width=40, height=6)
    assert len(lines) == 7
    body = [line.split("│")[1] for line in lines[:-1]]
    assert {len(row) for row in body} == {40}
    dots = np.array([[ord(c) - 0x2800 for c in row] for row in body])
    assert dots[0, 18:22].all()  # the top is in the middle
    assert dots[-1, [0, -1]].all()
    assert not dots[-1, 15:25].any()
    assert plotted(nm, np.zeros(101))  # darkness too


@pytest.mark.parametrize(("width", "height"), [(100, 30), (60, 24), (40, 15), (25, 8)])
def test_the_screen_fits_its_terminal(width, height):
    from rich.console import Console

    text = io.StringIO()
    console = Console(file=text, width=width, height=height)
    shown = LiveScreen(console)
    shown.close()
    shown.begins(Step(1, "white before", Arrangement()), 10)
    nm = np.arange(380.0, 781.0, 4.0)
    reading = Reading(nm, nm / 1e6, 0.1, (), b"")
    shown.read(Step(1, "white before", Arrangement()), [reading] * 3, 5)
    console.print(shown._panel())
    lines = text.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    assert len(lines) <= height
    assert any("scatter" in line for line in lines)
    drawn = [line for line in lines if "│\u2800" in line]
    assert bool(drawn) == (width >= 40)
    assert any("780 nm" in line for line in lines) == bool(drawn)


@pytest.mark.parametrize("poor", [{"TERM": "dumb"}, {"PYTHONIOENCODING": "ascii"}])
def test_terminals_that_cannot_draw_get_lines(poor, monkeypatch):
    class Terminal(io.TextIOWrapper):
        def isatty(self):
            return True

    monkeypatch.setenv("TERM", poor.get("TERM", "xterm"))
    encoding = poor.get("PYTHONIOENCODING", "utf-8")
    monkeypatch.setattr(sys, "stderr", Terminal(io.BytesIO(), encoding=encoding))
    with screen(quiet=False) as shown:
        assert type(shown) is Screen


def test_words_are_no_answer(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdin", io.StringIO("no\nwait\n\n"))
    Screen().ask(["Open the shutter"])
    assert capsys.readouterr().err.count("Press Enter") == 3


def test_what_was_typed_before_a_question_is_no_answer(monkeypatch):
    master, slave = os.openpty()
    os.write(master, b"\n\n\n")
    monkeypatch.setattr(Screen, "_write", lambda *_, **__: os.write(master, b"q\n"))
    with os.fdopen(slave, "r") as terminal:
        monkeypatch.setattr(sys, "stdin", terminal)
        with pytest.raises(Stopped):
            Screen().ask([])
        monkeypatch.undo()
    os.close(master)


def test_the_scatter_of_repeats():
    whole, band = scatter([np.array([1.0, 1.0]), np.array([1.1, 0.9])])
    assert whole == pytest.approx(0)
    assert band == pytest.approx(np.std([1, 1.1], ddof=1))
    assert scatter([np.zeros(3), np.zeros(3)]) == (0, 0)


def test_the_live_screen_shows_step_spectrum_and_error(monkeypatch):
    from rich.console import Console

    shown = io.StringIO()
    live = LiveScreen(Console(file=shown, force_terminal=True, width=100))
    step = Step(1, "cheek", Arrangement("sample", True, 45.0, 0.0, "open"))
    live.begins(step, 5)
    nm = np.linspace(380, 780, 101)
    reading = Reading(nm, np.ones(101), 0.5, ("low light",), b"")
    live.read(step, [reading, reading], 5)
    live.failed(NoReply("nothing came; check the cable"))
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n"))
    live.ask(["Open the shutter"])
    live.close()
    text = shown.getvalue()
    for word in ("2 of 5: cheek", "reading 2 of 5", "low light", "made good: nothing"):
        assert word in text


def test_a_torn_line_is_told_and_kept_told(log, tmp_path, capsys):
    words = ["measure", str(log), *SIM, "--yes"]
    assert main([*words, *_plan(tmp_path)]) == 0
    log.write_bytes(log.read_bytes()[:-3])
    capsys.readouterr()
    assert main(["measure", str(log)]) == 0
    told = capsys.readouterr().out
    assert "bytes of a torn last line are lost" in told
    assert main([*words, "--resume"]) == 0
    assert "bytes of a torn last line are lost" in capsys.readouterr().out


def test_a_setting_that_is_refused_leaves_no_log(log, tmp_path, capsys):
    plan = tmp_path / "long.toml"
    plan.write_text("[readings]\nexposure = 30\n", "utf-8")
    assert main(["measure", str(log), *SIM, "--yes", "--plan", str(plan)]) == 1
    assert "change it or leave it out" in capsys.readouterr().err
    assert not log.exists()


@pytest.mark.parametrize("begun", [False, True])
def test_an_interruption_says_what_there_is(begun, log, monkeypatch, capsys):
    def interrupted(*_):
        if begun:
            log.touch()
        raise KeyboardInterrupt

    monkeypatch.setattr("skinviz.cli.measure_bench.measured", interrupted)
    assert main(["measure", str(log), *SIM, "--yes"]) == 1
    told = capsys.readouterr().err
    assert ("--resume" in told) == begun
    assert ("before anything was measured" in told) != begun
