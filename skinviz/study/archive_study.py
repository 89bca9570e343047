"""An archive of measured skin as a study."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from skinviz.spectra.archive_selection import Choice, people, select
from skinviz.spectra.archives import load_archive
from skinviz.study import records as made
from skinviz.study.layers import with_layers
from skinviz.study.study import Study


def archive_study(
    name: str | os.PathLike[str],
    *,
    group: Choice = None,
    site: Choice = None,
    origin: Choice = None,
    sex: Choice = None,
    sites: Mapping[str, Mapping[str, Any]] | None = None,
) -> Study:
    """Return the people of an archive as a study.

    Parameters
    ----------
    name : {"issa", "nist"} or path
        As for :func:`load_archive`.
    group, site, origin, sex : str or iterable of str, optional
        Which spectra, as for ``select``.
    sites : mapping of str to mapping, optional
        ``{"like": SITE}`` or ``{"thickness": (epidermis, dermis)}`` [mm] of sites that
        are not in Table I; without it spectra of these are left out.

    Returns
    -------
    study : Study
        Subjects named as "China/186", several spectra of one site as repeats,
        flagged duplicates left out. All of that is in its gaps.

    Raises
    ------
    ArgumentError, DataError
        If the archive is unknown, or has no such spectra.
    """
    archive = load_archive(name)
    chosen = select(archive, group=group, site=site, origin=origin, sex=sex)
    names = people(chosen).astype(object)
    seen: Counter[tuple[str, str]] = Counter()
    repeats = np.zeros(names.size, dtype=np.int64)
    for i, key in enumerate(zip(names, chosen["site"].values, strict=True)):
        seen[key] += 1
        repeats[i] = seen[key]
    nothing = np.full(names.size, "", dtype=object)
    spectra = chosen.assign_coords(
        subject=("record", names),
        condition=("record", nothing),
        repeat=("record", repeats),
        file=("record", nothing),
    )
    spectra, layers, unknown = with_layers(spectra, sites or {})
    spectra, doubtful = made.without_duplicates(spectra)
    gaps = [*unknown, *doubtful]
    explained = [(gap.subject, gap.site, gap.condition) for gap in gaps]
    gaps += made.missing_cells(made.cells_of(spectra), explained)
    title = ", ".join([f"archive {name}", *_words(group, site, origin, sex)])
    return Study(title, spectra, layers, tuple(gaps))


def _words(*choices: Choice) -> list[str]:
    """Return what was chosen, in words."""
    listed = [[c] if isinstance(c, str) else list(c) for c in choices if c is not None]
    return [" or ".join(map(str, choice)) for choice in listed]
