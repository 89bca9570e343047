"""Optical coefficients of skin, and layer thickness by body site: the tables.

Each coefficient set is one CSV file with the columns ``wavelength_nm, K_m_mm1,
K_h_mm1, K_dh_mm1, S_e_mm1, S_d_mm1``; sources and licences are in
``data/README.md``.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_wavelengths, one_of
from skinviz.errors import ArgumentError
from skinviz.spectra.wavelengths import resample

Array = NDArray[np.float64]

COEFFICIENT_SETS = ("effective", "textbook")
"""Names of the shipped sets; the first is the default."""


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Kubelka–Munk coefficients of pigments and tissue at some wavelengths.

    Attributes
    ----------
    name : str
        The set's name.
    wavelengths : (n,) ndarray
        [nm]
    melanin, oxyhaemoglobin, deoxyhaemoglobin : (n,) ndarray
        K of pure melanosome, oxygenated and deoxygenated whole blood. [mm⁻¹]
    epidermis, dermis : (n,) ndarray
        S of the two tissues. [mm⁻¹]
    """

    name: str
    wavelengths: Array
    melanin: Array
    oxyhaemoglobin: Array
    deoxyhaemoglobin: Array
    epidermis: Array
    dermis: Array

    def at(self, wavelengths: ArrayLike) -> Coefficients:
        """Return the set at other wavelengths [nm], interpolated linearly.

        Raises
        ------
        ArgumentError
            If a wavelength lies outside the table: nothing is extrapolated.
        """
        new = as_wavelengths(wavelengths)
        columns = np.stack(
            [
                self.melanin,
                self.oxyhaemoglobin,
                self.deoxyhaemoglobin,
                self.epidermis,
                self.dermis,
            ]
        )
        what = f"the {self.name!r} coefficients"
        return Coefficients(
            self.name, new, *resample(columns, self.wavelengths, new, what)
        )


@cache
def load_coefficients(name: str = "effective") -> Coefficients:
    """Return a shipped coefficient set.

    Parameters
    ----------
    name : str
        ``"effective"``: melanin ∝ λ^−1.88 and power-law scattering, five numbers
        fitted to 50 NIST subjects. ``"textbook"``: K = 2 μ_a and S = ¾ μ_s′ of
        Jacques' melanosome, Bosschaart's blood and Jacques' 2013 tissues.

    Returns
    -------
    coefficients : Coefficients
        380–780 nm at 5 nm.
    """
    one_of(name, COEFFICIENT_SETS, "coefficient set")
    with (files("skinviz.skin") / "data" / f"{name}.csv").open(encoding="utf-8") as f:
        rows = list(csv.reader(f))[1:]
    table = np.array(rows, dtype=np.float64).T
    table.setflags(write=False)
    return Coefficients(name, *table)


@cache
def _thickness_rows() -> tuple[dict[str, str], ...]:
    """Return the rows of Table I as they stand in the file."""
    table = files("skinviz.skin") / "data" / "thickness.csv"
    with table.open(encoding="utf-8") as file:
        return tuple(csv.DictReader(file))


def body_sites() -> tuple[str, ...]:
    """Return the body sites of Table I, by the names of the archives."""
    return tuple(row["site"] for row in _thickness_rows())


def layer_thickness(site: str) -> tuple[float, float]:
    """Return the thickness of epidermis and dermis at a body site. [mm]

    Parameters
    ----------
    site : str
        One of :func:`body_sites`, or the paper's own name for it.

    Returns
    -------
    epidermis, dermis : float
        Yazawa's values as printed in Table I of the paper. [mm]

    Raises
    ------
    ArgumentError
        If the site is not in the table.
    """
    name = str(site).casefold()
    for row in _thickness_rows():
        if name in (row["site"].casefold(), row["paper_name"].casefold()):
            return float(row["epidermis_mm"]), float(row["dermis_mm"])
    raise ArgumentError(
        f"unknown body site {site!r}; choose one of: {', '.join(body_sites())}; or "
        "give thickness = (epidermis, dermis) in mm"
    )
