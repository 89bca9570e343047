"""Light by its relative spectral power: CIE tables, black bodies, measured lamps.

What does not belong here: directions and strengths, which a scene's lights have, and
the formats of files (:mod:`skinviz.spectra.formats`).
"""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass
from difflib import SequenceMatcher, get_close_matches
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_spectra, as_wavelengths, in_range
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.lamp_file import read_lamp
from skinviz.spectra.wavelengths import resample

Array = NDArray[np.float64]

COLDEST, HOTTEST = 100.0, 1e6
"""Temperatures that :func:`black_body` takes. [K]"""

_C2 = 1.4388e7  # nm K, of ITS-90 and CIE 15:2018
_VISIBLE_TENTHS = np.arange(3600, 8301) / 10  # nm
_BLACK_BODY = re.compile(
    r"(?:black[\s-]?body\s+(?:at\s+)?)?(\d+(?:\.\d*)?(?:e\d+)?)\s*K",
    re.IGNORECASE | re.ASCII,
)
_FLUORESCENT = re.compile(r"f(\d+)")


@dataclass(frozen=True, eq=False)
class Illuminant:
    """The relative spectral power of a light.

    Attributes
    ----------
    name : str
        As messages and files have it.
    wavelengths : (n,) ndarray
        Strictly ascending. [nm]
    power : (n,) ndarray
        At the wavelengths, ≥ 0 and somewhere above, in any unit per nm.

    Raises
    ------
    ArgumentError
        If the wavelengths do not ascend, or the power is negative, not finite or
        zero everywhere.
    """

    name: str
    wavelengths: Array
    power: Array

    def __post_init__(self) -> None:
        """Keep copies that nobody can change; refuse what is no light."""
        wavelengths = as_wavelengths(self.wavelengths).copy()
        what = f"the power of illuminant {self.name!r}"
        power = as_spectra(self.power, wavelengths.size, what).copy()
        if power.ndim != 1:
            raise ArgumentError(f"{what} must be one spectrum; got {power.shape}")
        dark = np.flatnonzero(power < 0)
        if dark.size:
            raise ArgumentError(
                f"{what} must be ≥ 0; it is {power[dark[0]]:g} at "
                f"{wavelengths[dark[0]]:g} nm; set noise below zero to 0"
            )
        if not power.any():
            raise ArgumentError(f"{what} is 0 everywhere, which is no light")
        for field, values in (("wavelengths", wavelengths), ("power", power)):
            values.setflags(write=False)
            object.__setattr__(self, field, values)

    def spd(self, wavelengths: ArrayLike) -> Array:
        """Return the power at wavelengths (n,) [nm], linear between the table's.

        Raises
        ------
        ArgumentError
            If a wavelength is outside the table: nothing is extrapolated.
        """
        new = as_wavelengths(wavelengths)
        return resample(self.power, self.wavelengths, new, f"illuminant {self.name}")


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
    """Return the names of the CIE illuminants that are known."""
    return _table()[0]


def cie_illuminant(name: str) -> Illuminant:
    """Return a CIE illuminant, 380–780 nm at 5 nm.

    Parameters
    ----------
    name : str
        One of :func:`illuminants`, in either case; the fluorescent lamps also as F1
        to F12.

    Returns
    -------
    illuminant : Illuminant
        100 at 560 nm for A, D and E.

    Raises
    ------
    ArgumentError
        If the name is unknown; the message lists the nearest names first.

    References
    ----------
    .. [1] CIE 15:2018, Colorimetry.
    """
    names, table = _table()
    asked = _FLUORESCENT.sub(r"fl\1", str(name).strip().casefold())
    for row, known in zip(table[1:], names, strict=True):
        if asked == known.casefold():
            return Illuminant(known, table[0], row)
    nearest = _nearest_first(asked, names)
    near = get_close_matches(asked, [nearest[0].casefold()])
    hint = f"; did you mean {nearest[0]!r}?" if near else ""
    raise ArgumentError(
        f"unknown illuminant {str(name)[:40]!r}; choose one of: {', '.join(nearest)}; "
        f"or a black body, as '3200 K'{hint}"
    )


