"""Measure the cleaning of scans against a known true shape, for docs/physics.md.

Simulate, clean, compare: over noise, views and poses' errors, right and left hands in
turn; with ``--quick`` one change at a time from the goal's case. ``--sizes`` adds large
scans, ``--merges`` the two ways to merge views. Run in the development environment:
``python scripts/benchmarks/clean.py --quick``.
"""

import argparse
import itertools
import platform
from dataclasses import replace

from _clean_cases import Case, Outcome, alone, fine_mesh, outcome
from _clean_merges import compare_merges

GOAL = Case()
NOISE, VIEWS, POSES = (0.1, 0.5, 0.0, 0.25), (8, 4, 16), (2.0, 5.0, 0.0, 1.0)
HEADER = (
    "| noise mm | views | pose mm/° | hand | RMS mm | 95 % | 99 % | max | normal ° "
    "| holes | welds | crossing | made up mm² | covered | volume | moved mm | s | GiB |"
)


def main() -> None:
    """Print a row for each case."""
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("quick", "sizes", "merges"):
        parser.add_argument(f"--{name}", action="store_true")
    asked = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, {platform.python_version()}")
    if not (asked.sizes or asked.merges) or asked.quick:
        print(HEADER)
        print("|" + "---|" * (HEADER.count("|") - 1))
        for case in quick() if asked.quick else full():
            print(row(case, alone(outcome, case)), flush=True)
    if asked.sizes:
        sizes()
    if asked.merges:
        for line in compare_merges(GOAL):
            print(line, flush=True)


def quick() -> list[Case]:
    """Return the goal's case and one change at a time."""
    changes = (
        {},
        {"left": True, "seed": 1},
        {"noise": 0.0},
        {"noise": 0.5},
        {"views": 4},
        {"views": 16},
        {"shift": 0.0, "tilt": 0.0},
        {"shift": 5.0, "tilt": 5.0},
    )
    return [replace(GOAL, **change) for change in changes]


def full() -> list[Case]:
    """Return every combination, half of them of a left hand in a checkerboard."""
    ranges = (range(len(NOISE)), range(len(VIEWS)), range(len(POSES)))
    return [
        Case(
            NOISE[n],
            VIEWS[v],
            POSES[p],
            POSES[p],
            left=(n + v + p) % 2 == 1,
            seed=seed,
        )
        for seed, (n, v, p) in enumerate(itertools.product(*ranges))
    ]


def row(case: Case, got: Outcome) -> str:
    """Return a case and its outcome as a row of the table."""
    hand = "left" if case.left else "right"
    head = f"| {case.noise:g} | {case.views} | {case.shift:g}/{case.tilt:g} | {hand} | "
    tail = f"{got.seconds:.0f} | {got.memory:.2f} |"
    d, report = got.difference, got.report
    if d is None or report is None:
        return f"{head}refused: {got.refusal} | {tail}"
    return (
        f"{head}{d.rms:.3f} | {d.most:.3f} | {d.nearly_all:.3f} | {d.largest:.2f} | "
        f"{d.normal:.2f} | {d.holes} | {d.handles} | "
        f"{report['check']['crossing_faces']} | {d.made_up:.0f} | {d.covered:.2%} | "
        f"{d.volume:+.2%} | {got.moved:.3g} | {tail}"
    )


def sizes() -> None:
    """Print the time and memory of large scans and meshes."""
    large = alone(outcome, replace(GOAL, views=10, pitch=0.37))
    each = large.cells / 10
    print(f"10 views of {each:.0f} cells (512 x 512 are 262144): {_cost(large)}")
    fine = alone(fine_mesh, 1_000_000)
    print(f"a mesh of {fine.cells} triangles: {_cost(fine)}")


def _cost(got: Outcome) -> str:
    """Return what an outcome cost, and the steps that did."""
    text = f"{got.seconds:.1f} s, {got.memory:.2f} GiB"
    if got.difference is None or got.report is None:
        return f"{text}; refused: {got.refusal}"
    d = got.difference
    return f"{text}; RMS {d.rms:.3f}, 95 % {d.most:.3f} mm\n{got.report}"


if __name__ == "__main__":
    main()
