"""Rows, clocks and the machine's name for the benchmarks."""

import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np
import scipy


@dataclass(frozen=True)
class Row:
    """One figure: what it is, what it should reach, what it reached."""

    figure: str
    goal: str
    measured: str


HEAD = "| what | goal | measured |\n|---|---|---|"


def line(row: Row) -> str:
    """Return a line of a markdown table."""
    return f"| {row.figure} | {row.goal} | {row.measured} |"


def machine() -> str:
    """Return the processor, the versions and how busy the machine is now."""
    return (
        f"{_processor()}, {len(os.sched_getaffinity(0))} cores, Python "
        f"{platform.python_version()}, NumPy {np.__version__}, SciPy "
        f"{scipy.__version__}, numba {numba.__version__}; {busy()}"
    )


def busy() -> str:
    """Return how many processes wanted a core in the last 1, 5 and 15 minutes."""
    return "load average " + ", ".join(f"{x:.1f}" for x in os.getloadavg())


def _processor() -> str:
    """Return the processor's own name, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    names = [line.split(":", 1)[1] for line in lines if line.startswith("model name")]
    return " ".join(names[0].split()) if names else platform.machine()


def race(runners: dict[str, Callable[[], object]], times: int) -> dict[str, float]:
    """Return the least time of each of several calls, taken in turns. [s]

    Turns spread what else the machine does over all of them; the least time of many
    is the one that it disturbed least. One turn before them warms up.
    """
    taken: dict[str, list[float]] = {name: [] for name in runners}
    for turn in range(times + 1):
        for name, runner in runners.items():
            start = time.perf_counter()
            runner()
            if turn:
                taken[name].append(time.perf_counter() - start)
    return {name: min(seconds) for name, seconds in taken.items()}


def on_one_core(function: Callable[[], object]) -> Callable[[], object]:
    """Return a function that does the same on one processor."""

    def alone() -> None:
        every = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {min(every)})
        try:
            function()
        finally:
            os.sched_setaffinity(0, every)

    return alone


def rate(per_second: float) -> str:
    """Return spectra per second, three digits, told in thousands or millions."""
    unit, size = ("M", 1e6) if per_second >= 1e6 else ("k", 1e3)
    return f"{per_second / size:.3g} {unit}/s"


def columns(values: np.ndarray, form: str = ".3f") -> str:
    """Return numbers as text with commas between."""
    return ", ".join(format(float(v), form) for v in np.ravel(values))
