"""Import of the publisher's spreadsheet of the International Skin Spectra Archive.

What the layout rests on. The spreadsheet is not shipped and was not at hand when
this was written. Its publisher describes it on figshare (28228571.v4): a sheet of
codes and a sheet of data with, from the left, record, origin, subject, ethnicity,
gender, age group and body location, the instrument's settings, reflectance at
360–780 nm and colorimetric values. Published programs that read the file agree that
reflectance is in per cent, that bands which an instrument lacks are empty, and that
tables stand above the row of headings. The wording of the headings is not known: a
column is found by any of the names in ``issa_layout.COLUMNS``, and one of another
name can be given.
"""

from __future__ import annotations

import hashlib
import itertools
import os
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file
from skinviz._validate import one_of
from skinviz.errors import DataError
from skinviz.spectra.archive_data import LABELS, archive_dataset
from skinviz.spectra.archives import SOURCES, load_archive
from skinviz.spectra.formats.raw import SCALES
from skinviz.spectra.issa_layout import COLUMNS, HEAD_ROWS, WIDEST, find_layouts
from skinviz.spectra.issa_rows import sheet_records, sheet_rows

if TYPE_CHECKING:
    import xarray

_MOST_BYTES = 1_000_000_000  # unpacked; the publisher's file has under a tenth
_SAME = 1e-3  # relative: two roundings of one measurement


