"""CIE illuminants by name."""

from __future__ import annotations

import csv
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_wavelengths, one_of
from skinviz.spectra.wavelengths import resample

Array = NDArray[np.float64]


@cache
def _table() -> tuple[tuple[str, ...], Array]:
    """Return the names of the columns and the table (1 + names, n)."""
    path = files("skinviz.spectra") / "data" / "cie_illuminants_5nm.csv"
    with path.open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    table = np.array(rows[1:], dtype=np.float64).T
    table.setflags(write=False)
    return tuple(rows[0][1:]), table


def illuminants() -> tuple[str, ...]:
    """Return the names that :func:`illuminant_spd` knows."""
    return _table()[0]


def illuminant_spd(name: str, wavelengths: ArrayLike) -> Array:
    """Return the relative spectral power of a CIE illuminant.

    Parameters
    ----------
    name : str
        One of :func:`illuminants`, in either case.
    wavelengths : (n,) array_like
        Within 380–780. [nm]

    Returns
    -------
    spd : (n,) ndarray of float64
        Relative power, 100 at 560 nm for A, D and E; linear between 5 nm.

    Raises
    ------
    ArgumentError
        If the name is unknown or a wavelength is outside the table.
    """
    names, table = _table()
    known = {key.casefold(): key for key in names}
    key = known.get(str(name).casefold()) or one_of(name, names, "illuminant")
    row = table[1 + names.index(key)]
    return resample(row, table[0], as_wavelengths(wavelengths), f"illuminant {key}")
