"""Archives of skin measured on living people: the shipped ones, and files of them.

Choosing and averaging spectra is in ``archive_selection``, importing the publisher's
spreadsheet in ``issa_import``.
"""

from __future__ import annotations

import os
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np

from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.spectra.archive_data import LABELS, archive_dataset
from skinviz.spectra.archive_file import SUFFIX, read_archive

if TYPE_CHECKING:
    import pandas as pd
    import xarray

SOURCES = {
    "issa": {
        "source": "International Skin Spectra Archive, a part: Lu et al., "
        "Scientific Data 12:487 (2025), figshare 28228571.v4",
        "licence": "CC BY 4.0",
        "specular": "included",
        "geometry": "di:8°",
    },
    "nist": {
        "source": "Cooksey, Allen & Tsai, J. Res. NIST 122:26 (2017), "
        "doi 10.6028/jres.122.026",
        "licence": "US public domain",
        "specular": "included",
        "geometry": "8°:di",
    },
}
"""What is said of each shipped archive, as attributes."""

ARCHIVES = tuple(SOURCES)
"""Names of the shipped archives."""


def load_archive(name: str | os.PathLike[str]) -> xarray.Dataset:
    """Return measured skin spectra of many people.

    Parameters
    ----------
    name : {"issa", "nist"} or path
        ``"issa"``: 8,307 spectra of 1,058 people at 12 body sites, 360–740 nm at
        10 nm. ``"nist"``: 100 people's inner forearm, 400–700 nm at 5 nm. Or a
        ``.nc`` file of ``write_archive`` or ``skinviz archive import``.

    Returns
    -------
    archive : xarray.Dataset
        ``reflectance`` (record, wavelength) [1], NaN where a band was not
        measured, with coordinates ``subject``, ``origin``, ``group``, ``sex``,
        ``age_group`` and ``site`` (text, "" where unknown); ``duplicate`` (the same
        spectrum stands under another subject too: leave such records out of
        statistics), ``repeats`` (how many spectra of this subject and site there
        are besides this one) and ``two_sexes`` (the subject is recorded with more
        than one sex); attributes ``source``, ``licence``, ``specular`` and
        ``geometry``.

    Raises
    ------
    ArgumentError
        If the name is unknown.
    DataError
        If the file is missing, broken or no archive.

    Notes
    -----
    A person is an origin and a subject's number: ISSA numbers everyone once, but
    archives share numbers.
    """
    if isinstance(name, os.PathLike) or str(name).lower().endswith(SUFFIX):
        return read_archive(name)
    try:
        one_of(name, ARCHIVES, "archive")
    except ArgumentError as error:
        raise ArgumentError(f"{error}; or name a {SUFFIX} file") from error
    table = _issa_table() if name == "issa" else _nist_table()
    bands = [column for column in table.columns if column[0].isdigit()]
    return archive_dataset(
        table["record"].to_numpy(),
        {label: table[label].to_numpy(dtype=object) for label in LABELS},
        np.array([float(band) for band in bands]),
        table[bands].to_numpy(dtype=np.float64),
        SOURCES[name],
    )


def _issa_table() -> pd.DataFrame:
    """Return the shipped part of the International Skin Spectra Archive."""
    import pandas as pd

    path = files("skinviz.spectra") / "data" / "issa_2025_part_360-740nm_10nm.csv.gz"
    with path.open("rb") as file:
        return pd.read_csv(
            file,
            compression="gzip",
            dtype={"subject": str},
            keep_default_na=False,
            na_values={str(nm): [""] for nm in range(360, 741, 10)},
        )


def _nist_table() -> pd.DataFrame:
    """Return NIST's inner forearms in the columns of the other archive."""
    import pandas as pd

    path = files("skinviz.spectra") / "data"
    with (path / "nist_2017_inner_forearm_400-700nm_5nm.csv").open("rb") as file:
        wide = pd.read_csv(file, index_col=0).T
    table = wide.reset_index(drop=True)
    table.columns = [f"{nm:g}" for nm in wide.columns]
    table.insert(0, "record", np.arange(1, len(wide) + 1))
    table["subject"] = [str(i).removeprefix("subject_") for i in wide.index]
    table["origin"], table["site"] = "USA", "inner arm"
    table[["group", "sex", "age_group"]] = ""
    return table
