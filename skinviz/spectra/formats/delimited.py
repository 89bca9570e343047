"""CSV and TSV: wavelengths down or across."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz.errors import DataError
from skinviz.spectra.formats.raw import (
    LIST,
    RawSpectra,
    is_number,
    labels_to_write,
    note,
    notes_to_write,
    number,
    read_text,
    scale_of,
    stated,
)

if TYPE_CHECKING:
    import xarray

KINDS, MISSING = (LIST,), False

_AT_MOST = 2**30  # bytes
_LAYOUTS = (
    "wavelengths down (a header 'wavelength_nm,NAME,...' or two bare columns) or "
    "across (a header of labels and wavelengths)"
)


def read(file: Path) -> RawSpectra:
    """Return the spectra of comma-, semicolon- or tab-separated text."""
    rows, notes = _rows(file)
    wavelengths, labels, values = _table(rows, file)
    scale = notes.get("scale")
    return RawSpectra(
        values=values,
        wavelengths=wavelengths,
        labels=labels,
        written_as=None if scale is None else scale_of(scale, file),
        attributes=stated(notes),
    )


def write(file: Path, spectra: xarray.Dataset) -> None:
    """Write wavelengths down, 0–1, with every digit."""
    mark = "\t" if file.suffix.lower() == ".tsv" else ","
    with (
        whole_file(file) as partial,
        partial.open("w", newline="", encoding="utf-8") as text,
    ):
        text.write("# scale: fraction\n")
        for key, value in notes_to_write(spectra, file).items():
            text.write(f"# {key}: {value}\n")
        rows = csv.writer(text, lineterminator="\n", delimiter=mark)
        rows.writerow(["wavelength_nm", *labels_to_write(spectra, file)])
        reflectance = spectra["reflectance"].values.T
        for nm, row in zip(spectra["wavelength"].values, reflectance, strict=True):
            rows.writerow([repr(float(nm)), *(repr(float(value)) for value in row)])


def _rows(file: Path) -> tuple[list[tuple[int, list[str]]], dict[str, str]]:
    """Return (line number, cells) of each line with data, and the notes."""
    text = read_text(file, "spectra as CSV", at_most=_AT_MOST)
    notes, lines = {}, []
    for at, line in enumerate(text.splitlines(), start=1):
        if line.startswith("#"):
            key, value = note(line)
            notes[key] = value
        elif line.strip():
            lines.append((at, line))
    if not lines:
        raise DataError(f"{file}: no data, only comments or blank lines")
    # The mark that splits the last line, all numbers, splits every line.
    mark = max("\t;,", key=lines[-1][1].count)
    parsed = csv.reader((line for _, line in lines), delimiter=mark)
    try:
        rows = [
            (at, [cell.strip() for cell in cells])
            for (at, _), cells in zip(lines, parsed, strict=True)
        ]
    except (csv.Error, ValueError) as error:
        raise DataError(f"{file}: a quotation mark is not closed: {error}") from error
    return rows, notes


def _table(
    rows: list[tuple[int, list[str]]], file: Path
) -> tuple[NDArray[np.float64], list[str], NDArray[np.float64]]:
    """Return wavelengths, labels and values (records, wavelengths) of the rows."""
    width = len(rows[0][1])
    for at, cells in rows:
        if len(cells) != width:
            raise DataError(
                f"{file} line {at}: {len(cells)} cells where the first line has {width}"
            )
    header = rows[0][1]
    across = [i for i, cell in enumerate(header) if is_number(cell)]
    if header[0].lower().startswith("wavelength") and width > 1:
        body, labels = rows[1:], header[1:]
    elif width == 2 and len(across) == 2:
        body, labels = rows, [file.stem]
    elif len(across) > 1 and len(rows) > 1:
        return _table_across(rows, across, file)
    else:
        raise DataError(
            f"{file}: the layout is neither of {_LAYOUTS}; its first line begins "
            f"{', '.join(header)[:60]!r}"
        )
    if not body:
        raise DataError(f"{file}: a header and no data")
    grid = np.array(
        [[number(c, f"{file} line {at}") for c in cells] for at, cells in body]
    )
    _require_finite(grid[:, 0], [at for at, _ in body], file)
    return grid[:, 0], labels, np.ascontiguousarray(grid[:, 1:].T)


def _table_across(
    rows: list[tuple[int, list[str]]], across: list[int], file: Path
) -> tuple[NDArray[np.float64], list[str], NDArray[np.float64]]:
    """Return the table of a file with one spectrum a line."""
    header = rows[0][1]
    named = [i for i in range(len(header)) if i not in across]
    wavelengths = np.array([float(header[i]) for i in across])
    _require_finite(wavelengths, [rows[0][0]] * len(across), file)
    labels = [
        " ".join(cells[i] for i in named if cells[i]) or f"line {at}"
        for at, cells in rows[1:]
    ]
    values = [
        [number(cells[i], f"{file} line {at}") for i in across]
        for at, cells in rows[1:]
    ]
    return wavelengths, labels, np.array(values)


def _require_finite(
    wavelengths: NDArray[np.float64], lines: list[int], file: Path
) -> None:
    """Refuse a wavelength that is NaN or infinite, naming its line."""
    for at, nm in zip(lines, wavelengths, strict=True):
        if not np.isfinite(nm):
            raise DataError(f"{file} line {at}: the wavelength is {nm}")
