"""Who is behind a port that the user names.

Nothing is ever sent to a port that was not named: it might move a stage.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence

from skinviz._validate import one_of
from skinviz.instruments.cr250 import CR250
from skinviz.instruments.errors import PortUnavailable
from skinviz.instruments.pr650 import PR650
from skinviz.instruments.pr655 import PR655, PR670
from skinviz.instruments.serial_meter import SerialMeter
from skinviz.instruments.serial_ports import Port, open_link
from skinviz.instruments.stages import ZaberStage

METERS: dict[str, type[SerialMeter]] = {
    "pr655": PR655,
    "pr670": PR670,
    "pr650": PR650,
    "cr250": CR250,
    "cr300": CR250,
}
"""Drivers by the name of their model."""

STAGES: dict[str, type[ZaberStage]] = {"zaber": ZaberStage}
"""Drivers of motorised stages."""


def port_of(model: str, ports: Sequence[Port]) -> str:
    """Return the one port whose description names a model.

    Raises
    ------
    PortUnavailable
        If there is none or more than one.
    """
    one_of(model, METERS, "meter")
    sought = model[2:]
    found = [port.name for port in ports if _names(port.description, sought)]
    if len(found) != 1:
        told = ", ".join(f"{p.name} ({p.description})" for p in ports) or "none"
        raise PortUnavailable(
            f"{len(found)} ports are described as a {model}; name one with --port. "
            f"There are: {told}"
        )
    return found[0]


def open_meter(
    model: str,
    url: str,
    *,
    stop: threading.Event | None = None,
    pauses: float = 1.0,
) -> SerialMeter:
    """Open a spectroradiometer at a port that the user named.

    Parameters
    ----------
    model : str
        A key of ``METERS``.
    url : str
        As for :func:`skinviz.instruments.serial_ports.open_link`.
    stop : threading.Event, optional
        Ends every wait when it is set.
    pauses : float
        As for :class:`SerialMeter`.

    Raises
    ------
    InstrumentError
        ``PortUnavailable``, or ``WrongDevice`` or ``NoReply`` if something else is
        there, or nothing.
    """
    kind = METERS[one_of(model, METERS, "meter")]
    link = open_link(url, baudrate=kind.BAUDRATE, rtscts=kind.RTSCTS, stop=stop)
    return kind(link, pauses=pauses)


def open_stage(
    model: str, url: str, *, zero: float = 0.0, stop: threading.Event | None = None
) -> ZaberStage:
    """Open a motorised stage at a port that the user named.

    Raises
    ------
    InstrumentError
        As for :func:`open_meter`.
    """
    kind = STAGES[one_of(model, STAGES, "stage")]
    return kind(open_link(url, baudrate=kind.BAUDRATE, stop=stop), zero=zero)


def _names(description: str, sought: str) -> bool:
    """Return whether a description has a model's number as a word."""
    words = "".join(c if c.isalnum() else " " for c in description).split()
    return any(word.lower().lstrip("prc") == sought for word in words)
