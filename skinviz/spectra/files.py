"""Files of measured spectra: CSV, with wavelengths down or across."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file, whole_file
from skinviz._validate import one_of
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.measurement import as_specular

if TYPE_CHECKING:
    import xarray

SCALES = {"fraction": 1.0, "percent": 0.01}
"""How reflectance is written in a file: 0–1, or 0–100."""

_LAYOUTS = (
    "wavelengths down (a header 'wavelength_nm,NAME,...' or two bare columns) or "
    "across (a header of labels and wavelengths)"
)


def read_spectra(
    path: str | os.PathLike[str],
    *,
    scale: str = "fraction",
    specular: str | float | None = None,
) -> xarray.Dataset:
    """Read measured reflectance spectra from a CSV file.

    Parameters
    ----------
    path : str or path-like
        Comma-, semicolon- or tab-separated text. Lines starting with ``#`` are
        comments; ``# specular: included`` and ``# geometry: 45/0`` among them set
        the attributes of those names.
    scale : {"fraction", "percent"}
        Whether the file has 0–1 or 0–100. Declared, never guessed.
    specular : {"excluded", "included"} or float, optional
        How the surface reflection was measured, if the file does not say it; a
        contradiction is refused.

    Returns
    -------
    spectra : xarray.Dataset
        ``reflectance`` (record, wavelength) [1] with the coordinate ``label``, and
        attributes ``source``, and ``specular`` and ``geometry`` where known.

    Raises
    ------
    DataError
        If the file is missing, empty, of another layout, or has a value that is
        no number, missing, negative or too large for its scale, or wavelengths
        that do not ascend. The message names the line or spectrum.
    """
    file = existing_file(path, DataError)
    factor = SCALES[one_of(scale, SCALES, "scale")]
    rows, notes = _rows(file)
    wavelengths, labels, values = _table(rows, file)
    _require_ascending(wavelengths, file)
    _require_reflectance(values, wavelengths, labels, scale, file)

    import xarray

    attributes: dict[str, str | float] = {"source": str(file)}
    if "geometry" in notes:
        attributes["geometry"] = notes["geometry"]
    told = [
        _specular(how, file)
        for how in (specular, notes.get("specular"))
        if how is not None
    ]
    if len(set(told)) > 1:
        raise DataError(
            f"{file} says that its surface reflection is {told[1]}, and {told[0]} was "
            "given; correct the one that is wrong"
        )
    if told:
        attributes["specular"] = told[0]
    return xarray.Dataset(
        {"reflectance": (("record", "wavelength"), values * factor, {"units": "1"})},
        coords={
            "record": np.arange(len(labels)),
            "label": ("record", labels),
            "wavelength": ("wavelength", wavelengths, {"units": "nm"}),
        },
        attrs=attributes,
    )


def write_spectra(path: str | os.PathLike[str], spectra: xarray.Dataset) -> Path:
    """Write reflectance spectra as CSV, wavelengths down, 0–1.

    Parameters
    ----------
    path : str or path-like
        The file to write.
    spectra : xarray.Dataset
        As :func:`read_spectra` returns.

    Returns
    -------
    path : Path
        The file written.
    """
    file = Path(path)
    if file.suffix.lower() != ".csv":
        raise ArgumentError(f"{file}: spectra are written as .csv")
    if "reflectance" not in spectra or "label" not in spectra.coords:
        raise ArgumentError(
            "spectra need reflectance (record, wavelength) and the coordinate label"
        )
    reflectance = spectra["reflectance"].transpose("wavelength", "record").values
    if not np.isfinite(reflectance).all():
        raise ArgumentError("spectra with missing bands cannot be written; drop them")
    with (
        whole_file(file) as partial,
        partial.open("w", newline="", encoding="utf-8") as text,
    ):
        for key in ("specular", "geometry"):
            if key in spectra.attrs:
                text.write(f"# {key}: {spectra.attrs[key]}\n")
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(["wavelength_nm", *(str(x) for x in spectra["label"].values)])
        for nm, row in zip(spectra["wavelength"].values, reflectance, strict=True):
            rows.writerow([repr(float(nm)), *(repr(float(value)) for value in row)])
    return file


def _specular(value: str | float, file: Path) -> str | float:
    """Return how the surface was measured, or say in which file it is misspelt."""
    try:
        return as_specular(value)
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error


def _rows(file: Path) -> tuple[list[tuple[int, list[str]]], dict[str, str]]:
    """Return (line number, cells) of each line with data, and the notes."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError(f"{file}: not a text file; spectra are read as CSV") from error
    except OSError as error:
        raise DataError(f"{file}: cannot be read: {error.strerror}") from error
    notes, lines = {}, []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("#"):
            key, _, value = line[1:].partition(":")
            notes[key.strip().lower()] = value.strip()
        elif line.strip():
            lines.append((number, line))
    if not lines:
        raise DataError(f"{file}: no data, only comments or blank lines")
    # The mark that splits the last line, all numbers, splits every line.
    mark = max("\t;,", key=lines[-1][1].count)
    parsed = csv.reader((line for _, line in lines), delimiter=mark)
    try:
        rows = [
            (number, [cell.strip() for cell in cells])
            for (number, _), cells in zip(lines, parsed, strict=True)
        ]
    except (csv.Error, ValueError) as error:
        raise DataError(f"{file}: a quotation mark is not closed: {error}") from error
    return rows, notes


