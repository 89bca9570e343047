"""Measure how fast scenes become radiance and colour, beside how exactly.

Run in the development environment: ``python scripts/benchmarks/rendering.py``. Each
time is the shortest of several, and stands as a ratio to something measured in the
same run. ``--large`` also streams an 8192 × 8192 cube (16 GB) to the disk.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from _print import HEAD, Row, line, machine, race

from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    Scene,
    Skin,
    TorranceSparrow,
    geometry_of,
    hand_frame,
    render,
    skin_model,
)
from skinviz.rendering import rays, trace
from skinviz.rendering.shade import vertex_radiance, vertex_rgb, vertex_xyz
from skinviz.rendering.stage import Stage, stage_of
from skinviz.scan.formats import read_mesh
from skinviz.scan.shipped import shipped_mesh

HAND = "makehuman_male_right.ply"
VERTICES = 200_000
RAYS = 2**16
RUNS = 9


def main() -> None:
    """Print each figure, or with ``--peak`` what one picture takes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--peak", type=int, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.peak:
        print(peak(chosen.peak))
        return
    print(f"{machine()}\n\n{HEAD}", flush=True)
    measured = [vertex_rows, picture_rows, memory_rows]
    for rows in [*measured, streamed] if chosen.large else measured:
        for row in rows():
            print(line(row), flush=True)


def hand(size: int = 1024, degrees: float = 30.0) -> Scene:
    """Return a lit hand of uniform skin."""
    mesh = read_mesh(shipped_mesh(HAND), "m")
    frame = hand_frame(mesh)
    model = skin_model(site="back of hand", specular="included")
    return Scene(
        mesh=mesh,
        skin=Skin(model, np.array([0.1, 0.0086, 0.0041])),
        surface=TorranceSparrow(),
        lights=(DirectionalLight(frame.direction(np.deg2rad(degrees))),),
        camera=Camera(frame.back, frame.fingers, (size, size)),
    )


def vertex_rows() -> list[Row]:
    """Return the times of 200,000 vertices, and how well colours agree."""
    scene = hand()
    fine = scene.mesh.subdivide(2, "linear")
    mesh = fine.decimate(1 - VERTICES / fine.n_points)
    stage = stage_of(scene.replace(mesh=mesh), Plan(shadows=False, spectrum="scene"))
    n = mesh.n_points
    share = VERTICES / n
    out = np.zeros((n, scene.wavelengths.size), dtype=np.float32)
    turned = iter(np.linspace(0, 1, 10_000))

    def move() -> None:
        light = DirectionalLight([0.1, np.sin(next(turned)), 1])
        vertex_rgb(stage.relit([light]))

    took = race(
        {
            "fill": lambda: out.fill(1),
            "radiance": lambda: vertex_radiance(stage, out),
            "fresh fill": lambda: np.full_like(out, 1),
            "fresh radiance": lambda: vertex_radiance(stage),
            "move": move,
        },
        RUNS,
    )
    vertex_radiance(stage, out)
    xyz = vertex_xyz(stage)
    summed = out.astype(np.float64) @ stage.bands.spectra.colour
    apart = np.abs(summed - xyz).max(initial=0) / xyz.max()
    return [
        Row(
            f"61-band radiance of vertices over filling the array ({n:,} vertices), "
            "array at hand; array made anew",
            "1.2 ×",
            f"{took['radiance'] / took['fill']:.2f} ×; "
            f"{took['fresh radiance'] / took['fresh fill']:.2f} × "
            f"({1e3 * took['radiance'] * share:.1f} and "
            f"{1e3 * took['fresh radiance'] * share:.1f} ms for 200,000)",
        ),
        Row(
            "8-bit sRGB of 200,000 vertices after the light moves, new light and all",
            "3 ms",
            f"{1e3 * took['move'] * share:.1f} ms",
        ),
        Row(
            "XYZ of the factors against that of the bands, over the largest",
            "1e-6",
            f"{apart:.1e}",
        ),
    ]


