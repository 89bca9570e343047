"""How long each kind of work takes on this machine, measured once and kept.

The rates choose between ways that all keep the tolerance: they need to be right to a
factor of two, not to a per cent.
"""

from __future__ import annotations

import dataclasses
import json
import os
import platform
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from skinviz._files import whole_file
from skinviz._threads import processors
from skinviz.errors import SkinvizError

_RUNS = 3
_SIDE = 96  # pixels of the scene that is measured
_MOST = 1e6  # ns, beyond which a kept rate is no rate


@dataclass(frozen=True)
class Rates:
    """Time that one piece of work takes one processor. [ns]

    Attributes
    ----------
    ray : float
        A ray from the eye, and the point that it meets.
    shadow : float
        A ray from a point to a light.
    point : float
        A point's cosines and lobe, of one light.
    index : float
        Fresnel's law once.
    band : float
        The skin's model at one wavelength, at one point.
    mix : float
        One product of a reflectance and a weight.
    look : float
        One channel of a table.
    blend : float
        One channel interpolated from vertices.
    bounce : float
        A ray between parts of the mesh.
    """

    ray: float
    shadow: float
    point: float
    index: float
    band: float
    mix: float
    look: float
    blend: float
    bounce: float


@cache
def machine_rates() -> Rates:
    """Return this machine's rates: kept ones, or else measured now and kept.

    They are kept in the user's cache folder, for one machine and version; where that
    cannot be written they are measured in every process.
    """
    file = _cache_file()
    kept = _read(file)
    if kept is not None:
        return kept
    rates = measure_rates()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(file) as partial:
            partial.write_text(json.dumps(dataclasses.asdict(rates)), encoding="utf-8")
    except (OSError, SkinvizError):
        pass  # a folder that cannot be written costs a moment in each process
    return rates


def measure_rates() -> Rates:
    """Measure the rates: a fraction of a second, after the loops are compiled."""
    from skinviz.rendering.rates_scene import trials

    return Rates(**{name: _shortest(run) / n * 1e9 for name, run, n in trials(_SIDE)})


def _shortest(run: Callable[[], object]) -> float:
    """Return the shortest of some times. [s]"""
    times = []
    for _ in range(_RUNS + 1):
        begun = time.perf_counter()
        run()
        times.append(time.perf_counter() - begun)
    return min(times[1:])


def _cache_file() -> Path:
    """Return where the rates of this machine and version are kept."""
    from skinviz import __version__

    base = os.environ.get("XDG_CACHE_HOME") or _home() / ".cache"
    name = f"rates-{__version__}-{platform.machine()}-{processors()}.json"
    return Path(base) / "skinviz" / name


def _home() -> Path:
    """Return the user's folder, or that for temporary files where they have none."""
    try:
        return Path.home()
    except RuntimeError:  # a container's user that the system does not know
        return Path(tempfile.gettempdir())


def _read(file: Path) -> Rates | None:
    """Return kept rates; None if there are none, or they are no rates."""
    try:
        kept = json.loads(file.read_text(encoding="utf-8"))
        rates = Rates(**kept)
    except (OSError, ValueError, TypeError, RecursionError):
        return None
    values = np.array(dataclasses.astuple(rates), dtype=object)
    fine = all(isinstance(v, float) and 0 < v < _MOST for v in values)
    return rates if fine else None