def _table(
    rows: list[tuple[int, list[str]]], file: Path
) -> tuple[NDArray[np.float64], list[str], NDArray[np.float64]]:
    """Return wavelengths, labels and values (records, wavelengths) of the rows."""
    width = len(rows[0][1])
    for number, cells in rows:
        if len(cells) != width:
            raise DataError(
                f"{file} line {number}: {len(cells)} cells where the first line has "
                f"{width}"
            )
    header = rows[0][1]
    across = [i for i, cell in enumerate(header) if _is_number(cell)]
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
    grid = np.array([[_number(c, n, file) for c in cells] for n, cells in body])
    _require_finite(grid[:, 0], [number for number, _ in body], file)
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
        " ".join(cells[i] for i in named if cells[i]) or f"line {number}"
        for number, cells in rows[1:]
    ]
    values = [[_number(cells[i], n, file) for i in across] for n, cells in rows[1:]]
    return wavelengths, labels, np.array(values)


def _is_number(cell: str) -> bool:
    """Return whether a cell reads as a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # Python's own spelling, nobody else's


def _number(cell: str, line: int, file: Path) -> float:
    """Return a cell's number or say where it is not one."""
    if not _is_number(cell):
        what = "an empty cell" if not cell else repr(cell)
        hint = "; write decimal points, not commas" if "," in cell else ""
        raise DataError(f"{file} line {line}: expected a number, found {what}{hint}")
    return float(cell)


def _require_finite(
    wavelengths: NDArray[np.float64], lines: list[int], file: Path
) -> None:
    """Refuse a wavelength that is NaN or infinite, naming its line."""
    for line, nm in zip(lines, wavelengths, strict=True):
        if not np.isfinite(nm):
            raise DataError(f"{file} line {line}: the wavelength is {nm}")


def _require_ascending(wavelengths: NDArray[np.float64], file: Path) -> None:
    """Refuse wavelengths that do not ascend or are not in nm."""
    steps = np.flatnonzero(np.diff(wavelengths) <= 0)
    if steps.size:
        i = int(steps[0])
        raise DataError(
            f"{file}: wavelengths must ascend; {wavelengths[i + 1]:g} nm follows "
            f"{wavelengths[i]:g} nm; reverse or sort them with their values"
        )
    if wavelengths[0] < 100 or wavelengths[-1] > 5000:
        raise DataError(
            f"{file}: wavelengths run from {wavelengths[0]:g} to {wavelengths[-1]:g}; "
            "they are expected in nm"
        )


def _require_reflectance(
    values: NDArray[np.float64],
    wavelengths: NDArray[np.float64],
    labels: list[str],
    scale: str,
    file: Path,
) -> None:
    """Refuse what cannot be reflectance on the declared scale."""
    highest = 1.5 / SCALES[scale]
    # Beyond the visible, instruments are noisy and nothing uses the bands.
    inside = (wavelengths >= 400) & (wavelengths <= 700)
    wavelengths, values = wavelengths[inside], values[:, inside]
    checks = (
        (~np.isfinite(values), "is not finite; remove the band or the spectrum"),
        (values < 0, "is negative; check the dark and white measurements"),
        (
            values > highest,
            "is above 1.5; if the file is in per cent say --scale percent"
            if scale == "fraction"
            else f"is above {highest:g} %",
        ),
    )
    for bad, why in checks:
        if bad.any():
            record, band = (int(i) for i in np.argwhere(bad)[0])
            raise DataError(
                f"{file}, spectrum {labels[record]!r} at {wavelengths[band]:g} nm: "
                f"{values[record, band]:g} {why}"
            )
    if scale == "percent" and values.size and values.max() <= 1.0:
        raise DataError(
            f"{file}: every value is at most 1, which is no skin in per cent; say "
            "--scale fraction"
        )
