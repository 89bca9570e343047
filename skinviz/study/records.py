"""From entries of a study to one table of spectra, and to what it lacks."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import SkinvizError
from skinviz.spectra.archive_data import archive_dataset
from skinviz.study.record_list import Entry
from skinviz.study.record_names import CUBE, Reader
from skinviz.study.study import CHANGED, LEFT_OUT, MISSING, Gap

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

_COVERED = (400.0, 700.0)  # nm that a fit needs


@dataclass(frozen=True, eq=False)
class Record:
    """An entry and its spectrum, both (n,)."""

    entry: Entry
    wavelengths: Array
    reflectance: Array


def gap(what: str, entry: Entry, why: str) -> Gap:
    """Return the gap that an entry leaves."""
    own = entry
    where = (own.subject, own.site, own.condition, own.repeat)
    return Gap(what, *where, own.file, why)


def read_entries(
    entries: Iterable[Entry], read: Reader
) -> tuple[list[Record], list[Gap]]:
    """Return the spectra of entries, and the gaps where there is none to use.

    Parameters
    ----------
    entries : iterable of Entry
        As the study lists them; of two with the same key the first stays.
    read : callable
        Returns the spectra of a file of the study's folder.
    """
    records, gaps = [], []
    keys: set[tuple[str, str, str, int]] = set()
    for entry in entries:
        why = "the same subject, site, condition and repeat is there already"
        if entry.key not in keys:
            try:
                records.append(_record(entry, read(entry.file)))
                keys.add(entry.key)
                continue
            except SkinvizError as error:
                why = str(error)
        gaps.append(gap(LEFT_OUT, entry, why))
    return records, gaps


def on_one_grid(records: list[Record]) -> tuple[list[Record], list[Gap]]:
    """Return the records on the wavelengths that most of them have.

    The others are interpolated linearly, and NaN where they do not reach.
    """
    counts = Counter(tuple(record.wavelengths) for record in records)
    ((common, _),) = counts.most_common(1) or (((), 0),)
    grid = np.array(common)
    moved, gaps = [], []
    for record in records:
        if tuple(record.wavelengths) == common:
            moved.append(record)
            continue
        values = np.interp(
            grid, record.wavelengths, record.reflectance, left=np.nan, right=np.nan
        )
        moved.append(dataclasses.replace(record, wavelengths=grid, reflectance=values))
        why = (
            f"has {_said(record.wavelengths)} and most have {_said(grid)}; "
            "interpolated linearly to these"
        )
        gaps.append(gap(CHANGED, record.entry, why))
    return moved, gaps


def as_dataset(records: list[Record], attributes: Mapping[str, Any]) -> xarray.Dataset:
    """Return records on one grid, at least one, as a study's spectra."""
    entries = [record.entry for record in records]

    def column(name: str) -> NDArray[Any]:
        return np.array([getattr(entry, name) for entry in entries], dtype=object)

    labels = {name: column(name) for name in ("subject", "origin", "group", "sex")}
    labels |= {"age_group": column("age"), "site": column("site")}
    spectra = archive_dataset(
        np.arange(1, len(records) + 1),
        labels,
        records[0].wavelengths,
        np.stack([record.reflectance for record in records]),
        dict(attributes),
    )
    return spectra.assign_coords(
        condition=("record", column("condition")),
        repeat=("record", column("repeat").astype(np.int64)),
        file=("record", column("file")),
    )


def without(
    spectra: xarray.Dataset, dropped: NDArray[np.bool_], why: str
) -> tuple[xarray.Dataset, list[Gap]]:
    """Return the spectra less some records (n,), and the gaps that these leave."""
    gaps = [
        Gap(
            LEFT_OUT,
            str(spectra["subject"].values[i]),
            str(spectra["site"].values[i]),
            str(spectra["condition"].values[i]),
            int(spectra["repeat"].values[i]),
            str(spectra["file"].values[i]),
            why,
        )
        for i in np.flatnonzero(dropped)
    ]
    return spectra.isel(record=np.flatnonzero(~dropped)), gaps


def without_duplicates(spectra: xarray.Dataset) -> tuple[xarray.Dataset, list[Gap]]:
    """Return the spectra that stand under one subject only, and the gaps."""
    why = "the same spectrum stands under another subject too"
    kept, gaps = without(spectra, spectra["duplicate"].values, why)
    if not kept.sizes["record"]:
        raise SkinvizError(f"no record can be used: of each {why}")
    return kept, gaps


def cells_of(spectra: xarray.Dataset) -> list[tuple[str, str, str]]:
    """Return subject, site and condition of each record."""
    keys = ("subject", "site", "condition")
    return list(zip(*(spectra[key].values.tolist() for key in keys), strict=True))


def missing_cells(
    cells: Iterable[tuple[str, str, str]],
    explained: Iterable[tuple[str, str, str]],
    named: Iterable[str] = (),
) -> list[Gap]:
    """Return a gap for each subject, site and condition without any record.

    Parameters
    ----------
    cells : iterable of (str, str, str)
        Subject, site and condition of each record that is used.
    explained : iterable of (str, str, str)
        The same of records that were left out, which have gaps of their own.
    named : iterable of str
        Subjects that the study knows, with records or without.
    """
    there, told = dict.fromkeys(cells), dict.fromkeys(explained)
    subjects = dict.fromkeys(key[0] for key in (*there, *told) if key[0])
    sites, conditions = (dict.fromkeys(key[i] for key in there) for i in (1, 2))
    return [
        Gap(MISSING, subject, site, condition, 0, "", "no record")
        for subject in dict.fromkeys((*subjects, *named))
        for site in sites
        for condition in conditions
        if (subject, site, condition) not in there
        and (subject, site, condition) not in told
    ]


def _record(entry: Entry, spectra: xarray.Dataset) -> Record:
    """Return the spectrum that an entry means, or say why there is none to use."""
    if "sample" in spectra.sizes:
        raise SkinvizError(CUBE)
    labels = [str(label) for label in spectra["label"].values]
    if entry.label and entry.label not in labels:
        raise SkinvizError(
            f"has no spectrum {entry.label!r}; there is {', '.join(labels[:5])}"
        )
    if labels.count(entry.label) > 1:
        raise SkinvizError(f"has several spectra {entry.label!r}")
    if not entry.label and len(labels) > 1:
        raise SkinvizError(f"has {len(labels)} spectra; say which by its label")
    row = labels.index(entry.label) if entry.label else 0
    bands = spectra["wavelength"].values.astype(np.float64)
    values = spectra["reflectance"].values[row].astype(np.float64)
    known = bands[np.isfinite(values)]
    if not known.size or known[0] > _COVERED[0] or known[-1] < _COVERED[1]:
        reach = f"covers {known[0]:g} to {known[-1]:g} nm" if known.size else "is empty"
        raise SkinvizError(f"{reach}; a fit needs 400 to 700 nm")
    return Record(entry, bands, values)


def _said(wavelengths: Array) -> str:
    """Return a grid in words."""
    step = np.diff(wavelengths)
    even = f" by {step[0]:g}" if step.size and np.allclose(step, step[0]) else ""
    return f"{wavelengths[0]:g}-{wavelengths[-1]:g} nm{even}"
