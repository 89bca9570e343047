"""Rows of a spreadsheet of skin spectra, each cell checked where it stands."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skinviz.errors import DataError
from skinviz.spectra.archive_data import LABELS
from skinviz.spectra.formats.raw import SCALES
from skinviz.spectra.issa_layout import Layout

_INCLUDED = ("sci", "included", "specular included", "specular component included")
_NEEDED = ("origin", "subject", "site")  # labels without which a spectrum is nobody's
_MOST_ROWS = 1_048_576  # of any spreadsheet
_HIGHEST = 1.5  # above this it is no reflectance, however glossy
_SEEN = (400.0, 700.0)  # nm: outside, instruments are noisy


def sheet_rows(sheet: Any, n_columns: int, file: Path) -> Iterator[Sequence[Any]]:
    """Yield the cells of each row, from the first."""
    sheet.reset_dimensions()  # what the file says of its size may be wrong
    rows = sheet.iter_rows(max_col=n_columns, values_only=True)
    for number in itertools.count(1):
        try:
            row = next(rows)
        except StopIteration:
            return
        except Exception as error:  # broken XML, found only where it stands
            raise DataError(
                f"{file}, sheet {sheet.title!r}, row {number}: broken: {error!r}"
            ) from error
        if number > _MOST_ROWS:
            raise DataError(
                f"{file}, sheet {sheet.title!r}: more than {_MOST_ROWS} rows"
            )
        yield row


def sheet_records(
    sheet: Any, layout: Layout, scale: str, file: Path
) -> Iterator[tuple[tuple[str, ...], list[float]]]:
    """Yield the labels and the reflectance, 0–1, of each record of a sheet."""
    bands = list(layout.bands.items())
    width = 1 + max(*layout.columns.values(), *layout.bands.values())
    width = max(width, 1 + (layout.specular or 0))
    for number, row in enumerate(sheet_rows(sheet, width, file), start=1):
        if number < layout.first_row or not any(row):
            continue

        def place(column: int, number: int = number) -> str:
            return _place(file, sheet.title, number, column)

        texts = {
            label: _text(row[column], label, place(column))
            for label, column in layout.columns.items()
        }
        if not any(texts.values()):
            continue
        for label in _NEEDED:
            if not texts[label]:
                raise DataError(f"{place(layout.columns[label])}: no {label}")
        if layout.specular is not None:
            _require_included(row[layout.specular], place(layout.specular))
        values = [_number(row[i], nm, scale, place, i) for nm, i in bands]
        _require_whole(values, bands, place)
        yield tuple(texts[label] for label in ("record", *LABELS)), values


def _place(file: Path, sheet: str, row: int, column: int) -> str:
    """Return where a cell is, in words."""
    from openpyxl.utils import get_column_letter

    return f"{file}, sheet {sheet!r}, row {row}, column {get_column_letter(column + 1)}"


def _text(cell: Any, label: str, place: str) -> str:
    """Return a label as text with single spaces; sites in lower case."""
    if cell is None:
        return ""
    if isinstance(cell, float) and cell.is_integer():
        cell = int(cell)
    if isinstance(cell, bool) or not isinstance(cell, str | int):
        raise DataError(
            f"{place}: {label} is {cell!r}; it must be text or a whole number (the "
            "spreadsheet program may have made it a date)"
        )
    text = " ".join(str(cell).split())
    if text.startswith("#"):
        raise DataError(f"{place}: {label} is the error {text!r}")
    return text.lower() if label == "site" else text


def _number(
    cell: Any, nm: float, scale: str, place: Callable[[int], str], column: int
) -> float:
    """Return a band's reflectance, NaN where the cell is empty."""
    if cell is None or cell == "":
        return np.nan
    if isinstance(cell, bool) or not isinstance(cell, int | float):
        raise DataError(
            f"{place(column)}: a number is due for {nm:g} nm; the cell is {cell!r}"
        )
    value = cell / SCALES[scale]
    if not value <= _HIGHEST:
        hint = "; if the file is in per cent say --scale percent"
        raise DataError(
            f"{place(column)}: {cell:g} at {nm:g} nm is above "
            f"{_HIGHEST * SCALES[scale]:g}{hint if scale == 'fraction' else ''}"
        )
    if value <= 0 and _SEEN[0] <= nm <= _SEEN[1]:
        raise DataError(
            f"{place(column)}: {cell:g} at {nm:g} nm is not above 0; leave a band that "
            "was not measured empty"
        )
    return float(value)


def _require_included(cell: Any, place: str) -> None:
    """Refuse a record measured without the surface reflection: the rest has it."""
    if str(cell).strip().casefold() not in _INCLUDED:
        raise DataError(
            f"{place}: the archive was measured with the surface reflection included "
            f"(SCI); the cell is {cell!r}"
        )


def _require_whole(
    values: list[float], bands: list[tuple[float, int]], place: Callable[[int], str]
) -> None:
    """Refuse a spectrum that is empty or has a gap between measured bands."""
    measured = np.flatnonzero(np.isfinite(values))
    stored = "a formula without a stored value reads so: open and save the file"
    if not measured.size:
        raise DataError(
            f"{place(bands[0][1])}: the record has no reflectance; {stored}"
        )
    if measured[-1] - measured[0] + 1 != measured.size:
        gap = int(measured[np.flatnonzero(np.diff(measured) > 1)[0]]) + 1
        nm, column = bands[gap]
        raise DataError(
            f"{place(column)}: empty at {nm:g} nm, between measured bands; {stored}"
        )
