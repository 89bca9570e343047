"""How much memory a batch takes, each in a fresh process, for ``skin_fit.py``.

By itself: ``python _skin_memory.py float32 200000`` prints two numbers, what a fit
adds at its peak over its input: by tracemalloc, and by the process's resident size.
"""

import resource
import subprocess
import sys
import threading
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
from _print import Row
from _skin_data import NM

from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model


def rows(m: int) -> list[Row]:
    """Return the memory of float64 and float32 batches, input included."""
    told = []
    for kind in ("float64", "float32"):
        run = subprocess.run(
            [sys.executable, __file__, kind, str(m)],
            check=True,
            capture_output=True,
            text=True,
        )
        traced, resident = (float(word) for word in run.stdout.split())
        told.append(f"{kind} {1 + traced:.2f} × ({1 + resident:.2f} × resident)")
    return [
        Row(
            f"memory of a batch of {m:,} × 61 at its peak, input included, over the "
            "input, by tracemalloc (of a fresh process)",
            "3 ×",
            ", ".join(told),
        )
    ]


def main() -> None:
    """Fit a batch of one kind and print what it added, twice."""
    kind, m = sys.argv[1], int(sys.argv[2])
    model = skin_model(site="back of hand", specular="included")
    spectra = np.zeros((m, NM.size), dtype=kind)
    rng = np.random.default_rng(1)
    for i in range(0, m, 4096):  # so that making it leaves no larger trace
        part = spectra[i : i + 4096]
        weights = rng.uniform((0.02, 0, 0), (0.4, 0.03, 0.02), (len(part), 3))
        part[:] = model.measured(weights, NM) + rng.normal(0, 2e-3, part.shape)
    fit_skin(spectra[:5000], NM, model)  # compiled, its tables read
    resident = _grown(lambda: fit_skin(spectra, NM, model)) / spectra.nbytes
    tracemalloc.start()
    fit_skin(spectra, NM, model)
    traced = tracemalloc.get_traced_memory()[1] / spectra.nbytes
    print(traced, resident)


def _grown(work: Callable[[], object]) -> int:
    """Return by how much the process grows at the most, looked at all along. [bytes]"""
    before, seen, done = _resident(), [0], threading.Event()

    def look() -> None:
        while not done.wait(5e-4):
            seen.append(_resident())

    watcher = threading.Thread(target=look)
    watcher.start()
    work()
    done.set()
    watcher.join()
    return max(seen) - before


def _resident() -> int:
    """Return the process's resident size now. [bytes]"""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


if __name__ == "__main__":
    main()
