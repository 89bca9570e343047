"""Measure pigment maps, texture and relief on the shipped hand.

Run in the development environment: ``python scripts/benchmarks/maps.py``. Times are the
best of five, each beside the time of something that is known in the same run.
"""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from _print import machine

from skinviz import Plan, SkinTexture, landmarks, pigment_map, read_scene, render
from skinviz import textured as with_texture
from skinviz.scan import topology
from skinviz.scene.geodesics import Surface, surface_of
from skinviz.scene.landmarks import NAMES

SCENE = Path(__file__).parents[2] / "docs/examples/cyanosis.toml"
RUNS = 5
TEXTURE = SkinTexture(
    melanin_mottling=0.06,
    blood_mottling=0.08,
    mottling_mm=2.5,
    veins=0.02,
    knuckle_redness=0.2,
    crease_redness=0.5,
    relief_um=30,
    seed=3,
)


def main() -> None:
    """Print what is measured."""
    print(f"{machine()}\n")
    scene = read_scene(SCENE)
    mesh, surface = scene.mesh, surface_of(scene.mesh)
    found = landmarks(mesh, surface)
    exactness(mesh, surface, found)
    took = {
        "landmarks": best(lambda: landmarks(mesh)),
        f"map of {len(NAMES)} points": best(
            lambda: pigment_map(mesh, points_of(found))
        ),
        "texture": best(lambda: with_texture(scene, TEXTURE)),
    }
    even, rough = scene, with_texture(scene, SkinTexture(relief_um=30))
    for name, own in (("even", even), ("with relief", rough)):
        took[f"16 rays a pixel, {name}"] = best(
            lambda own=own: render(own, Plan(spectrum="scene", reflectance="vertices"))
        )
        took[f"tolerance 1, {name}"] = best(lambda own=own: render(own))
    print(f"\n{mesh.n_points} vertices, {scene.camera.size} pixels")
    for name, seconds in took.items():
        print(f"{name:<30}{1e3 * seconds:8.0f} ms")


def points_of(found, seed: int = 1) -> dict:
    """Return weights that differ much at every named point."""
    rng = np.random.default_rng(seed)
    return {vertex: np.exp(rng.normal(-3, 1, 3)) for vertex in found.values()}


def exactness(mesh, surface: Surface, found) -> None:
    """Print how exact, positive and smooth maps of random points are."""
    edges, _ = topology.edge_counts(surface.faces)
    a, b = edges.T
    length = np.linalg.norm(surface.points[a] - surface.points[b], axis=1)
    sites = list(found.values())
    apart = surface.distances(sites)[:, sites]
    worst = steepest = 0.0
    lowest = np.inf
    for seed in range(RUNS):
        points = points_of(found, seed)
        values = pigment_map(mesh, points, surface)
        given = np.array(list(points.values()))
        worst = max(worst, float(np.abs(values[sites] / given - 1).max()))
        lowest = min(lowest, float((values / given.min(axis=0)).min()))
        slope = np.abs(values[a] - values[b]).max(axis=1) / length
        rise = np.abs(given[:, None] - given).max(axis=2)
        asked = np.divide(rise, apart, out=np.zeros_like(rise), where=apart > 0)
        steepest = max(steepest, float(slope.max() / asked.max()))
    print(f"largest relative error at a point     {worst:.1e}")
    print(f"smallest weight over the smallest given {lowest:.3f}")
    print(f"steepest slope over the steepest between two points {steepest:.2f}")


def best(work: Callable[[], object]) -> float:
    """Return the shortest time of some runs. [s]"""
    times = []
    for _ in range(RUNS):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


if __name__ == "__main__":
    main()
