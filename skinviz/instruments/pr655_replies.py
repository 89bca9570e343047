"""What a PR-655 or PR-670 sends, as pure functions of bytes.

Numbers are taken between commas, never from columns: exponents have two digits in the
manual and three in some firmware.
"""

from __future__ import annotations

import numpy as np

from skinviz.instruments.errors import (
    CommandRejected,
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

_CANNOT_SYNC = "it cannot find the source's frequency; measure without sync"
_VERDICTS: dict[int, tuple[type[InstrumentError], str]] = {
    -1: (Unsteady, "the light changes; let the lamp settle and shield other light"),
    -2: (OverRange, "too much light; dim the lamp or use a neutral filter"),
    -3: (Unsteady, _CANNOT_SYNC),
    -4: (MeasurementRefused, "adaptive exposure failed; set an exposure"),
    -8: (TooDark, "too little light; use a stronger lamp or a longer exposure"),
    -9: (Unsteady, _CANNOT_SYNC),
    -10: (Unsteady, _CANNOT_SYNC),
    -12: (Unsteady, "adaptive exposure did not end; set an exposure"),
    -2000: (CommandRejected, "it has no such data; use a model this driver is for"),
}
_REJECTED = (
    "it does not take this setting, or not this value; change it or leave it out"
)


def status_of(line: bytes) -> int:
    """Return the code that every reply begins with; 0 is well.

    Raises
    ------
    MalformedReply
        If the line begins with none.
    """
    return printed_count(line.split(b",", 1)[0].strip(), "a reply's code", line)


def require_well(line: bytes) -> None:
    """Raise what a reply's code stands for, unless it is 0.

    Raises
    ------
    TooDark, OverRange, Unsteady, MeasurementRefused, CommandRejected, MalformedReply
    """
    code = status_of(line)
    if code == 0:
        return
    if code in _VERDICTS:
        kind, advice = _VERDICTS[code]
    elif -1100 <= code <= -1000:
        kind, advice = CommandRejected, _REJECTED
    else:
        kind, advice = MalformedReply, "a code that is in no manual; read again"
    raise kind(f"the instrument says {code}: {advice}", raw=line, code=code)


def text_of(line: bytes) -> str:
    """Return what an answer says after its code.

    Raises
    ------
    InstrumentError
        What the code stands for.
    """
    require_well(line)
    said = line.split(b",", 1)
    return said[1].decode("ascii", "replace").strip() if len(said) > 1 else ""


def grid_of(line: bytes) -> Grid:
    """Return the grid of an answer to ``D120``.

    Raises
    ------
    InstrumentError
        What the code stands for, or ``MalformedReply`` if there is no grid.
    """
    require_well(line)
    cells = line.split(b",")
    if len(cells) < 6:
        raise MalformedReply("the grid is told in too few numbers; ask again", raw=line)
    count = printed_count(cells[1], "the number of points", line)
    first, last, step = (printed_number(c, "the grid", line) for c in cells[3:6])
    return as_grid(first, step, count, last, line)


def exposure_of(line: bytes) -> float | None:
    """Return the integration time of an answer to ``D13``, its last number. [s]

    Raises
    ------
    InstrumentError
        What the code stands for.
    """
    require_well(line)
    cells = line.split(b",")
    try:
        told = float(cells[-1].split()[0]) / 1000
    except (ValueError, IndexError):
        return None  # it is only told for the record
    return told if len(cells) > 1 and 0 <= told <= 1e4 else None


def spectrum_of(raw: bytes, grid: Grid) -> Spectrum:
    """Return the spectrum of an answer to ``M5`` or ``D5``: a header and its rows.

    Parameters
    ----------
    raw : bytes
        Lines ended by CR LF: code, unit, peak wavelength, integral and photon
        integral; then wavelength and value, one line each.
    grid : Grid
        What ``D120`` said.

    Raises
    ------
    InstrumentError
        What the code stands for; ``MalformedReply`` if a row is missing or no row, or
        Σ value × step is not the integral of the header.
    """
    header, *rows = raw.splitlines() or [b""]
    require_well(header)
    cells = header.split(b",")
    if len(cells) != 5:
        raise MalformedReply(
            f"the header has {len(cells)} fields instead of 5; read again", raw=raw
        )
    if printed_count(cells[1], "the unit", raw) != 0:
        raise MalformedReply(
            "the unit is not W/(m2 sr nm); take the accessory off, or read the data "
            "again",
            raw=raw,
        )
    integral = printed_number(cells[3], "the integral", raw)
    if len(rows) != grid.count:
        raise MalformedReply(
            f"{len(rows)} rows instead of {grid.count}; read the data again", raw=raw
        )
    told = np.array([_row(row, raw) for row in rows])
    require_grid(told[:, 0], grid, raw)
    radiance = told[:, 1].copy()
    if sum_differs(radiance, grid.step, integral):
        raise MalformedReply(
            f"the rows add up to {radiance.sum() * grid.step:.4g} and the header says "
            f"{integral:.4g}; a digit was lost on the way, read the data again",
            raw=raw,
        )
    return Spectrum(radiance)


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
