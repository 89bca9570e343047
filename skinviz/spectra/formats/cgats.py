"""CGATS.17 text with spectra, as colour-measuring instruments export it.

Neither the standard nor its writers agree on a scale: i1Profiler offers 0–1 and
0–100, ArgyllCMS has 0–100, MYIROtools 0–1. So it must be said, by the file
(``SPECTRAL_NORM``, the fields ``SPECTRAL_PCT`` or ``SPECTRAL_DEC``, or a comment
``# scale: percent``) or by the caller.

References
----------
.. [1] CGATS.17, Graphic technology – Exchange format for colour and process control
   data using XML or ASCII text (2009).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz.errors import DataError
from skinviz.spectra.formats.cgats_text import Table, read_lines, tables_of
from skinviz.spectra.formats.raw import (
    LIST,
    RawSpectra,
    labels_to_write,
    note,
    notes_to_write,
    number,
    scale_of,
    stated,
)

if TYPE_CHECKING:
    import xarray

KINDS, MISSING = (LIST,), False

_FIELD = re.compile(
    r"(SPECTRAL_NM_?|SPECTRAL_|SPEC_|NM_?|R_)(\d+(?:\.\d+)?)|(\d+(?:\.\d+)?)_NM", re.I
)
_PAIRED = {"SPECTRAL_PCT": 100.0, "SPECTRAL_DEC": 1.0}
_NAMES = ("SAMPLE_NAME", "SAMPLE_ID", "SAMPLEID", "SAMPLE_LOC")  # the best first
_KEYWORDS = {
    "geometry": "MEASUREMENT_GEOMETRY",
    "instrument": "INSTRUMENTATION",
    "date": "CREATED",
    "comment": "FILE_DESCRIPTOR",
}
_ROUNDED = 0.51  # nm by which a field's name may be rounded, as SPEC_383 for 383.33


def read(file: Path) -> RawSpectra:
    """Return the reflectances of the file's only table that has spectral fields."""
    return _read(file, _require_reflectance)


def read_lamp(file: Path) -> RawSpectra:
    """Return the light in the file's only table that has spectral fields."""
    return _read(file, _require_light)


def _read(
    file: Path, require_kind: Callable[[dict[str, str], Path], None]
) -> RawSpectra:
    """Return the spectra of a table whose keywords pass as of the right kind."""
    lines = read_lines(file)
    notes = dict(note(line) for line in lines if line.startswith("#"))
    table = _spectral_table(tables_of(lines, file), file)
    require_kind(table.keywords, file)
    _require_whole(table, file)
    wavelengths, columns, paired = _bands(table, file)
    values = [
        [number(cells[i], f"{file} line {at}") for i in columns]
        for at, cells in table.rows
    ]
    told = {key: table.keywords.get(word, "") for key, word in _KEYWORDS.items()}
    return RawSpectra(
        values=np.array(values),
        wavelengths=wavelengths,
        labels=_labels(table),
        written_as=_written_as(table.keywords, notes, paired, file),
        unless_said=None,
        attributes=stated({**told, **stated(notes)}),
    )


def write(file: Path, spectra: xarray.Dataset) -> None:
    """Write one table, 0–1, with every digit, and say so."""
    notes = notes_to_write(spectra, file)
    wavelengths = spectra["wavelength"].values.astype(np.float64)
    fields = ["SAMPLE_ID", "SAMPLE_NAME", *(f"nm{_digits(nm)}" for nm in wavelengths)]
    told = {
        word: notes[key] for key, word in _KEYWORDS.items() if notes.get(key)
    } | _grid_keywords(wavelengths)
    lines = ["CGATS.17"]
    if notes.get("specular"):
        lines.append(f"# specular: {notes['specular']}")
    lines.append('ORIGINATOR "skinviz"')
    for word, value in told.items():
        if word.startswith("SPECTRAL_"):  # not the standard's own
            lines.append(f"KEYWORD {_quoted(word)}")
        lines.append(f"{word} {_quoted(value)}")
    lines += [f"NUMBER_OF_FIELDS {len(fields)}", "BEGIN_DATA_FORMAT"]
    lines += [" ".join(fields), "END_DATA_FORMAT"]
    lines += [f"NUMBER_OF_SETS {spectra.sizes['record']}", "BEGIN_DATA"]
    labels = labels_to_write(spectra, file)
    for i, row in enumerate(spectra["reflectance"].values):
        numbers = " ".join(repr(float(value)) for value in row)
        lines.append(f"{i + 1} {_quoted(labels[i])} {numbers}")
    with whole_file(file) as partial:
        partial.write_text("\n".join([*lines, "END_DATA", ""]), encoding="utf-8")


