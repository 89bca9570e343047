"""What a PR-650 sends, as pure functions of bytes."""

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
    require_grid,
    sum_differs,
)

LOW_LIGHT = 18
"""The quality of data that are sent all the same."""

_CANNOT_SYNC = (Unsteady, "it cannot find the source's frequency; measure without sync")
_HARDWARE = (
    DeviceFault,
    "a hardware fault; switch it off and on, then have it seen to",
)
_QUALITIES: dict[int, tuple[type[InstrumentError], str]] = {
    **dict.fromkeys((7, 8, 20), _CANNOT_SYNC),
    10: (TooDark, "too little light; use a stronger lamp or a longer exposure"),
    16: (Unsteady, "the light changes, or is too weak; let the lamp settle"),
    17: (DeviceFault, "its battery is low; charge it or use the mains adapter"),
    19: (OverRange, "too much light; dim the lamp or use a neutral filter"),
    29: (MeasurementRefused, "it found its own data corrupted; measure again"),
    30: (Unsteady, "the signal is noisy; let the lamp settle"),
    **dict.fromkeys((1, 3, 4, 5, 6, 12, 13, 14, 21), _HARDWARE),
}


def require_quality(line: bytes) -> int:
    """Return the quality code that a measurement begins with, if there are data.

    Raises
    ------
    TooDark, OverRange, Unsteady, MeasurementRefused, DeviceFault
        What the code stands for. After these the meter still holds the spectrum
        before, which must not be taken for this one.
    MalformedReply
        If there is no code, or one that is in no manual.
    """
    code = printed_count(line.split(b",", 1)[0].strip(), "the quality code", line)
    if code in (0, LOW_LIGHT):
        return code
    kind, advice = _QUALITIES.get(
        code, (MalformedReply, "a code that is in no manual; measure again")
    )
    raise kind(f"the instrument says {code:02d}: {advice}", raw=line, code=code)


def require_accepted(line: bytes) -> None:
    """Refuse an answer to a setting that is not ``000``.

    Raises
    ------
    CommandRejected, MalformedReply
    """
    code = printed_count(line.strip(), "an acknowledgement", line)
    if code:
        raise CommandRejected(
            f"the instrument refused a setting with {code}; leave the setting out for "
            "this model",
            raw=line,
            code=code,
        )


def grid_of(line: bytes) -> Grid:
    """Return the grid of an answer to ``D120``.

    Raises
    ------
    MalformedReply
        If there is none.
    """
    cells = line.split(b",")
    if len(cells) != 5:
        raise MalformedReply(
            "the grid is not told in five numbers; ask again", raw=line
        )
    count = printed_count(cells[0], "the number of points", line)
    first, last, step = (printed_number(c, "the grid", line) for c in cells[2:])
    return as_grid(first, step, count, last, line)


def spectrum_of(raw: bytes, grid: Grid, *, doubted: bool = False) -> Spectrum:
    """Return the spectrum of an answer to ``M5`` or ``D5``.

    Parameters
    ----------
    raw : bytes
        Lines: quality and unit; integral; then wavelength and value, one line each.
    grid : Grid
        What ``D120`` said.
    doubted : bool
        The same bytes have come before, so that their integral, whose rule no manual
        at hand states, is only warned of.

    Raises
    ------
    InstrumentError
        What the quality stands for; ``MalformedReply`` if a row is missing or no row,
        or the integral is neither the sum nor the trapezoidal rule's.
    """
    lines = raw.splitlines() or [b""]
    quality = require_quality(lines[0])
    first = lines[0].split(b",")
    if len(first) != 2 or printed_count(first[1], "the unit", raw) != 0:
        raise MalformedReply(
            "the unit is not W/(m2 sr nm); take the accessory off, or read the data "
            "again",
            raw=raw,
        )
    if len(lines) != grid.count + 2:
        raise MalformedReply(
            f"{len(lines) - 2} rows instead of {grid.count}; read the data again",
            raw=raw,
        )
    integral = printed_number(lines[1].strip(), "the integral", raw)
    told = np.array([_row(row, raw) for row in lines[2:]])
    require_grid(told[:, 0], grid, raw)
    radiance = told[:, 1].copy()
    warnings: tuple[str, ...] = ("low light",) if quality == LOW_LIGHT else ()
    if _differs(radiance, grid.step, integral):
        if not doubted:
            raise MalformedReply(
                f"the rows add up to {radiance.sum() * grid.step:.4g} and the header "
                f"says {integral:.4g}; a digit may be lost, read the data again",
                raw=raw,
            )
        warnings += ("the integral follows another rule",)
    return Spectrum(radiance, warnings)


def _differs(radiance: np.ndarray, step: float, integral: float) -> bool:
    """Return whether an area is neither the sum nor the trapezoidal rule's."""
    trapezoid = radiance.copy()
    trapezoid[[0, -1]] /= 2
    return sum_differs(radiance, step, integral) and sum_differs(
        trapezoid, step, integral
    )


def _row(row: bytes, raw: bytes) -> tuple[float, float]:
    """Return wavelength and value of a row."""
    cells = row.split(b",")
    if len(cells) != 2:
        raise MalformedReply(
            f"a row is {row[:30]!r}; expected wavelength and value, read again", raw=raw
        )
    return (
        printed_number(cells[0], "a wavelength", raw),
        printed_number(cells[1], "a radiance", raw),
    )
