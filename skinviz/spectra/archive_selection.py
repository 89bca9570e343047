"""Choosing spectra of an archive, averaging repeats, naming them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.spectra.archive_data import LABELS, archive_dataset, person_names

if TYPE_CHECKING:
    import xarray

Choice = str | Iterable[str] | None

_LISTED = 20  # valid choices in an error: subjects are too many to read


def select(
    archive: xarray.Dataset,
    *,
    site: Choice = None,
    group: Choice = None,
    origin: Choice = None,
    sex: Choice = None,
    age_group: Choice = None,
    subject: Choice = None,
) -> xarray.Dataset:
    """Return the spectra of an archive that have all the labels asked for.

    Parameters
    ----------
    archive : xarray.Dataset
        From :func:`load_archive`.
    site, group, origin, sex, age_group, subject : str or iterable of str, optional
        A label, or several of which any will do; ``""`` is "not recorded".

    Returns
    -------
    chosen : xarray.Dataset
        In the archive's order, its flags and attributes unchanged.

    Raises
    ------
    ArgumentError
        If the archive does not have a label, or nothing has all of them; the
        message names what there is.
    """
    asked = {
        "site": site,
        "group": group,
        "origin": origin,
        "sex": sex,
        "age_group": age_group,
        "subject": subject,
    }
    kept = np.ones(archive.sizes["record"], dtype=bool)
    said: list[str] = []
    for label, choice in asked.items():
        if choice is None:
            continue
        wanted = [choice] if isinstance(choice, str) else [str(c) for c in choice]
        own = archive[label].values.astype(str)
        for value in wanted:
            _require_label(value, own, label)
        matching = kept & np.isin(own, wanted)
        name = f"{label} {' or '.join(wanted)}"
        if not matching.any():
            raise ArgumentError(
                f"no spectrum of {', '.join(said)} has {name}; with "
                f"{', '.join(said)} there is {label} {_listed(own[kept])}"
            )
        kept = matching
        said.append(name)
    return archive.isel(record=np.flatnonzero(kept))


def average_repeats(archive: xarray.Dataset) -> xarray.Dataset:
    """Return one spectrum for each person and site, duplicates left out.

    Statistics over people need this: a person measured twice must not count twice,
    and of a spectrum that stands under two people nobody knows whose it is.

    Parameters
    ----------
    archive : xarray.Dataset
        From :func:`load_archive` or :func:`select`. Average before selecting by
        sex or age, so that a person stays one.

    Returns
    -------
    averaged : xarray.Dataset
        Laid out as the archive, in the order of each person's and site's first
        record, whose number it keeps. ``reflectance`` is the mean over the records
        that have the band, NaN where none has; the coordinate ``n_spectra`` says
        how many records were averaged. A label on which the records differ is "".

    Raises
    ------
    ArgumentError
        If every record is a duplicate, or there is none.
    """
    own = archive.isel(record=np.flatnonzero(~archive["duplicate"].values))
    if not own.sizes["record"]:
        raise ArgumentError("there is no spectrum to average but duplicates")
    keys = person_names(people(own), own["site"].values)
    _, first, which, counts = np.unique(
        keys, return_index=True, return_inverse=True, return_counts=True
    )
    order = np.argsort(first)
    first, counts, which = first[order], counts[order], np.argsort(order)[which]
    labels = {label: _agreed(own[label].values, which, first) for label in LABELS}
    averaged = archive_dataset(
        own["record"].values[first],
        labels,
        own["wavelength"].values,
        set_means(own["reflectance"].values, which, counts.size),
        dict(archive.attrs),
    )
    flagged = np.zeros(counts.size, dtype=bool)
    flagged[which[own["two_sexes"].values]] = True
    return averaged.assign_coords(
        n_spectra=("record", counts), two_sexes=("record", flagged)
    )


def people(archive: xarray.Dataset) -> NDArray[np.str_]:
    """Return the person (n,) of each record: "China/186"."""
    return person_names(archive["origin"].values, archive["subject"].values)


def with_labels(archive: xarray.Dataset) -> xarray.Dataset:
    """Return the archive with the coordinate ``label``, one name a spectrum.

    "China/186 back of hand", and "UK/12 cheek 2" for the second of a person's and
    site's spectra. :func:`write_spectra` needs it.
    """
    seen: Counter[str] = Counter()
    names = []
    for person, site in zip(people(archive), archive["site"].values, strict=True):
        name = f"{person} {site}"
        seen[name] += 1
        names.append(name if seen[name] == 1 else f"{name} {seen[name]}")
    return archive.assign_coords(label=("record", np.array(names, dtype=object)))


def common_bands(archive: xarray.Dataset) -> xarray.Dataset:
    """Return the bands that every spectrum has.

    Raises
    ------
    ArgumentError
        If there is none.
    """
    everywhere = np.isfinite(archive["reflectance"].values).all(axis=0)
    if not everywhere.any():
        raise ArgumentError(
            "there is no band that all the chosen spectra have; choose fewer"
        )
    return archive.isel(wavelength=np.flatnonzero(everywhere))


def set_means(
    values: NDArray[np.float64], which: NDArray[np.int64], n_sets: int
) -> NDArray[np.float64]:
    """Return the mean (sets, m) of each set's numbers, NaN left out.

    Parameters
    ----------
    values : (n, m) ndarray
        Spectra, or what else was measured; NaN where it was not.
    which : (n,) ndarray of int
        The set of each.
    n_sets : int
        How many sets there are.
    """
    measured = np.isfinite(values)
    total = np.zeros((n_sets, values.shape[1]))
    count = np.zeros_like(total)
    np.add.at(total, which, np.where(measured, values, 0.0))
    np.add.at(count, which, measured)
    return np.asarray(np.where(count, total / np.maximum(count, 1), np.nan))


def _require_label(value: str, own: NDArray[np.str_], label: str) -> None:
    """Refuse a label that no record has, naming those there are."""
    known = np.unique(own)
    if value in known:
        return
    name = label.replace("_", " ")
    if known.size > _LISTED:
        raise ArgumentError(f"unknown {name} {value!r}; there is {_listed(own)}")
    one_of(value, [str(choice) for choice in known if choice], name)


def _listed(own: NDArray[np.str_]) -> str:
    """Return the distinct labels in words, the first ones if there are many."""
    known = sorted({label for label in own if label}, key=_by_number)
    if len(known) > _LISTED:
        return f"{', '.join(known[:3])} ... {known[-1]} ({len(known)} of them)"
    return ", ".join(known) or "none recorded"


def _by_number(label: str) -> tuple[bool, int, str]:
    """Return a key that sorts "9" before "10"."""
    return (not label.isdigit(), int(label) if label.isdigit() else 0, label)


def _agreed(
    values: NDArray[Any], which: NDArray[np.int64], first: NDArray[np.int64]
) -> NDArray[Any]:
    """Return each set's label, "" where its records differ."""
    agreed = values[first].copy()
    agreed[which[values != agreed[which]]] = ""
    return np.asarray(agreed)
