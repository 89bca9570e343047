"""Optical coefficients of skin, and layer thickness by body site: the tables.

Each coefficient set is one CSV file with the columns ``wavelength_nm, K_m_mm1,
K_h_mm1, K_dh_mm1, S_e_mm1, S_d_mm1``; sources and licences are in
``data/README.md``.
"""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._files import existing_file
from skinviz._validate import as_wavelengths, one_of
from skinviz.errors import ArgumentError, DataError
from skinviz.skin.kubelka_munk import LARGEST
from skinviz.spectra.wavelengths import resample

Array = NDArray[np.float64]

COLUMNS = ("wavelength_nm", "K_m_mm1", "K_h_mm1", "K_dh_mm1", "S_e_mm1", "S_d_mm1")
"""Header of a coefficient table."""

COEFFICIENT_SETS = ("effective", "textbook")
"""Names of the shipped sets; the first is the default."""


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Kubelka–Munk coefficients of pigments and tissue at some wavelengths.

    Attributes
    ----------
    name : str
        The set's name, or the path of the file it came from.
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


def load_coefficients(
    name: str | os.PathLike[str] | Coefficients = "effective",
) -> Coefficients:
    """Return a shipped coefficient set, or one from a file of your own.

    Parameters
    ----------
    name : str, path-like or Coefficients
        ``"effective"``: melanin ∝ λ^−1.88 and power-law scattering, five numbers
        fitted to 50 NIST subjects. ``"textbook"``: K = 2 μ_a and S = ¾ μ_s′ of
        Jacques' melanosome, Bosschaart's blood and Jacques' 2013 tissues. A path that
        ends in ``.csv``: a table with the header ``wavelength_nm, K_m_mm1, K_h_mm1,
        K_dh_mm1, S_e_mm1, S_d_mm1``. A set is returned as it is.

    Returns
    -------
    coefficients : Coefficients
        The shipped ones are 380–780 nm at 5 nm.

    Raises
    ------
    ArgumentError
        If the name is none of these.
    DataError
        If the file is missing, has another header, or a value that is no number,
        negative or beyond 1e16; the message names the line.
    """
    if isinstance(name, Coefficients):
        return name
    if str(name).lower().endswith(".csv"):
        file = existing_file(name, DataError)
        return _read_table(file, str(file.resolve()))
    return _shipped(one_of(name, COEFFICIENT_SETS, "coefficient set (or a .csv file)"))


@cache
def _shipped(name: str) -> Coefficients:
    """Return a shipped set."""
    with as_file(files("skinviz.skin") / "data" / f"{name}.csv") as path:
        return _read_table(path, name)


def _read_table(path: Path, name: str) -> Coefficients:
    """Return the set in a CSV file, or say in which line it is none."""
    try:
        rows = list(csv.reader(path.read_text("utf-8-sig").splitlines()))
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path}: not a text file of comma-separated values") from error
    if not rows or tuple(cell.strip() for cell in rows[0]) != COLUMNS:
        raise DataError(
            f"{path} line 1: a coefficient table has the header {','.join(COLUMNS)}"
        )
    table = [_row(row, number, path) for number, row in enumerate(rows[1:], 2) if row]
    if not table:
        raise DataError(f"{path}: a header and no coefficients")
    columns = np.array(table, dtype=np.float64).T
    try:
        as_wavelengths(columns[0])
    except ArgumentError as error:
        raise DataError(f"{path}: {error}") from error
    columns.setflags(write=False)
    return Coefficients(name, *columns)


def _row(cells: list[str], number: int, path: Path) -> list[float]:
    """Return the numbers of one line, or say what is wrong with it."""
    try:
        values = [float(cell) for cell in cells]
    except ValueError as error:
        raise DataError(f"{path} line {number}: {error}") from error
    if len(values) != len(COLUMNS) or not all(0 <= v <= LARGEST for v in values):
        raise DataError(
            f"{path} line {number}: {len(COLUMNS)} numbers from 0 to {LARGEST:g} are "
            f"expected; got {', '.join(cells)[:80]!r}"
        )
    return values


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
