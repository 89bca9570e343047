"""Goniometer readings, the specular part of a reflection by angle: files and checks."""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._files import existing_file
from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.formats.raw import number, read_text

Array = NDArray[np.float64]

COLUMNS = ("illumination_deg", "viewing_deg", "specular", "uncertainty")
"""Header of a file of readings; the last column may be missing."""

_AT_MOST = 2**24  # bytes
_BRIGHTEST = 1e9  # times the perfect diffuser
_WHAT = "goniometer readings as CSV"


@dataclass(frozen=True, eq=False)
class GonioData:
    """Readings of a goniometer, light and viewer on opposite sides of the normal.

    Attributes
    ----------
    illumination, viewing : (m,) ndarray
        Angles from the normal. [rad]
    specular : (m,) ndarray
        Specular part, in units of the perfect diffuser. [1]
    uncertainty : (m,) ndarray or None
        Its standard deviation, where the file has it. [1]
    """

    illumination: Array
    viewing: Array
    specular: Array
    uncertainty: Array | None


def read_gonio(path: str | os.PathLike[str]) -> GonioData:
    """Read goniometer readings, in degrees in the file and in radians here.

    Parameters
    ----------
    path : path-like
        CSV with the header ``illumination_deg, viewing_deg, specular`` and, if known,
        ``uncertainty``; lines that begin with ``#`` are comments.

    Returns
    -------
    data : GonioData

    Raises
    ------
    DataError
        If the file is missing or has another header, no reading, or a cell that is no
        finite number; the message names the line.
    """
    file = existing_file(path, DataError)
    text = read_text(file, _WHAT, at_most=_AT_MOST)
    lines = [
        (at, [cell.strip() for cell in next(csv.reader([line]))])
        for at, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    if not lines:
        raise DataError(f"{file}: no readings, only comments or blank lines")
    columns = _columns(lines[0][1], file)
    rows = [_row(cells, len(columns), f"{file} line {at}") for at, cells in lines[1:]]
    if not rows:
        raise DataError(f"{file}: a header and no readings")
    table = dict(zip(columns, np.array(rows).T, strict=True))
    illumination, viewing, specular = (table[name] for name in COLUMNS[:3])
    return GonioData(
        np.deg2rad(illumination),
        np.deg2rad(viewing),
        specular,
        table.get(COLUMNS[3]),
    )


def _columns(header: Sequence[str], file: Path) -> tuple[str, ...]:
    """Return the names of the columns, in any order, or say what is missing."""
    names = tuple(cell.lower() for cell in header)
    if len(set(names)) < len(names) or not (
        set(COLUMNS[:3]) <= set(names) <= set(COLUMNS)
    ):
        raise DataError(
            f"{file}: the header must be {', '.join(COLUMNS[:3])} and, if known, "
            f"{COLUMNS[3]}; got {', '.join(header)[:80]!r}"
        )
    return names


def _row(cells: Sequence[str], width: int, where: str) -> list[float]:
    """Return the finite numbers of a line, or say what is wrong with it."""
    if len(cells) != width:
        raise DataError(f"{where}: {len(cells)} cells where the header has {width}")
    values = [number(cell, where) for cell in cells]
    for value in values:
        if not np.isfinite(value):
            raise DataError(f"{where}: {value} is no reading; leave the line out")
    return values


def as_readings(
    illumination: ArrayLike, viewing: ArrayLike, values: ArrayLike
) -> tuple[Array, Array, Array]:
    """Return angles and readings, all (m,), or say why they are none."""
    data = as_numbers(values, "the readings")
    if data.ndim != 1 or data.size == 0:
        raise ArgumentError(
            f"the readings must be a list of at least one; got shape {data.shape}"
        )
    data = per_reading(data, data.size, "the readings")
    if np.abs(data).max() > _BRIGHTEST:
        raise ArgumentError(
            f"the readings must be in units of the perfect diffuser, at most "
            f"{_BRIGHTEST:g}; got {data[np.abs(data).argmax()]:g}"
        )
    angles = []
    for given, name in ((illumination, "illumination"), (viewing, "viewing")):
        angle = per_reading(given, data.size, name)
        wrong = np.flatnonzero(~((angle >= 0) & (angle < np.pi / 2)))
        if wrong.size:
            raise ArgumentError(
                f"{name} must be angles from the normal in [0, pi/2) rad, the light "
                f"opposite the viewer; index {wrong[0]} is {angle[wrong[0]]:g}; turn "
                "degrees into radians and leave out the viewer's own side"
            )
        angles.append(angle)
    return angles[0], angles[1], data


def per_reading(value: ArrayLike, size: int, name: str) -> Array:
    """Return finite numbers (m,), one repeated if need be."""
    array = as_numbers(value, name)
    if array.shape not in ((), (size,)):
        raise ArgumentError(
            f"{name} must be one number or {size}, one a reading; got shape "
            f"{array.shape}"
        )
    bad = np.flatnonzero(~np.isfinite(np.atleast_1d(array)))
    if bad.size:
        raise ArgumentError(
            f"{name} must be finite; index {bad[0]} is not; leave that reading out"
        )
    return np.array(np.broadcast_to(array, (size,)))


def as_uncertainty(uncertainty: ArrayLike | None, size: int) -> Array | None:
    """Return the standard deviations (m,), if they are given."""
    if uncertainty is None:
        return None
    sigma = per_reading(uncertainty, size, "uncertainty")
    if not ((sigma >= 1e-75) & (sigma <= 1e75)).all():
        raise ArgumentError(
            "uncertainty must be greater than 0 at every reading, from 1e-75 to 1e75; "
            f"got {sigma.min():g} to {sigma.max():g}"
        )
    return sigma
