"""What an archive of measured skin holds, counted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from skinviz.spectra.archive_data import person_names
from skinviz.spectra.archive_selection import people

if TYPE_CHECKING:
    import xarray

NOT_RECORDED = "not recorded"
"""Stands for a label that is ""."""


def summary(archive: xarray.Dataset) -> dict[str, Any]:
    """Return counts of an archive, or of a part of it, as plain data.

    Parameters
    ----------
    archive : xarray.Dataset
        From :func:`load_archive`, whole or selected.

    Returns
    -------
    counts : dict
        ``spectra``, ``people``, ``sites``; ``wavelengths``, each covered range [nm]
        with its number of spectra; ``duplicates``; ``repeats``, the spectra that are
        not their subject's only one at the site, and the ``subject_sites`` they
        belong to; ``two_sexes``, the people recorded so; ``origin``, ``sex``,
        ``age_group`` and ``group``, each label's ``spectra`` and ``people``; ``table``,
        the same by site and group.
    """
    persons = people(archive)
    repeated = archive["repeats"].values > 0
    places = person_names(persons, archive["site"].values)
    return {
        "spectra": int(archive.sizes["record"]),
        "people": int(np.unique(persons).size),
        "sites": int(np.unique(archive["site"].values.astype(str)).size),
        "wavelengths": _ranges(archive),
        "duplicates": int(archive["duplicate"].values.sum()),
        "repeats": {
            "spectra": int(repeated.sum()),
            "subject_sites": int(np.unique(places[repeated]).size),
        },
        "two_sexes": np.unique(persons[archive["two_sexes"].values]).tolist(),
        **{
            label: _counts(archive, label)
            for label in ("origin", "sex", "age_group", "group")
        },
        "table": {
            site: _counts(part, "group") for site, part in _parts(archive, "site")
        },
    }


def _parts(archive: xarray.Dataset, label: str) -> list[tuple[str, xarray.Dataset]]:
    """Return each value of a label, "not recorded" for "", with its records."""
    own = archive[label].values.astype(str)
    return [
        (str(value) or NOT_RECORDED, archive.isel(record=np.flatnonzero(own == value)))
        for value in np.unique(own)
    ]


def _counts(archive: xarray.Dataset, label: str) -> dict[str, dict[str, int]]:
    """Return how many spectra and people each value of a label has."""
    return {
        value: {
            "spectra": int(part.sizes["record"]),
            "people": int(np.unique(people(part)).size),
        }
        for value, part in _parts(archive, label)
    }


def _ranges(archive: xarray.Dataset) -> list[dict[str, Any]]:
    """Return the ranges from first to last measured band, and how many have each."""
    measured = np.isfinite(archive["reflectance"].values)
    measured = measured[measured.any(axis=1)]
    nm = archive["wavelength"].values
    first, last = measured.argmax(axis=1), measured[:, ::-1].argmax(axis=1)
    ends = np.stack([nm[first], nm[nm.size - 1 - last]], axis=1)
    ranges, counts = np.unique(ends, axis=0, return_counts=True)
    return [
        {"from": float(low), "to": float(high), "spectra": int(count)}
        for (low, high), count in zip(ranges, counts, strict=True)
    ]
