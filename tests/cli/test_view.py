"""``skinviz view``: a link is printed, the page is there, and Ctrl-C ends it."""

import json
import os
import re
import signal
import subprocess
import sys
import urllib.request

import pytest

from meshes import sphere
from skinviz.cli.main import main
from skinviz.scan.formats import write_mesh

SKINVIZ = (sys.executable, "-c", "from skinviz.cli.main import run; run()")
SCENE = """
[mesh]
path = "ball.ply"
unit = "mm"
[skin]
weights = [0.1, 0.008, 0.004]
site = "back of hand"
specular = "included"
[[lights]]
direction = [0, 0, 1]
[view]
direction = [0, 0, 1]
up = [0, 1, 0]
size = [24, 16]
"""


@pytest.fixture
def ball(tmp_path):
    write_mesh(tmp_path / "ball.ply", sphere(40, 2))
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE, encoding="utf-8")
    return scene


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_serves_until_it_is_interrupted(ball, number):
    program = [*SKINVIZ, "view", str(ball), "--no-browser"]
    with subprocess.Popen(
        program,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ,
    ) as running:
        line = running.stdout.readline()
        url = re.search(r"http://127\.0\.0\.1:\d+/\?secret=\S{40,}", line)[0]
        with urllib.request.urlopen(url, timeout=20) as page:
            assert b"<html" in page.read()
        running.send_signal(number)
        out, err = running.communicate(timeout=30)
    assert running.returncode == 0
    assert out.endswith("viewer ended\n")
    assert err == ""


def test_another_address_is_warned_of(ball):
    program = [*SKINVIZ, "view", str(ball), "--no-browser", "--json"]
    with subprocess.Popen(
        [*program, "--host", "127.0.0.2"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        line = running.stdout.readline()
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=30)
    assert json.loads(line)["url"].startswith("http://127.0.0.2:")
    assert err.startswith("warning: listening on 127.0.0.2")
    assert out == ""
    assert running.returncode == 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nowhere.toml"], "no such file"),
        (["--port", "70000"], "port must be"),
        (["--host", "256.1.1.1"], "cannot listen"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(words, told, ball, capsys, monkeypatch):
    monkeypatch.chdir(ball.parent)
    scene = [] if words[0].endswith("toml") else [str(ball)]
    assert main(["view", *scene, *words, "--no-browser"]) == 1
    err = capsys.readouterr().err
    assert told in err
    assert len(err.splitlines()) == 1


def test_without_a_screen_there_is_no_window(ball, capsys, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert main(["view", str(ball), "--native"]) == 1
    assert "--native" in capsys.readouterr().err