def picture_rows() -> list[Row]:
    """Return the time of a picture with its cube over that of its bare rays."""
    scene, plan = hand(), Plan(samples=1)
    geometry = geometry_of(scene.mesh)
    picture = render(scene, plan, geometry=geometry)
    cube = np.zeros((1024, 1024, scene.wavelengths.size), dtype=np.float32)
    queries, hits = bare(stage_of(scene, plan, geometry))
    took = race(
        {
            "queries": queries,
            "cube": lambda: picture.radiance(out=cube),
            "colours": lambda: render(scene, plan, geometry=geometry),
        },
        RUNS,
    )
    return [
        Row(
            f"1024 × 1024, shadows, 61 bands, one sample ({hits:,} hits), over the "
            "bare Embree queries of the same rays",
            "1.5 ×",
            f"{took['cube'] / took['queries']:.2f} × ({1e3 * took['cube']:.0f} ms); "
            f"colours alone {took['colours'] / took['queries']:.2f} ×",
        )
    ]


def bare(stage: Stage) -> tuple[Callable[[], None], int]:
    """Return what casts a picture's rays and nothing else, and how many hit."""
    width, height = stage.sight.view.size
    pixels, n = np.arange(width * height), width * height
    origins, directions = (np.zeros((n, 3), np.float32) for _ in range(2))
    size = np.array(stage.sight.view.size)
    cells = stage.plan.cells
    rays.start_rays(stage.sight.frame, size, cells, pixels, origins, directions)
    hits = trace.cast(stage.sight, cells, pixels)
    m = hits.pixels.size
    starts, ways = (np.zeros((m, 3), np.float32) for _ in range(2))
    lengths, asked = np.zeros(m, np.float32), np.zeros(m, np.int64)
    light = stage.bands.lighting.lights[0]
    m = rays.shadow_rays(
        hits.lifted, hits.normals, hits.facets, light, asked, starts, ways, lengths
    )
    embree = stage.geometry.embree

    def parts(n: int) -> list[slice]:
        return [slice(i, min(i + RAYS, n)) for i in range(0, n, RAYS)]

    def run() -> None:
        with ThreadPoolExecutor(2) as pool:
            list(
                pool.map(
                    lambda i: embree.run(origins[i], directions[i], query="INTERSECT"),
                    parts(n),
                )
            )
            list(
                pool.map(
                    lambda i: embree.run(starts[i], ways[i], query="OCCLUDED"),
                    parts(m),
                )
            )

    return run, m


def memory_rows() -> list[Row]:
    """Return what a picture and its cube take at most, in a process of their own."""
    for _ in range(2):  # the first may have to compile
        run = subprocess.run(
            [sys.executable, __file__, "--peak", "1024"],
            check=True,
            capture_output=True,
            text=True,
        )
    total, cube = (float(word) for word in run.stdout.split()[-2:])
    return [
        Row(
            "peak memory of the process, 1024 × 1024 × 61, over the cube's 256 MB",
            "500 MB",
            f"{total - cube:.0f} MB",
        )
    ]


def peak(size: int) -> str:
    """Return the process's peak and the cube's size after a picture. [MB]"""
    cube = render(hand(size)).radiance()
    return f"{resident():.0f} {cube.nbytes / 2**20:.0f}"


def resident() -> float:
    """Return the most memory that this process has had. [MB]

    ``getrusage`` would tell that of the process which started it, where it had more.
    """
    told = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    (line,) = (line for line in told if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


def streamed() -> list[Row]:
    """Return what an 8192 × 8192 cube takes, written row by row."""
    code = (
        "import sys; sys.path.insert(0, sys.argv[1]);"
        "from rendering import *;"
        "p = render(hand(8192), Plan(samples=1)); p.save(sys.argv[2] + '/hand.png');"
        "p.save(sys.argv[2] + '/hand.hdr');"
        "print(resident() / 1024)"
    )
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        run = subprocess.run(
            [sys.executable, "-c", code, str(Path(__file__).parent), folder],
            check=True,
            capture_output=True,
            text=True,
        )
        seconds = time.perf_counter() - start
        size = (Path(folder) / "hand.bip").stat().st_size
    return [
        Row(
            f"peak memory, 8192 × 8192 × 61 ({size / 1e9:.1f} GB) and its picture to "
            "the disk",
            "2 GiB",
            f"{float(run.stdout):.2f} GiB, {seconds:.0f} s",
        )
    ]


if __name__ == "__main__":
    main()
