"""Simulated instruments by address, as ``sim://pr655?fault=cut&seed=3``."""

from __future__ import annotations

from urllib.parse import parse_qs, urlsplit

from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.instruments.simulate.cr250 import SimulatedCR250
from skinviz.instruments.simulate.faults import Faults
from skinviz.instruments.simulate.meter import SimulatedMeter
from skinviz.instruments.simulate.pr650 import SimulatedPR650
from skinviz.instruments.simulate.pr655 import SimulatedPR655, SimulatedPR670
from skinviz.instruments.simulate.scene import Bench
from skinviz.instruments.simulate.serve import Server, serve
from skinviz.instruments.simulate.zaber import SimulatedZaber

SCHEME = "sim://"
"""What the address of a simulated instrument begins with."""

DEVICES: dict[str, type[SimulatedMeter] | type[SimulatedZaber]] = {
    "pr655": SimulatedPR655,
    "pr670": SimulatedPR670,
    "pr650": SimulatedPR650,
    "cr250": SimulatedCR250,
    "zaber": SimulatedZaber,
}
"""What can be simulated."""

_OPTIONS = ("fault", "rate", "seed", "baud", "time")


def is_simulated(url: str) -> bool:
    """Return whether an address is of a simulated instrument."""
    return url.startswith(SCHEME)


def model_of(url: str) -> str:
    """Return the model that a simulated address names.

    Raises
    ------
    ArgumentError
        If there is none of that name.
    """
    return one_of(urlsplit(url).netloc, DEVICES, "simulated instrument")


def takes_time(url: str) -> bool:
    """Return whether a simulated address asks for readings that take their time.

    Raises
    ------
    ArgumentError
        If its ``time=`` is neither "real" nor "quick".
    """
    told = parse_qs(urlsplit(url).query).get("time", ["quick"])[-1]
    return one_of(told, ("quick", "real"), "time= of a simulated instrument") == "real"


def start(url: str, bench: Bench) -> Server:
    """Start a simulated instrument at a bench; ``.url`` is the port to open.

    Parameters
    ----------
    url : str
        ``sim://`` and a key of ``DEVICES``; then, if wanted, ``?`` and ``fault=cut``
        for what happens to the next measurement, once for each; ``rate=0.1`` for the
        share of later ones to which something happens, by ``seed=``; ``baud=9600``
        for a line as slow as that; ``time=real`` is for :func:`takes_time`.
    bench : Bench
        What it looks at.

    Raises
    ------
    ArgumentError
        If the address is not such.
    """
    kind = DEVICES[model_of(url)]
    options = parse_qs(urlsplit(url).query, keep_blank_values=True)
    for name in options:
        one_of(name, _OPTIONS, "option of a simulated instrument")
    faults = Faults(
        rate=_number(options, "rate", 0.0), seed=int(_number(options, "seed", 0.0))
    )
    faults.add(options.get("fault", []))
    baudrate = _number(options, "baud", float("inf"))
    return serve(kind(bench, faults), baudrate=baudrate)


def _number(options: dict[str, list[str]], name: str, otherwise: float) -> float:
    """Return an option's number."""
    if name not in options:
        return otherwise
    text = options[name][-1]
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < 1e9:
        raise ArgumentError(
            f"{name}= of a simulated instrument must be a number from 0 to 1e9; got "
            f"{text!r}"
        )
    return value
