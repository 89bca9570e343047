"""Measure the skin optics and the fit: accuracy beside time, for docs/physics.md.

Prints one markdown table. Speeds are the best of several turns, taken by all rivals
one after the other in one run. Run in the development environment:
``OPENBLAS_NUM_THREADS=1 python scripts/benchmarks/skin_fit.py``; ``--quick`` for a
first look in a minute, ``--only speed`` for a part.
"""

import argparse
import sys

import _skin_memory
import _skin_optics
import _skin_optimum
import _skin_pulls
import _skin_quality
import _skin_speed
from _print import HEAD, busy, line, machine

PARTS = {
    "optics": lambda size: _skin_optics.rows(int(2000 * size)),
    "quality": lambda _: _skin_quality.rows(),
    "forward": lambda size: _skin_speed.forward(int(200_000 * size), turns(size)),
    "fit": lambda size: _skin_speed.fits(int(200_000 * size), turns(size)),
    "scipy": lambda size: _skin_speed.against_scipy(
        int(200_000 * size), int(200 * size), turns(size)
    ),
    "optimum": lambda size: _skin_optimum.rows(int(400 * size), int(300 * size)),
    "pulls": lambda size: _skin_pulls.rows(int(30_000 * size)),
    "memory": lambda _: _skin_memory.rows(200_000),
    "image": lambda size: _skin_speed.image(int(1000 * size**0.5), "back of hand"),
}
"""What is measured, each a function of the size of the samples."""


def turns(size: float) -> int:
    """Return how often each rival runs."""
    return 5 if size >= 1 else 2


def main() -> None:
    """Print the table of the parts that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--quick", action="store_true", help="a tenth of the samples")
    asked = parser.parse_args()
    print(f"{machine()}\n\n{HEAD}", flush=True)
    for name in asked.only:
        print(f"{name} ...", file=sys.stderr)
        for row in PARTS[name](0.1 if asked.quick else 1.0):
            print(line(row), flush=True)
    print(f"\nAt the end: {busy()}")


if __name__ == "__main__":
    main()
