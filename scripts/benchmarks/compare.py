"""Measure skinviz compare: 100 subjects × 4 sites × 3 repeats, and what is right.

A study is computed with the two-layer model from weights that are known, written as a
folder, and compared by site with ``skinviz compare --no-hands`` in a process of its
own; its start counts. Beside the seconds stand the error of the recovered weights and
how often 95 % intervals held the true differences, over many small studies.
``python scripts/benchmarks/compare.py``; ``--quick`` for a tenth of it.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from itertools import combinations, product
from pathlib import Path

import numpy as np
import xarray as xr
from _print import HEAD, Row, busy, line, machine

from skinviz import compare_study, read_study, skin_model, write_spectra

BANDS = np.arange(400.0, 701.0, 10.0)
SITES = {
    "cheek": (0.15, 0.009, 0.003),
    "back of hand": (0.13, 0.007, 0.004),
    "outer arm": (0.12, 0.006, 0.003),
    "inner arm": (0.09, 0.003, 0.002),
}
BETWEEN, WITHIN, NOISE = 0.2, 0.03, 0.002  # of weights, log; of a band
REPEATS = (1, 2, 3)
WEIGHTS = ("w_m", "w_h", "w_dh")
STUDY = """\
title = "synthetic"
specular = "included"
pattern = "spectra/{subject}.csv"
labels = "{site} / {repeat}"
"""
RUN = "import sys; from skinviz.cli.main import run; sys.argv[0] = 'skinviz'; run()"


def true_mean(site: str) -> np.ndarray:
    """Return the mean weights of all people: of a log-normal distribution."""
    return np.array(SITES[site]) * np.exp((BETWEEN**2 + WITHIN**2) / 2)


def make_study(folder: Path, n_subjects: int, rng: np.random.Generator) -> np.ndarray:
    """Write a study; return the weights (subjects, sites, repeats, 3) behind it."""
    models = {site: skin_model(site=site, specular="included") for site in SITES}
    shape = (n_subjects, len(SITES), len(REPEATS), 3)
    middles = np.array(list(SITES.values()))[:, None]
    own = rng.normal(0, BETWEEN, (n_subjects, len(SITES), 1, 3))
    weights = middles * np.exp(own + rng.normal(0, WITHIN, shape))
    labels = [f"{site} / {repeat}" for site, repeat in product(SITES, REPEATS)]
    for i in range(n_subjects):
        spectra = np.concatenate(
            [m.measured(weights[i, s], BANDS) for s, m in enumerate(models.values())]
        )
        noisy = np.maximum(spectra + rng.normal(0, NOISE, spectra.shape), 0)
        table = xr.Dataset(
            {"reflectance": (("record", "wavelength"), noisy)},
            coords={"wavelength": BANDS, "label": ("record", np.array(labels))},
        )
        write_spectra(folder / "spectra" / f"S{i:03d}.csv", table)
    (folder / "study.toml").write_text(STUDY, "utf-8")
    return weights


def timed(folder: Path, by: str, turns: int) -> tuple[float, dict]:
    """Return the best seconds of a comparison, and what it found."""
    out, seconds = folder / f"out_{by}", []
    words = ["compare", folder, "--by", by, "--out", out, "--no-hands"]
    for _ in range(turns):
        began = time.perf_counter()
        command = [sys.executable, "-c", RUN, *map(str, words)]
        subprocess.run(command, check=True, capture_output=True)
        seconds.append(time.perf_counter() - began)
    return min(seconds), json.loads((out / "comparison.json").read_text("utf-8"))


def recovered(found: dict, weights: np.ndarray) -> list[Row]:
    """Return how near the means of fitted weights are to those put in."""
    rows = []
    for k, name in enumerate(WEIGHTS):
        truth = dict(zip(SITES, weights[..., k].mean(axis=(0, 2)), strict=True))
        off = [
            abs(row["mean"] / truth[row["site"]] - 1)
            for row in found["means"]
            if row["quantity"] == name
        ]
        text = f"{100 * max(off):.2g} %"
        rows.append(Row(f"mean {name} of a site against what was put in", "", text))
    return rows


def coverage(n_studies: int, n_subjects: int) -> Row:
    """Return how often intervals of paired differences held the true ones."""
    held, total = 0, 0
    for seed in range(n_studies):
        with tempfile.TemporaryDirectory() as folder:
            make_study(Path(folder), n_subjects, np.random.default_rng([7, seed]))
            found = compare_study(read_study(folder), "site")
        for c in found.contrasts:
            if c.quantity.name in WEIGHTS:
                k = WEIGHTS.index(c.quantity.name)
                truth = true_mean(c.second)[k] - true_mean(c.first)[k]
                held += c.difference.low <= truth <= c.difference.high
                total += 1
    pairs = len(list(combinations(SITES, 2)))
    error = 100 * np.sqrt(0.95 * 0.05 / (n_studies * len(WEIGHTS) * (len(SITES) - 1)))
    return Row(
        f"95 % intervals that hold the true difference: {n_studies} studies of "
        f"{n_subjects} × {len(SITES)} × {len(REPEATS)}, {pairs} pairs × 3 weights",
        "95 %",
        f"{100 * held / total:.1f} ± {error:.1f} %",
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of it")
    parser.add_argument("--only-times", action="store_true")
    asked = parser.parse_args()
    n_subjects, n_studies = (10, 10) if asked.quick else (100, 100)
    print(f"{machine()}\n\n{HEAD}", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        weights = make_study(folder, n_subjects, np.random.default_rng(2005))
        size = f"{n_subjects} × {len(SITES)} × {len(REPEATS)}"
        for by in ("site", "subject"):
            seconds, found = timed(folder, by, 2)
            what = f"skinviz compare --by {by} --no-hands, {size} spectra"
            print(line(Row(what, "≤ 20 s", f"{seconds:.1f} s")), flush=True)
            if by == "site":
                for row in recovered(found, weights):
                    print(line(row), flush=True)
    if not asked.only_times:
        print(line(coverage(n_studies, 10)), flush=True)
    print(f"\nAt the end: {busy()}")


if __name__ == "__main__":
    main()
