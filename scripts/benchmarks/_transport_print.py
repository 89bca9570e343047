"""Tables and stop-watch of ``transport.py``."""

import time

import numpy as np

DIFFERENCES = (
    "rule", "skins", "ΔR mean", "RMS", "max", "ΔE00 mean", "ΔE00 max"
)  # fmt: skip


def table(title: str, head: tuple[str, ...], rows: list[tuple]) -> None:
    """Print a markdown table."""
    print(f"\n{title}\n\n| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for row in rows:
        shown = (_shown(*cell) for cell in zip(row, head, strict=True))
        print(f"| {' | '.join(shown)} |")


def _shown(value: object, name: str) -> str:
    """Return a number with the digits its column deserves."""
    if not isinstance(value, float):
        return str(value)
    if np.isnan(value):
        return "–"
    if name == "ΔR mean":
        return f"{value:+.4f}"
    return f"{value:.4f}" if name in ("RMS", "max", "RMSE") else f"{value:.2f}"


def spread(ratio: np.ndarray) -> tuple[str, str]:
    """Return the mean and the range of ratios as text."""
    return f"{ratio.mean():.2f}", f"{ratio.min():.2f} … {ratio.max():.2f}"


def best_of(function, times: int) -> float:
    """Return the least processor time of a call after one to warm up. [s]"""
    function()
    taken = []
    for _ in range(times):
        start = time.process_time()
        function()
        taken.append(time.process_time() - start)
    return min(taken)


def gaps(found: tuple, exact: tuple) -> list[str]:
    """Return the largest differences of pairs as text."""
    return [f"{np.abs(a - b).max():.0e}" for a, b in zip(found, exact, strict=True)]


def cost(seconds: float, unit: float) -> tuple[str, str]:
    """Return milliseconds and the ratio to a unit as text."""
    return tuple(f"{float(f'{x:.2g}'):g}" for x in (seconds * 1e3, seconds / unit))
