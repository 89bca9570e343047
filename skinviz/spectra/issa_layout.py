"""Where a spreadsheet of skin spectra has what: headings, wavelengths, sheets.

The rows themselves are read in ``issa_import``.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skinviz.errors import DataError

Cells = Sequence[Any]

COLUMNS = {
    "record": "record, record number, record no, record id, unique record identifier, "
    "no, number, id, index, sample, sample no, serial no",
    "origin": "origin, data origin, dataset, data set, data source, source, country",
    "subject": "subject, subject number, subject no, subject id, participant, "
    "participant number, participant id",
    "group": "group, ethnicity, ethnic group, ethnic, race, nationality, skin type",
    "sex": "sex, gender",
    "age_group": "age group, age, age range, age band",
    "site": "site, body location, body site, body part, body area, body position, "
    "location, position, measurement location",
}
"""Headings of each column; case, punctuation and the word "code" do not count."""

SPECULAR = (
    "specular, specular component, specular mode, specular component inclusion, "
    "specular included, specular component included, sci, sci sce, spin, spin spex"
)
"""Headings of the column, if there is one, that says SCI or SCE."""

HEAD_ROWS = 60
"""Rows at the top of a sheet in which the headings are looked for."""

WIDEST = 1000
"""Columns of a sheet that are looked at."""

_WAVELENGTH = re.compile(r"(?:r|λ)?[\s_]*(\d{3,4}(?:\.\d+)?)\s*(?:nm)?", re.IGNORECASE)
_RANGE = (300.0, 1100.0)  # nm that a heading may mean
_FEWEST_BANDS = 8  # a row of data may have a few numbers of that size


@dataclass(frozen=True)
class Layout:
    """What a sheet has where: columns count from 0, rows from 1.

    Attributes
    ----------
    first_row : int
        Of the data.
    columns : dict of str to int
        The column of each label.
    bands : dict of float to int
        The column of each wavelength, ascending. [nm]
    specular : int or None
        The column that says SCI or SCE.
    """

    first_row: int
    columns: dict[str, int]
    bands: dict[float, int]
    specular: int | None


def find_layouts(
    heads: Mapping[str, Sequence[Cells]], given: Mapping[str, str], file: Path
) -> dict[str, Layout]:
    """Return the layout of each sheet that holds spectra.

    Parameters
    ----------
    heads : mapping of str to sequence of rows
        The first ``HEAD_ROWS`` rows of each sheet, by its name.
    given : mapping of str to str
        Heading or letter of columns whose heading is not in ``COLUMNS``.
    file : Path
        Named in errors.

    Raises
    ------
    DataError
        If no sheet has wavelengths and all columns, or two that have them differ.
    """
    rows = {name: _wavelength_row(head, name, file) for name, head in heads.items()}
    spectral = {name: row for name, row in rows.items() if row is not None}
    if not spectral:
        raise DataError(
            f"{file}: no sheet has a row of wavelengths as 360, 360nm or R360 among "
            f"its first {HEAD_ROWS} rows; sheets: {', '.join(heads)}"
        )
    found, failures = {}, []
    for name, row in spectral.items():
        headings = _headings(heads[name], row)
        columns, missing = _columns(headings, given)
        if missing:
            failures.append(_lacking(name, headings, missing))
            continue
        bands = _bands(heads[name][row])
        specular = _first_match(headings, SPECULAR)
        found[name] = Layout(row + 2, columns, bands, specular)
    if not found:
        raise DataError(f"{file}: {failures[0]}")
    _require_alike(found, file)
    return found


def _wavelength_row(head: Sequence[Cells], name: str, file: Path) -> int | None:
    """Return the last row, from 0, that is a row of wavelengths."""
    for row in range(len(head) - 1, -1, -1):
        numbers = [_wavelength(cell) for cell in head[row]]
        bands = [nm for nm in numbers if nm is not None]
        if len(bands) < _FEWEST_BANDS:
            continue
        for before, after in itertools.pairwise(bands):
            if after <= before:
                raise DataError(
                    f"{file}, sheet {name!r}, row {row + 1}: wavelengths must ascend; "
                    f"{after:g} follows {before:g} nm"
                )
        return row
    return None


def _wavelength(cell: Any) -> float | None:
    """Return the wavelength that a heading means, if it means one. [nm]"""
    if isinstance(cell, bool):
        return None
    if isinstance(cell, int | float):
        nm = float(cell)
    else:
        found = _WAVELENGTH.fullmatch(cell.strip()) if isinstance(cell, str) else None
        if not found:
            return None
        nm = float(found[1])
    return nm if _RANGE[0] <= nm <= _RANGE[1] else None


def _bands(row: Cells) -> dict[float, int]:
    """Return the column of each wavelength in a row."""
    numbers = ((_wavelength(cell), i) for i, cell in enumerate(row))
    return {nm: i for nm, i in numbers if nm is not None}


def _headings(head: Sequence[Cells], row: int) -> dict[int, str]:
    """Return each column's heading: the lowest text at or above the wavelengths.

    Above, because headings may be merged over several rows, which keeps the text in
    the topmost cell.
    """
    headings: dict[int, str] = {}
    for cells in head[: row + 1]:
        for i, cell in enumerate(cells):
            if isinstance(cell, str) and cell.strip():
                headings[i] = " ".join(cell.split())
    return {i: headings[i] for i in sorted(headings)}


def _plain(text: str) -> str:
    """Return a heading without case, punctuation and the word "code"."""
    words = re.sub(r"[\W_]+", " ", text.casefold()).split()
    return " ".join(word for word in words if word not in ("code", "codes"))


def _first_match(headings: Mapping[int, str], names: str) -> int | None:
    """Return the column that has the earliest of the names as its heading."""
    plain: dict[str, int] = {}
    for i, text in headings.items():
        plain.setdefault(_plain(text), i)
    return next((plain[n] for n in names.split(", ") if n in plain), None)


def _columns(
    headings: Mapping[int, str], given: Mapping[str, str]
) -> tuple[dict[str, int], list[str]]:
    """Return the column of each label, and the labels that have none."""
    columns = {}
    for label, names in COLUMNS.items():
        if label in given:
            own = _first_match(headings, _plain(given[label]))
            column = _from_letters(given[label]) if own is None else own
        else:
            column = _first_match(headings, names)
        if column is not None:
            columns[label] = column
    return columns, [label for label in COLUMNS if label not in columns]


def _from_letters(text: str) -> int | None:
    """Return the column, from 0, of letters such as "AB"."""
    if not re.fullmatch(r"[A-Za-z]{1,3}", text):
        return None
    number = 0
    for letter in text.upper():
        number = number * 26 + ord(letter) - ord("A") + 1
    return number - 1


def _lacking(name: str, headings: Mapping[int, str], missing: Sequence[str]) -> str:
    """Return in words which columns a sheet lacks, and what it has."""
    first = missing[0]
    shown = ", ".join(repr(text) for text in list(headings.values())[:15])
    return (
        f"sheet {name!r} has no column for {', '.join(missing)}; {first} may be headed "
        f"{COLUMNS[first]}; the headings found are {shown or 'none'}; give another as "
        f"--column {first}=HEADING or {first}=LETTER"
    )


def _require_alike(found: Mapping[str, Layout], file: Path) -> None:
    """Refuse sheets whose spectra have different wavelengths."""
    (first, layout), *others = found.items()
    for name, other in others:
        if list(other.bands) != list(layout.bands):
            raise DataError(
                f"{file}: the sheets {first!r} and {name!r} have spectra at different "
                "wavelengths; import them one by one"
            )
