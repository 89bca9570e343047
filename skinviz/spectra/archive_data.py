"""How an archive of measured skin is laid out, and what its records tell of faults."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray

LABELS = ("subject", "origin", "group", "sex", "age_group", "site")
"""What is recorded of each spectrum besides its number."""

ATTRIBUTES = ("source", "licence", "specular", "geometry")
"""What is said of an archive as a whole."""


def archive_dataset(
    records: NDArray[Any],
    labels: dict[str, NDArray[Any]],
    wavelengths: NDArray[np.float64],
    reflectance: NDArray[np.float64],
    attributes: dict[str, Any],
) -> xarray.Dataset:
    """Return labels (n,) and spectra (n, bands) as an archive, its faults flagged."""
    import xarray

    people = person_names(labels["origin"], labels["subject"])
    return xarray.Dataset(
        {"reflectance": (("record", "wavelength"), reflectance, {"units": "1"})},
        coords={
            "record": records,
            "wavelength": ("wavelength", wavelengths, {"units": "nm"}),
            **{label: ("record", labels[label]) for label in LABELS},
            "duplicate": ("record", _duplicates(reflectance, people)),
            "repeats": ("record", _repeats(people, labels["site"])),
            "two_sexes": ("record", _two_sexes(people, labels["sex"])),
        },
        attrs=attributes,
    )


def person_names(origins: NDArray[Any], subjects: NDArray[Any]) -> NDArray[np.str_]:
    """Return a name (n,) for each record's person: "China/186"."""
    pairs = zip(origins, subjects, strict=True)
    return np.array([f"{origin}/{subject}" for origin, subject in pairs], dtype=str)


def _duplicates(
    reflectance: NDArray[np.float64], people: NDArray[np.str_]
) -> NDArray[np.bool_]:
    """Return the records whose spectrum also stands under another person."""
    rows = np.nan_to_num(reflectance, nan=-1.0)
    _, group = np.unique(rows, axis=0, return_inverse=True)
    return np.asarray(_distinct(group, people) > 1)


def _repeats(people: NDArray[np.str_], sites: NDArray[Any]) -> NDArray[np.int64]:
    """Return how many other records there are of each record's person and site."""
    keys = person_names(people, sites)
    _, which, counts = np.unique(keys, return_inverse=True, return_counts=True)
    return np.asarray(counts[which] - 1)


def _two_sexes(people: NDArray[np.str_], sexes: NDArray[Any]) -> NDArray[np.bool_]:
    """Return the records of people for whom more than one sex is written."""
    written = np.array([bool(sex) for sex in sexes], dtype=bool)
    _, person = np.unique(people, return_inverse=True)
    flags = np.zeros(person.max(initial=-1) + 1, dtype=bool)
    if written.any():
        several = _distinct(person[written], sexes[written].astype(str)) > 1
        flags[person[written][several]] = True
    return np.asarray(flags[person])


def _distinct(group: NDArray[np.int64], labels: NDArray[Any]) -> NDArray[np.int64]:
    """Return how many distinct labels the group of each record has."""
    _, label = np.unique(labels, return_inverse=True)
    pairs = np.unique(np.stack([group, label], axis=1), axis=0)
    return np.asarray(np.bincount(pairs[:, 0], minlength=group.max() + 1)[group])