def _nearest_first(asked: str, names: tuple[str, ...]) -> list[str]:
    """Return the names by how little they differ from what was asked for."""

    def parts(text: str) -> tuple[str, int]:
        series, number = re.sub(r"[^a-z]", "", text), re.sub(r"[^0-9]", "", text)
        return series[:40], int(number[:9] or 0)

    def distance(known: str) -> tuple[float, int]:
        series, number = parts(known.casefold())
        alike = SequenceMatcher(None, wanted, series).ratio()
        return -alike, abs(number - wanted_number)

    wanted, wanted_number = parts(asked)
    return sorted(names, key=distance)


def black_body(temperature: float) -> Illuminant:
    """Return the light of a black body by Planck's law, 100 at 560 nm.

    Parameters
    ----------
    temperature : float
        From 100 to 1e6. [K]

    Returns
    -------
    illuminant : Illuminant
        360–830 nm at 0.1 nm; every tenth of a nm is Planck's to rounding, between
        them it is straight.

    Raises
    ------
    ArgumentError
        If the temperature is outside the range.

    Notes
    -----
    c₂ is 1.4388e-2 m K, as temperatures on ITS-90 and the CIE's colour temperatures
    are defined; CODATA's 1.438777e-2 would be a temperature 16 in a million lower.
    Illuminant A was fixed with another c₂ and is the black body of 2855.5 K.

    References
    ----------
    .. [1] CIE 15:2018, Colorimetry.
    """
    kelvin = in_range(temperature, COLDEST, HOTTEST, "temperature", "K")
    nm = _VISIBLE_TENTHS
    power = 100 * (560 / nm) ** 5 * np.expm1(_C2 / kelvin / 560)
    power /= np.expm1(_C2 / kelvin / nm)
    return Illuminant(f"black body {kelvin!r} K".replace(".0 K", " K"), nm, power)


def read_illuminant(path: str | os.PathLike[str]) -> Illuminant:
    """Read the measured spectrum of a lamp.

    Parameters
    ----------
    path : str or path-like
        ``.csv`` or ``.tsv`` (two columns, or one spectrum with a header), ``.spdx``
        (IES TM-27-14), ``.cgats``, ``.txt`` or ``.sp`` (CGATS.17, ArgyllCMS).

    Returns
    -------
    illuminant : Illuminant
        Named by the file. Only the ratios of its powers matter, not their unit.

    Raises
    ------
    DataError
        If the file is missing, broken, a reflectance, or has not exactly one
        spectrum; or if that is negative, not finite, zero everywhere, or its
        wavelengths do not ascend.
    """
    file, wavelengths, power = read_lamp(path)
    try:
        return Illuminant(file.name, wavelengths, power)
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error


def as_illuminant(light: str | Illuminant) -> Illuminant:
    """Return an illuminant by its name, or as it is.

    Parameters
    ----------
    light : str or Illuminant
        A CIE name, or a black body: ``"3200 K"``, ``"black body 3200 K"``.

    Raises
    ------
    ArgumentError
        If the name is unknown or the temperature outside :func:`black_body`'s range.
    """
    if isinstance(light, Illuminant):
        return light
    hot = _BLACK_BODY.fullmatch(str(light).strip())
    return black_body(float(hot[1])) if hot else cie_illuminant(light)


def illuminant_spd(light: str | Illuminant, wavelengths: ArrayLike) -> Array:
    """Return the relative spectral power of an illuminant.

    Parameters
    ----------
    light : str or Illuminant
        As for :func:`as_illuminant`.
    wavelengths : (n,) array_like
        Within the illuminant's own, 380–780 for those of the CIE. [nm]

    Returns
    -------
    spd : (n,) ndarray of float64
        Relative power, linear between the illuminant's own wavelengths.

    Raises
    ------
    ArgumentError
        If the name is unknown or a wavelength is outside the table.
    """
    return as_illuminant(light).spd(wavelengths)
