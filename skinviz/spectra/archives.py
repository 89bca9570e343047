"""Archives of skin measured on living people, shipped with the package."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import one_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray

_SOURCES = {
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

ARCHIVES = tuple(_SOURCES)
"""Names of the shipped archives."""


def load_archive(name: str) -> xarray.Dataset:
    """Return measured skin spectra of many people.

    Parameters
    ----------
    name : {"issa", "nist"}
        ``"issa"``: 8,307 spectra of 1,058 people at 12 body sites, 360–740 nm at
        10 nm. ``"nist"``: 100 people's inner forearm, 400–700 nm at 5 nm.

    Returns
    -------
    archive : xarray.Dataset
        ``reflectance`` (record, wavelength) [1], NaN where a band was not
        measured, with coordinates ``subject``, ``origin``, ``group``, ``sex``,
        ``age_group``, ``site`` and ``duplicate`` (the same spectrum stands under
        another subject too: leave such records out of statistics); attributes
        ``source``, ``licence``, ``specular`` and ``geometry``.

    Raises
    ------
    ArgumentError
        If the name is unknown.

    Notes
    -----
    A subject's number is unique only together with its origin.
    """
    one_of(name, ARCHIVES, "archive")
    import pandas as pd

    folder = files("skinviz.spectra") / "data"
    if name == "issa":
        path = folder / "issa_2025_part_360-740nm_10nm.csv.gz"
        with path.open("rb") as file:
            table = pd.read_csv(
                file,
                compression="gzip",
                dtype={"subject": str},
                keep_default_na=False,
                na_values={str(nm): [""] for nm in range(360, 741, 10)},
            )
    else:
        path = folder / "nist_2017_inner_forearm_400-700nm_5nm.csv"
        with path.open("rb") as file:
            wide = pd.read_csv(file, index_col=0).T
        table = wide.reset_index(drop=True)
        table.columns = [f"{nm:g}" for nm in wide.columns]
        table.insert(0, "record", np.arange(1, len(wide) + 1))
        table["subject"] = [str(i).removeprefix("subject_") for i in wide.index]
        table["origin"], table["site"] = "USA", "inner arm"
        table[["group", "sex", "age_group"]] = ""
    return _dataset(table, _SOURCES[name])


def _dataset(table: pd.DataFrame, attributes: dict[str, str]) -> xarray.Dataset:
    """Return a table of labels and bands as a Dataset with its attributes."""
    import xarray

    labels = [column for column in table.columns if not column[0].isdigit()]
    bands = [column for column in table.columns if column[0].isdigit()]
    reflectance = table[bands].to_numpy(dtype=np.float64)
    people = (table["origin"] + "/" + table["subject"]).to_numpy()
    coordinates = {
        label: ("record", table[label].to_numpy())
        for label in labels
        if label != "record"
    }
    return xarray.Dataset(
        {"reflectance": (("record", "wavelength"), reflectance, {"units": "1"})},
        coords={
            "record": table["record"].to_numpy(),
            "wavelength": ("wavelength", [float(b) for b in bands], {"units": "nm"}),
            **coordinates,
            "duplicate": ("record", _duplicates(reflectance, people)),
        },
        attrs=attributes,
    )


def _duplicates(
    reflectance: NDArray[np.float64], people: NDArray[np.str_]
) -> NDArray[np.bool_]:
    """Return the records whose spectrum also stands under another person."""
    rows = np.nan_to_num(reflectance, nan=-1.0)
    _, group = np.unique(rows, axis=0, return_inverse=True)
    _, person = np.unique(people, return_inverse=True)
    pairs = np.unique(np.stack([group, person], axis=1), axis=0)
    people_per_group = np.bincount(pairs[:, 0], minlength=group.max() + 1)
    return np.asarray(people_per_group[group] > 1)
