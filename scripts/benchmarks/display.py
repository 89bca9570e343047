"""Measure how fast and how exactly light becomes the levels of a display.

Run in the development environment: ``python scripts/benchmarks/display.py``.
"""

import platform
import time

import numpy as np

from skinviz.spectra.display import SRGB, measured_display

COLOURS = 200_000
RUNS = 30


def main() -> None:
    """Print each figure with what it was measured on."""
    print(
        f"{platform.processor() or platform.machine()}, NumPy {np.__version__}, one "
        f"thread, {COLOURS} colours"
    )
    rng = np.random.default_rng(0)
    inside = rng.uniform(0, 1, (COLOURS, 3))
    mixed = rng.uniform(-0.05, 1.05, (COLOURS, 3))
    measured = measured_display(np.linalg.inv(SRGB.matrix).T, [1.8, 2.2, 2.6])
    for display in (SRGB, measured):
        for depth, full in ((display.encode8, 255), (display.encode16, 65535)):
            found, _ = depth(mixed)
            plain = np.round(full * display.encode(mixed))
            print(
                f"{display.name}, {full} levels: {nanoseconds(depth, inside):.1f} ns a "
                f"channel, {nanoseconds(depth, mixed):.1f} with 10 % that do not fit; "
                f"NumPy {nanoseconds(lambda c, d=display: d.encode(c), inside):.0f}; "
                f"{(found != plain).sum()} levels differ"
            )


def nanoseconds(work, colours: np.ndarray) -> float:
    """Return the time of the fastest run for one channel of one colour."""
    best = np.inf
    for _ in range(RUNS):
        start = time.perf_counter()
        work(colours)
        best = min(best, time.perf_counter() - start)
    return 1e9 * best / colours.size


if __name__ == "__main__":
    main()