def _spectral_table(tables: list[Table], file: Path) -> Table:
    """Return the one table with spectra, or say what the file has instead."""
    spectral = [table for table in tables if any(map(_is_spectral, table.fields))]
    if not spectral:
        fields = " ".join(tables[0].fields)[:60]
        raise DataError(
            f"{file}: no field of spectra such as SPECTRAL_NM400 or nm400; its fields "
            f"are {fields or 'not given'}; export it with spectra"
        )
    if len(spectral) > 1:
        raise DataError(
            f"{file}: {len(spectral)} tables of spectra, as of several measurement "
            "conditions; keep the one you mean in a file of its own"
        )
    return spectral[0]


def _is_spectral(name: str) -> bool:
    """Return whether a field is one of spectra."""
    return name.upper() == "SPECTRAL_NM" or bool(_FIELD.fullmatch(name))


def _require_reflectance(keywords: dict[str, str], file: Path) -> None:
    """Refuse light that was measured, of displays and lamps."""
    kind = keywords.get("MEAS_TYPE", "REFLECTIVE").upper()
    device = keywords.get("DEVICE_CLASS", "").upper()
    if not kind.startswith("REFLECT") or device in ("DISPLAY", "EMISINPUT"):
        what = f"DEVICE_CLASS {device}" if device else f"MEAS_TYPE {kind[:40]}"
        raise DataError(f"{file}: {what} is not reflectance, which is expected")


def _require_light(keywords: dict[str, str], file: Path) -> None:
    """Refuse what was measured on paper or film; a file need not say what it has."""
    kind = keywords.get("MEAS_TYPE", "EMISSION").upper()
    if not kind.startswith(("EMISSI", "AMBIENT")):
        raise DataError(f"{file}: MEAS_TYPE {kind[:40]} is no light, which is expected")


def _require_whole(table: Table, file: Path) -> None:
    """Refuse a table with other counts than it declares, or a ragged or empty one."""
    if not table.rows:
        raise DataError(f"{file}: no data between BEGIN_DATA and END_DATA")
    for at, cells in table.rows:
        if len(cells) != len(table.fields):
            raise DataError(
                f"{file} line {at}: {len(cells)} values where the format has "
                f"{len(table.fields)} fields; put names with spaces in quotation marks"
            )
    for word, count in (
        ("NUMBER_OF_FIELDS", len(table.fields)),
        ("NUMBER_OF_SETS", len(table.rows)),
    ):
        said = table.keywords.get(word, str(count))
        if number(said, f"{file}, {word}") != count:
            raise DataError(f"{file}: {word} is {said[:20]} and {count} were found")


def _bands(
    table: Table, file: Path
) -> tuple[NDArray[np.float64], list[int], float | None]:
    """Return wavelengths, columns of the values and the scale of paired fields."""
    fields = [name.upper() for name in table.fields]
    if "SPECTRAL_NM" in fields:
        return _paired_bands(table, fields, file)
    found = [(i, _FIELD.fullmatch(name)) for i, name in enumerate(fields)]
    named = [(i, match) for i, match in found if match]
    families = {match[1] or "_NM" for _, match in named}
    if len(families) > 1:
        raise DataError(
            f"{file}: spectral fields of several kinds, "
            f"{' and '.join(sorted(families))}; keep the kind you mean"
        )
    wavelengths = np.array([float(match[2] or match[3]) for _, match in named])
    exact = _exact(wavelengths, table.keywords, file)
    return exact, [i for i, _ in named], None


