"""How quick the viewer is, in the browser and before it: ``viewer.py [--moves N]``.

A hand of 200,000 triangles. The server's time for a moved slider is from the state to
the encoded picture with everything that is told beside it; the browser's is from the
change on the page to the picture drawn there. The first picture counts from the
command. The moves for the memory are of every control at random.
"""

import argparse
import asyncio
import json
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

from skinviz import read_mesh, write_mesh
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.surface.models import surface_models
from skinviz.view.viewer.app import Viewer
from skinviz.view.viewer.controls import CONTROLS, with_surface, with_weight
from skinviz.view.viewer.frames import quick_frame
from skinviz.view.viewer.opened import Opened, open_path
from skinviz.view.viewer.pictures import Darkroom
from skinviz.view.viewer.server import start
from skinviz.view.viewer.state import ViewState

TRIANGLES = 200_000
SIZE = {"width": 1280, "height": 720}
SCENE = """
[mesh]
path = "hand.ply"
unit = "mm"
[skin]
archive = "issa"
origin = "China"
subject = "186"
site = "back of hand"
"""
PICTURE = "[data-test=picture]"
MOVES = {
    "light_angle": [(37 * i) % 80 + 1 for i in range(110)],
    "weight_0": [0.02 + 0.001 * ((37 * i) % 80) for i in range(110)],
    "view_angle": [(37 * i) % 80 + 1 for i in range(110)],
}

# From a change of a control on the page until its picture has been decoded.
MOVE = """
async ([name, value]) => {
  const image = document.querySelector('[data-test=picture]');
  const seen = new Promise((resolve) => image.addEventListener(
    'load', resolve, { once: true }));
  const begun = performance.now();
  window.trame.state.set(name, value);
  await seen;
  await image.decode();
  return performance.now() - begun;
}
"""


def main() -> None:
    """Print the figures, as JSON at the end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--moves", type=int, default=0, help="random moves for memory")
    asked = parser.parse_args()
    figures = {}
    with tempfile.TemporaryDirectory() as folder:
        scene = large_scene(Path(folder))
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium"),
                args=["--no-sandbox", "--disable-dev-shm-usage"],
            )
            # Started once before: compiled code is kept from then on.
            runs = [first_picture(browser, scene) for _ in range(3)]
            figures["first picture after the command (s)"] = min(runs)
            opened = open_path(scene)
            figures |= in_browser(browser, opened)
            browser.close()
        figures |= on_server(opened)
        if asked.moves:
            figures[f"growth over {asked.moves} random moves (MB)"] = growth(
                opened, asked.moves
            )
    print(json.dumps(figures, indent=2))


def large_scene(folder: Path) -> Path:
    """Write the scene of a hand with many triangles."""
    mesh = read_mesh(shipped_mesh(TRUE_SHAPE), "m").subdivide(1)
    mesh = mesh.decimate(1 - TRIANGLES / mesh.n_cells)
    write_mesh(folder / "hand.ply", mesh)
    scene = folder / "scene.toml"
    scene.write_text(SCENE, encoding="utf-8")
    return scene


def first_picture(browser, scene: Path) -> float:
    """Return the time from the command to the picture on the page. [s]"""
    words = ("-c", "from skinviz.cli.main import run; run()", "view", str(scene))
    begun = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, *words, "--no-browser"], stdout=subprocess.PIPE, text=True
    ) as running:
        url = re.search(r"http://\S+", running.stdout.readline())[0]
        page = browser.new_page(viewport=SIZE)
        page.goto(url)
        page.wait_for_selector(PICTURE)
        taken = time.perf_counter() - begun
        page.close()
        running.terminate()
    return round(taken, 2)


def on_server(opened: Opened) -> dict[str, str]:
    """Return what moves take on the server, with no browser at work beside it."""
    darkroom, told = Darkroom(opened), {}
    for name, values in MOVES.items():
        times, shown = [], None
        for value in values:
            state = set_to(opened, name, value)
            begun = time.perf_counter()
            shown, _ = quick_frame(darkroom, state, (660, 650), shown)
            times.append(1e3 * (time.perf_counter() - begun))
        told[f"{name} moved, server alone (ms)"] = in_words(times[10:])
    return told


def set_to(opened: Opened, name: str, value: float) -> ViewState:
    """Return the first state with one control moved."""
    if name == "weight_0":
        return with_weight(opened.initial, opened.own, 0, value)
    return CONTROLS[name][1](opened.initial, value)


def in_browser(browser, opened: Opened) -> dict[str, str]:
    """Return what moves take until the page shows them, on the same machine."""
    ready, loop = threading.Event(), asyncio.new_event_loop()
    running, ended = [], asyncio.Event()

    async def serve():
        running.append(start())
        await running[0].answering()
        await running[0].show(lambda: opened)
        ready.set()
        await ended.wait()
        await running[0].stop()

    thread = threading.Thread(target=lambda: loop.run_until_complete(serve()))
    thread.start()
    ready.wait()
    page = browser.new_page(viewport=SIZE)
    page.goto(running[0].url)
    page.wait_for_selector(f"{PICTURE}[data-still=true]")
    told = {}
    for name, values in MOVES.items():
        whole = [page.evaluate(MOVE, [name, value]) for value in values]
        told[f"{name} moved, until the browser shows it (ms)"] = in_words(whole[10:])
    page.close()
    loop.call_soon_threadsafe(ended.set)
    thread.join()
    return told


def in_words(times: list[float]) -> str:
    """Return the median and the least of some times."""
    return f"{statistics.median(times):.1f}, least {min(times):.1f}"


def growth(opened: Opened, n: int) -> float:
    """Return how much memory random moves leave taken. [MB]"""
    rng = np.random.default_rng(1)

    async def move() -> float:
        from trame.app import get_server

        viewer = Viewer(opened, get_server("growth", client_type="vue3"))
        viewer.size = (640, 640)
        viewer.begin()
        before = 0.0
        for i in range(n):
            viewer.change(lambda state: moved(state, opened, rng))
            await until_shown(viewer)
            if i == n // 10:  # caches are full by now
                before = resident()
        await viewer.close()
        return round(resident() - before, 1)

    return asyncio.run(move())


async def until_shown(viewer: Viewer) -> None:
    """Wait until the present state is shown."""
    while viewer.shown is None or viewer.shown.state != viewer.state:
        await asyncio.sleep(0.002)


def moved(state: ViewState, opened: Opened, rng: np.random.Generator) -> ViewState:
    """Return the state with one control moved at random."""
    angle, tilt = float(rng.uniform(-90, 90)), float(rng.uniform(-40, 40))
    changes = [
        lambda: state.replace(light=(angle, tilt)),
        lambda: state.replace(view=(angle, tilt, 0.0)),
        lambda: state.replace(zoom=float(rng.uniform(0.8, 3))),
        lambda: state.replace(exposure=float(rng.uniform(0.5, 2))),
        lambda: state.replace(illuminant=str(rng.choice(["A", "D50", "D65", "FL2"]))),
        lambda: with_surface(state, opened, str(rng.choice(surface_models()))),
        lambda: state.with_hands(int(rng.choice([1, 2, 4]))),
        lambda: state.with_look(weights=tuple(rng.uniform(0.001, 0.2, 3).tolist())),
        lambda: state.replace(white=str(rng.choice(["none", "cat16"]))),
    ]
    return changes[rng.integers(len(changes))]()


def resident() -> float:
    """Return the memory that this process holds. [MB]"""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


if __name__ == "__main__":
    main()
