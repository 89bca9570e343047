"""The table of the CIE's illuminants, and how their names are found in it.

What does not belong here: :class:`~skinviz.spectra.illuminants.Illuminant`.
"""

from __future__ import annotations

import csv
import re
from difflib import SequenceMatcher, get_close_matches
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

_FLUORESCENT = re.compile(r"f(\d+)")


@cache
def table_of_illuminants() -> tuple[tuple[str, ...], Array]:
    """Return the names of the columns and the table (1 + names, n)."""
    path = files("skinviz.spectra") / "data" / "cie_illuminants_5nm.csv"
    with path.open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    table = np.array(rows[1:], dtype=np.float64).T
    table.setflags(write=False)
    return tuple(rows[0][1:]), table


def find_illuminant(name: str) -> tuple[str, Array]:
    """Return the known name that is meant, and its power (n,).

    Raises
    ------
    ArgumentError
        If the name is unknown; the message lists the nearest names first.
    """
    names, table = table_of_illuminants()
    asked = _FLUORESCENT.sub(r"fl\1", str(name).strip().casefold())
    for row, known in zip(table[1:], names, strict=True):
        if asked == known.casefold():
            return known, row
    nearest = _nearest_first(asked, names)
    near = get_close_matches(asked, [nearest[0].casefold()])
    hint = f"; did you mean {nearest[0]!r}?" if near else ""
    raise ArgumentError(
        f"unknown illuminant {str(name)[:40]!r}; choose one of: {', '.join(nearest)}; "
        f"or a black body, as '3200 K'; or a line, as '632.8 nm'{hint}"
    )


def _nearest_first(asked: str, names: tuple[str, ...]) -> list[str]:
    """Return the names by how little they differ from what was asked for."""

    def parts(text: str) -> tuple[str, int]:
        series, number = re.sub(r"[^a-z]", "", text), re.sub(r"[^0-9]", "", text)
        return series[:40], int(number[:9] or 0)

    def distance(known: str) -> tuple[float, int]:
        series, number = parts(known.casefold())
        alike = SequenceMatcher(None, wanted, series).ratio()
        return -alike, abs(number - wanted_number)

    wanted, wanted_number = parts(asked)
    return sorted(names, key=distance)