def import_archive(
    path: str | os.PathLike[str],
    *,
    scale: str = "fraction",
    columns: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> xarray.Dataset:
    """Read the publisher's spreadsheet of the International Skin Spectra Archive.

    The sheet with the headings and wavelengths is found by itself; several with the
    same wavelengths are joined. Rows without any label are no records. Bands that
    no record has are left out.

    Parameters
    ----------
    path : str or path-like
        An ``.xlsx`` file.
    scale : {"fraction", "percent"}
        Whether the file has 0–1 or 0–100. Declared, never guessed.
    columns : mapping of str to str, optional
        For columns whose heading is not known: ``{"site": "Body loc."}``, or the
        column's letter, ``{"site": "G"}``.
    progress : callable, optional
        Called with the name of each of three steps as it begins.

    Returns
    -------
    archive : xarray.Dataset
        As :func:`load_archive` returns. ``source`` names the file and its SHA-256;
        the attribute ``unnamed_codes`` lists codes that could not be named.

    Raises
    ------
    ArgumentError
        If the scale or a given column is unknown.
    DataError
        If the file is no spreadsheet or has another layout; if a cell is text, an
        error or a date where a number is due, a reflectance is not above 0 or too
        large for its scale, or a band is missing between measured ones. The message
        names sheet, row and column.

    Notes
    -----
    The file may write codes where the shipped part has names ("6" for "forehead").
    A code gets the shipped name if all records that have the same number and the
    same spectrum here and there pair the two. Other labels stay as they are.
    """
    one_of(scale, SCALES, "scale")
    given = dict(columns or {})
    for name in given:
        one_of(name, COLUMNS, "column")
    file = existing_file(path, DataError)
    _require_small(file)
    progress("find the columns")
    labels: list[tuple[str, ...]] = []
    spectra: list[list[float]] = []
    with file.open("rb") as raw:  # ours to close: openpyxl leaves it open on errors
        book = _open(raw, file)
        heads = {
            sheet.title: list(
                itertools.islice(sheet_rows(sheet, WIDEST, file), HEAD_ROWS)
            )
            for sheet in book.worksheets
        }
        layouts = find_layouts(heads, given, file)
        progress(f"read {', '.join(layouts)}")
        for name, layout in layouts.items():
            for texts, values in sheet_records(book[name], layout, scale, file):
                labels.append(texts)
                spectra.append(values)
    progress("check")
    if not spectra:
        raise DataError(f"{file}: headings and no records")
    wavelengths = np.array(list(next(iter(layouts.values())).bands))
    return _archive(labels, np.array(spectra), wavelengths, scale, file)


def _require_small(file: Path) -> None:
    """Refuse what is no spreadsheet, or unpacks to an absurd size."""
    try:
        with zipfile.ZipFile(file) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
    except (zipfile.BadZipFile, OSError) as error:
        raise DataError(f"{file}: cannot be read as .xlsx: {error}") from error
    if size > _MOST_BYTES:
        raise DataError(
            f"{file}: unpacks to {size / 1e9:.3g} GB; a spreadsheet of spectra has at "
            f"most {_MOST_BYTES / 1e9:g}"
        )


def _open(raw: BinaryIO, file: Path) -> Any:
    """Return the workbook, opened for reading from the top."""
    import openpyxl

    try:
        return openpyxl.load_workbook(
            raw, read_only=True, data_only=True, keep_links=False
        )
    except Exception as error:  # openpyxl passes on what zip and XML raise
        raise DataError(f"{file}: cannot be read as .xlsx: {error!r}") from error


def _archive(
    labels: list[tuple[str, ...]],
    reflectance: NDArray[np.float64],
    wavelengths: NDArray[np.float64],
    scale: str,
    file: Path,
) -> xarray.Dataset:
    """Return records as an archive, codes named and empty bands left out."""
    if scale == "percent" and np.nanmax(reflectance) <= 1 / SCALES["percent"]:
        raise DataError(
            f"{file}: every value is at most 1, which is no skin in per cent; say "
            "--scale fraction"
        )
    texts = np.array(labels, dtype=object)
    records = _record_numbers(texts[:, 0], file)
    used = np.isfinite(reflectance).any(axis=0)
    columns = {label: texts[:, i] for i, label in enumerate(LABELS, start=1)}
    named, unnamed = _named(columns, records, wavelengths, reflectance)
    with file.open("rb") as raw:
        digest = hashlib.file_digest(raw, "sha256").hexdigest()
    attributes = {
        **SOURCES["issa"],
        "source": f"{SOURCES['issa']['source'].replace(', a part', '')}; imported from "
        f"{file.name}, SHA-256 {digest}",
        "unnamed_codes": unnamed,
    }
    return archive_dataset(
        records, named, wavelengths[used], reflectance[:, used], attributes
    )


def _record_numbers(texts: NDArray[Any], file: Path) -> NDArray[np.int64]:
    """Return the records' numbers or name one that is none, or is there twice."""
    for text in texts:
        if not (text.isdecimal() and len(text) < 10):
            raise DataError(f"{file}: record {text!r} is no whole number")
    records = texts.astype(np.int64)
    known, counts = np.unique(records, return_counts=True)
    if counts.max() > 1:
        raise DataError(
            f"{file}: record {known[counts > 1][0]} is there more than once; each "
            "spectrum needs a number of its own"
        )
    return records


def _named(
    columns: dict[str, NDArray[Any]],
    records: NDArray[np.int64],
    wavelengths: NDArray[np.float64],
    reflectance: NDArray[np.float64],
) -> tuple[dict[str, NDArray[Any]], str]:
    """Return labels with codes named by the shipped part, and the codes left."""
    shipped = load_archive("issa")
    _, here, there = np.intersect1d(
        records, shipped["record"].values, return_indices=True
    )
    _, own, other = np.intersect1d(
        wavelengths, shipped["wavelength"].values, return_indices=True
    )
    same = np.isclose(
        reflectance[np.ix_(here, own)],
        shipped["reflectance"].values[np.ix_(there, other)],
        rtol=_SAME,
        atol=0,
        equal_nan=True,
    ).all(axis=1)
    if not own.size or not same.any():
        return columns, ""
    here, there = here[same], there[same]
    named, unnamed = {}, []
    for label in LABELS:
        names = _pairs(columns[label][here], shipped[label].values[there])
        named[label] = np.array(
            [names.get(text, text) for text in columns[label]], dtype=object
        )
        left = sorted({text for text in columns[label] if text} - names.keys())
        if left and label != "subject":
            unnamed.append(f"{label} {', '.join(left)}")
    return named, "; ".join(unnamed)


def _pairs(codes: NDArray[Any], names: NDArray[Any]) -> dict[str, str]:
    """Return the name of each code that always goes with one name."""
    seen: dict[str, set[str]] = {}
    for code, name in zip(codes, names, strict=True):
        if code:
            seen.setdefault(code, set()).add(name)
    return {code: own.pop() for code, own in seen.items() if len(own) == 1}
