"""Measure whether plans keep their tolerance, and what speed they buy.

Run in the development environment: ``python scripts/benchmarks/plan.py --seeds 200 -o
plan.jsonl``. Each scene is made of its seed (``_plan_scenes.py``) and compared with
its reference as ``skinviz.rendering.tolerance`` has it. What is done already in the
file is not done again; ``--summary`` only sums up.

The reference of mapped skin is the model at 401 wavelengths for sixteen points a pixel,
which takes a minute for a large picture. It is looked up in a table instead, whose XYZ
are within 1e-6 of white (ΔE00 5e-5, measured on three scenes); with ``--literal`` not.
"""

import argparse
import json
import time
import warnings
from pathlib import Path

import numpy as np
from _plan_scenes import scene_of, textured_scene_of
from _print import machine

from skinviz import Plan, geometry_of, plan, render
from skinviz.rendering import tints
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.tolerance import compare

TOLERANCES = (0.2, 0.5, 1.0, 2.0)
PLAIN = Plan(samples=1, spectrum="scene", basis="points")
FACTORISED = Plan(samples=16, spectrum="scene")
UNIFORM = (1, 2, 4, 8, 16)
_FINE_SHARE = 1e-6  # of white, by which the reference's table may be off


def main() -> None:
    """Try all seeds, then sum up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--summary", action="store_true")
    parser.add_argument("--kept-only", action="store_true", help="time nothing")
    parser.add_argument("--textured", action="store_true", help="uneven skin")
    parser.add_argument("--literal", action="store_true", help="no table, see above")
    parser.add_argument("-o", "--out", type=Path, required=True)
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    done = {row["seed"] for row in rows_of(chosen.out)}
    if not chosen.summary:
        render(scene_of(0))  # compiles
        for seed in range(chosen.first, chosen.seeds):
            if seed in done:
                continue
            row = tried(
                (textured_scene_of if chosen.textured else scene_of)(seed),
                seed,
                chosen.runs,
                timed=not chosen.kept_only,
                literal=chosen.literal,
            )
            with chosen.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
            print(told(row), flush=True)
    summarise(rows_of(chosen.out))


def rows_of(file: Path) -> list[dict]:
    """Return what was measured before."""
    if not file.exists():
        return []
    return [json.loads(line) for line in file.read_text("utf-8").splitlines()]


def tried(scene, seed: int, runs: int, *, timed: bool, literal: bool) -> dict:
    """Return how one scene fares at every tolerance, and what the rivals take."""
    geometry = geometry_of(scene.mesh)
    _ = geometry.embree, geometry.edges
    white = white_xyz(scene)
    begun = time.perf_counter()
    reference = reference_of(scene, geometry, literal=literal)
    took = 1e3 * (time.perf_counter() - begun)

    def difference(picture):
        return compare(picture.xyz, reference.xyz, reference.covered, white)

    def timing(*given, n=runs):
        times = []
        for _ in range(n):
            begun = time.perf_counter()
            picture = render(scene, *given, geometry=geometry)
            times.append(1e3 * (time.perf_counter() - begun))
        return picture, min(times)

    row = {
        "seed": seed,
        "size": scene.camera.size,
        "mapped": scene.skin.values.ndim > 1,
        "bounce": scene.interreflection != "none",
        "lamp": scene.lights[0].spectrum.name,
        "reference_ms": took,
        "tolerances": {},
    }
    for tolerance in TOLERANCES:
        begun = time.perf_counter()
        made = plan(scene, tolerance, geometry=geometry)
        planning = 1e3 * (time.perf_counter() - begun)
        picture, ms = timing(None, tolerance)
        own = difference(picture)
        row["filled"], row["edges"] = own.n_filled, own.n_edge
        row["tolerances"][str(tolerance)] = {
            "kept": own.kept(tolerance),
            "filled": own.filled,
            "edge": own.edge,
            "most": own.most_filled,
            "most_edge": own.most_edge,
            "ms": ms,
            "planning_ms": planning,
            "plan": settings(picture.plan),
            "uniform_ms": None,
        }
        if timed:
            row["tolerances"][str(tolerance)]["uniform_ms"] = cheapest_uniform(
                made, tolerance, timing, difference
            )
    if timed:
        picture, row["plain_ms"] = timing(PLAIN)
        row["plain_kept"] = [difference(picture).kept(t) for t in TOLERANCES]
        _, row["factorised_ms"] = timing(FACTORISED, n=1)
    return row


def reference_of(scene, geometry, *, literal: bool):
    """Return the reference picture of a scene."""
    if literal or scene.skin.values.ndim == 1:
        return render(scene, Plan(), geometry=geometry)
    usual = tints.TABLE_SHARE
    tints.TABLE_SHARE = _FINE_SHARE
    try:
        return render(scene, Plan(reflectance="table"), geometry=geometry)
    finally:
        tints.TABLE_SHARE = usual


def cheapest_uniform(made, tolerance, timing, difference):
    """Return the time of the cheapest setting for all pixels that keeps a tolerance.

    With what the plan itself chose of all else, and if that does not do, with nothing
    left out.
    """
    for base in (made, Plan(bounce_rays=made.bounce_rays)):
        for samples in UNIFORM:
            picture, ms = timing(base.replace(samples=samples, refine=None), n=1)
            if difference(picture).kept(tolerance):
                return min(
                    ms, timing(base.replace(samples=samples, refine=None), n=1)[1]
                )
    return None


def settings(made: Plan) -> dict:
    """Return a plan without what was found for it."""
    names = ("samples", "refine", "shadows", "bounce_rays", "spectrum", "reflectance")
    return {
        name: getattr(made, name)
        for name in (*names, "specular", "shading", "arithmetic")
    }


def told(row: dict) -> str:
    """Return a scene in a line."""
    kind = ("mapped" if row["mapped"] else "uniform") + "+bounce" * row["bounce"]
    each = [
        f"{t}: {'kept' if own['kept'] else 'MISSED'} {own['filled']:.3f}/"
        f"{own['edge']:.2f} in {own['ms']:.0f} ({own['planning_ms']:.0f}) ms"
        for t, own in row["tolerances"].items()
    ]
    size = "x".join(map(str, row["size"]))
    return f"{row['seed']} {size} {row['filled']} {kind} {row['lamp'][:12]} | " + (
        " | ".join(each)
    )


def summarise(rows: list[dict]) -> None:
    """Print what all scenes say together."""
    print(f"\n{machine()}\n\n{len(rows)} scenes")
    for t in map(str, TOLERANCES):
        own = [row["tolerances"][t] for row in rows]
        kept = sum(o["kept"] for o in own)
        print(f"tolerance {t}: kept in {kept} of {len(own)}", end="")
        timed = [o for o in own if o["uniform_ms"]]
        if timed:
            late = [o["ms"] - 1.1 * o["uniform_ms"] for o in timed]
            print(
                f"; slower than 1.1 x the cheapest uniform + 50 ms in "
                f"{sum(x > 50 for x in late)} of {len(timed)} (worst {max(late):+.0f} "
                f"ms); median speed-up over it "
                f"{np.median([o['uniform_ms'] / o['ms'] for o in timed]):.2f} x",
                end="",
            )
        print()
    timed = [row for row in rows if "plain_ms" in row]
    if not timed:
        return
    at = str(1.0)
    index = TOLERANCES.index(1.0)
    for name, chosen in (
        ("all", timed),
        ("uniform skin", [r for r in timed if not r["mapped"]]),
        ("mapped skin", [r for r in timed if r["mapped"]]),
        ("filled >= 20,000", [r for r in timed if r["filled"] >= 20000]),
    ):
        plain = [
            r["plain_ms"] / r["tolerances"][at]["ms"]
            for r in chosen
            if r["plain_kept"][index]
        ]
        every = [r["plain_ms"] / r["tolerances"][at]["ms"] for r in chosen]
        fine = [r["factorised_ms"] / r["tolerances"][at]["ms"] for r in chosen]
        print(
            f"tolerance 1, {name} ({len(chosen)}): over the plain way where that keeps "
            f"it ({len(plain)}) {_median(plain)}, over it anyway {_median(every)}; "
            f"over 16 samples x 61 bands factorised {_median(fine)}"
        )


def _median(ratios: list[float]) -> str:
    """Return median and quartiles of ratios."""
    if not ratios:
        return "-"
    low, middle, high = np.percentile(ratios, [25, 50, 75])
    return f"{middle:.1f} x ({low:.1f}-{high:.1f})"


if __name__ == "__main__":
    main()
