"""When a measurement is worth another try, and which."""

from __future__ import annotations

from collections.abc import Callable

from skinviz.instruments.errors import (
    InstrumentError,
    MalformedReply,
    NoReply,
    TruncatedReply,
    Unsteady,
)
from skinviz.instruments.meters import Reading, Spectroradiometer

REREADS = 2
"""How often the data of a measurement are asked for again."""


def patient_reading(
    meter: Spectroradiometer, report: Callable[[InstrumentError], None]
) -> Reading:
    """Measure once; where a reply was lost or garbled, ask for it again.

    Parameters
    ----------
    meter : Spectroradiometer
    report : callable
        Told of every error that was made good.

    Returns
    -------
    reading : Reading

    Raises
    ------
    InstrumentError
        What could not be made good: too little or too much light, a lost link, a
        fault, a refusal, or a second time what is tried twice.

    Notes
    -----
    A reply that was cut or garbled is sent again, at most twice, without a new
    measurement. After silence, or light that changed, one new measurement is made.
    """
    try:
        return _with_rereads(meter, report)
    except (NoReply, Unsteady) as error:
        report(error)
        return _with_rereads(meter, report)


def _with_rereads(
    meter: Spectroradiometer, report: Callable[[InstrumentError], None]
) -> Reading:
    """Measure, and ask for the data again if they came cut or garbled."""
    ask: Callable[[], Reading] = meter.measure
    for _ in range(REREADS):
        try:
            return ask()
        except (TruncatedReply, MalformedReply) as error:
            report(error)
            ask = meter.reread
    return ask()
