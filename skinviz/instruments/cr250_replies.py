"""What a CR-250 or CR-300 sends, as pure functions of bytes."""

from __future__ import annotations

import numpy as np

from skinviz.instruments.errors import (
    CommandRejected,
    DeviceFault,
    InstrumentError,
    MalformedReply,
    MeasurementRefused,
    OverRange,
    TooDark,
    Unsteady,
)
from skinviz.instruments.meters import (
    Grid,
    Spectrum,
    as_grid,
    printed_count,
    printed_number,
)

_SYNC = "it cannot find the source's frequency; measure without sync"
_DIM = "too little light; use a stronger lamp or a longer exposure"
_ERRORS: dict[int, tuple[type[InstrumentError], str]] = {
    -300: (CommandRejected, "a sync mode that it does not know; leave it out"),
    -301: (CommandRejected, "a sync period that it does not know; leave it out"),
    -302: (Unsteady, _SYNC),
    -303: (Unsteady, "the light fluctuates; let the lamp settle"),
    -304: (TooDark, _DIM),
    -305: (TooDark, _DIM),
    -306: (OverRange, "too much light; dim the lamp or use a neutral filter"),
    -331: (DeviceFault, "a hardware fault; have it seen to"),
}
_WARNINGS = {
    100: "too little light to find the frequency",
    101: "the source does not flicker",
    102: "no frequency found",
    103: "the frequency is weak",
}


def answer(line: bytes, command: bytes) -> tuple[bytes, tuple[str, ...]]:
    """Return the value and the warnings of an answer ``OK:code:command:value``.

    Raises
    ------
    TooDark, OverRange, Unsteady, CommandRejected, DeviceFault, MeasurementRefused
        What the code of an ``ER`` stands for.
    MalformedReply
        If the line is no answer to this command.
    """
    cells = line.strip().split(b":", 3)
    if len(cells) < 3 or cells[0] not in (b"OK", b"ER"):
        raise MalformedReply(
            f"{line[:30]!r} is no answer; check the baud rate, or ask again", raw=line
        )
    code = printed_count(cells[1], "the code", line)
    if cells[0] == b"ER":
        raise _error(code, line)
    told = cells[2].strip()
    if not told or not command.startswith(told):  # it may leave the value out
        raise MalformedReply(
            f"an answer to {cells[2][:20]!r} came for {command!r}; ask again", raw=line
        )
    if code < 0:
        raise _error(code, line)
    value = cells[3].strip() if len(cells) > 3 else b""
    return value, (_WARNINGS.get(code, f"warning {code}"),) if code else ()


def _error(code: int, line: bytes) -> InstrumentError:
    """Return what a code stands for."""
    if code in _ERRORS:
        kind, advice = _ERRORS[code]
    elif -560 <= code <= -500:
        kind, advice = CommandRejected, "leave this setting out for this model"
    elif code < 0:
        kind, advice = MeasurementRefused, "look the code up in its manual"
    else:
        kind, advice = MalformedReply, "a failure without a code; ask again"
    return kind(f"the instrument says {code}: {advice}", raw=line, code=code)


def grid_of(line: bytes) -> Grid:
    """Return the grid of the first line of an answer to ``RM Spectrum``.

    Raises
    ------
    InstrumentError
        What the code stands for, or ``MalformedReply`` if there is no grid.
    """
    value, _ = answer(line, b"RM Spectrum")
    cells = value.split(b",")
    if len(cells) != 4:
        raise MalformedReply(
            "the grid is not told in four numbers; ask again", raw=line
        )
    first, last, step = (printed_number(c, "the grid", line) for c in cells[:3])
    count = printed_count(cells[3], "the number of points", line)
    return as_grid(first, step, count, last, line)


def exposure_of(line: bytes) -> float | None:
    """Return the integration time of an answer to ``RM Exposure``. [s]

    Raises
    ------
    InstrumentError
        What the code stands for.
    """
    value, _ = answer(line, b"RM Exposure")
    try:
        told = float(value.split()[0]) / 1000
    except (ValueError, IndexError):
        return None  # it is only told for the record
    return told if 0 <= told <= 1e4 else None


def spectrum_of(raw: bytes) -> tuple[Grid, Spectrum]:
    """Return grid and spectrum of an answer to ``RM Spectrum``: a header and values.

    Raises
    ------
    InstrumentError
        What the code stands for; ``MalformedReply`` if a value is missing or none.
    """
    header, *rows = raw.splitlines() or [b""]
    grid = grid_of(header)
    if len(rows) != grid.count:
        raise MalformedReply(
            f"{len(rows)} values instead of {grid.count}; read the data again", raw=raw
        )
    values = [printed_number(row, "a radiance", raw) for row in rows]
    _, warnings = answer(header, b"RM Spectrum")
    return grid, Spectrum(np.array(values), warnings)