def _paired_bands(
    table: Table, fields: list[str], file: Path
) -> tuple[NDArray[np.float64], list[int], float]:
    """Return the bands of the standard's own form, a wavelength before each value."""
    at_nm = [i for i, name in enumerate(fields) if name == "SPECTRAL_NM"]
    columns = [i + 1 for i in at_nm]
    kinds = {fields[i] if i < len(fields) else "nothing" for i in columns}
    if len(kinds) != 1 or not kinds <= set(_PAIRED):
        raise DataError(
            f"{file}: after SPECTRAL_NM comes {' and '.join(sorted(kinds))[:60]}; "
            f"expected {' or '.join(_PAIRED)}, the same each time"
        )
    grid = [
        [number(cells[i], f"{file} line {at}") for i in at_nm]
        for at, cells in table.rows
    ]
    for (at, _), row in zip(table.rows, grid, strict=True):
        if row != grid[0]:
            raise DataError(
                f"{file} line {at}: other wavelengths than the first line's"
            )
    return np.array(grid[0]), columns, _PAIRED[kinds.pop()]


def _exact(
    named: NDArray[np.float64], keywords: dict[str, str], file: Path
) -> NDArray[np.float64]:
    """Return wavelengths as the keywords give them, if names are only rounded."""
    words = ("SPECTRAL_BANDS", "SPECTRAL_START_NM", "SPECTRAL_END_NM")
    if not all(word in keywords for word in words):
        return named
    bands, start, end = (number(keywords[w], f"{file}, {w}") for w in words)
    if bands != named.size or not np.isfinite([start, end]).all():
        raise DataError(
            f"{file}: SPECTRAL_BANDS is {bands:g}, and {named.size} fields were found"
        )
    even = np.linspace(start, end, named.size)
    if np.abs(even - named).max() > _ROUNDED:
        raise DataError(
            f"{file}: the names of the fields run from {named[0]:g} to {named[-1]:g} "
            f"nm, not in even steps from {start:g} to {end:g} nm as SPECTRAL_START_NM "
            "and SPECTRAL_END_NM say"
        )
    whole = bool((named == np.round(named)).all())
    return even if whole and np.abs(even - named).max() > 1e-6 else named


def _written_as(
    keywords: dict[str, str], notes: dict[str, str], paired: float | None, file: Path
) -> float | None:
    """Return what the file says 1 is written as; contradictions are refused."""
    told = set() if paired is None else {paired}
    if "SPECTRAL_NORM" in keywords:
        told.add(number(keywords["SPECTRAL_NORM"], f"{file}, SPECTRAL_NORM"))
    if "scale" in notes:
        told.add(scale_of(notes["scale"], file))
    if len(told) > 1:
        both = " and ".join(f"{value:g}" for value in sorted(told))
        raise DataError(f"{file}: says that 1 is written as {both}; correct one")
    return told.pop() if told else None


def _labels(table: Table) -> list[str]:
    """Return the names of the samples."""
    fields = [name.upper() for name in table.fields]
    columns = [fields.index(name) for name in _NAMES if name in fields]
    return [
        next((cells[i] for i in columns if cells[i]), f"line {at}")
        for at, cells in table.rows
    ]


def _grid_keywords(wavelengths: NDArray[np.float64]) -> dict[str, str]:
    """Return the keywords that state scale and, where steps are even, the bands."""
    start, end = float(wavelengths[0]), float(wavelengths[-1])
    told = {"SPECTRAL_NORM": "1"}
    if np.abs(np.linspace(start, end, wavelengths.size) - wavelengths).max() < 1e-6:
        told["SPECTRAL_BANDS"] = str(wavelengths.size)
        told["SPECTRAL_START_NM"] = _digits(start)
        told["SPECTRAL_END_NM"] = _digits(end)
    return told


def _digits(nm: float) -> str:
    """Return a wavelength with every digit and no needless point."""
    return repr(float(nm)).removesuffix(".0")


def _quoted(text: str) -> str:
    """Return text in quotation marks, its own doubled."""
    return '"' + text.replace('"', '""') + '"'
