"""Light by its relative spectral power: CIE tables, black bodies, lamps, lines.

What does not belong here: directions and strengths, which a scene's lights have, and
the formats of files (:mod:`skinviz.spectra.formats`).
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_spectra, as_wavelengths, in_range
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.cie_illuminants import find_illuminant, table_of_illuminants
from skinviz.spectra.lamp_file import read_lamp
from skinviz.spectra.lines import as_lines, deposit, lines_in_words, within
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
_LINE = re.compile(
    r"(?:line\s+(?:at\s+)?)?(\d+(?:\.\d*)?(?:e[+-]?\d+)?)\s*nm",
    re.IGNORECASE | re.ASCII,
)


@dataclass(frozen=True, eq=False)
class Illuminant:
    """The relative spectral power of a light: a table, spectral lines, or both.

    Attributes
    ----------
    name : str
        As messages and files have it.
    wavelengths : (n,) ndarray
        Strictly ascending; none if there are only lines. [nm]
    power : (n,) ndarray
        At the wavelengths, ≥ 0, in any unit per nm.
    lines : (k, 2) ndarray, optional
        Wavelength [nm], strictly ascending, and power, ≥ 0, in the table's unit
        times nm, of each line. None if not said.

    Raises
    ------
    ArgumentError
        If wavelengths do not ascend, or power is negative, not finite or zero
        everywhere.
    """

    name: str
    wavelengths: Array
    power: Array
    lines: Array = field(default_factory=lambda: np.zeros((0, 2)))

    def __post_init__(self) -> None:
        """Keep copies that nobody can change; refuse what is no light."""
        lines = as_lines(self.lines, f"the lines of illuminant {self.name!r}").copy()
        what = f"the power of illuminant {self.name!r}"
        if np.size(self.wavelengths) or not len(lines):
            wavelengths = as_wavelengths(self.wavelengths).copy()
        else:
            wavelengths = np.zeros(0)
        power = as_spectra(self.power, wavelengths.size, what).copy()
        if power.ndim != 1:
            raise ArgumentError(f"{what} must be one spectrum; got {power.shape}")
        dark = np.flatnonzero(power < 0)
        if dark.size:
            raise ArgumentError(
                f"{what} must be ≥ 0; it is {power[dark[0]]:g} at "
                f"{wavelengths[dark[0]]:g} nm; set noise below zero to 0"
            )
        if not (power.any() or lines[:, 1].any()):
            raise ArgumentError(f"{what} is 0 everywhere, which is no light")
        own = {"wavelengths": wavelengths, "power": power, "lines": lines}
        for name, values in own.items():
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    def spd(self, wavelengths: ArrayLike) -> Array:
        """Return the power per nm of bands at wavelengths (n,) [nm].

        The table is linear between its wavelengths. Each line is shared by its two
        neighbouring bands, so that Σ P Δλ holds its power and its wavelength
        (:func:`skinviz.spectra.lines.deposit`); lines outside the bands are left
        out, and a single band holds only a line at its own wavelength.

        Raises
        ------
        ArgumentError
            If a wavelength is outside the table: nothing is extrapolated. If there
            are only lines and none with power is within the bands.
        """
        new = as_wavelengths(wavelengths)
        if self.wavelengths.size:
            what = f"illuminant {self.name}"
            table = resample(self.power, self.wavelengths, new, what)
            return table + deposit(self.lines, new) if len(self.lines) else table
        if not self.lines[within(self.lines, new[0], new[-1]), 1].any():
            raise ArgumentError(
                f"illuminant {self.name} has only lines, and none within {new[0]:g} "
                f"to {new[-1]:g} nm; choose bands around a line"
            )
        return deposit(self.lines, new)


def illuminants() -> tuple[str, ...]:
    """Return the names of the CIE illuminants that are known."""
    return table_of_illuminants()[0]


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
    known, power = find_illuminant(name)
    return Illuminant(known, table_of_illuminants()[1][0], power)


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


def line_lamp(lines: ArrayLike, name: str | None = None) -> Illuminant:
    """Return a lamp of spectral lines: a laser, or a discharge lamp at low pressure.

    Parameters
    ----------
    lines : (k, 2) array_like
        Wavelength [nm], strictly ascending, and relative power, ≥ 0, of each line.
    name : str, optional
        The lines' wavelengths if not said.

    Raises
    ------
    ArgumentError
        If the lines are no pairs, do not ascend, or have no power.

    Examples
    --------
    >>> mercury = line_lamp([[435.8, 0.3], [546.1, 1.0]])
    >>> mercury.name
    '435.8 nm + 546.1 nm'
    """
    pairs = as_lines(lines, "a lamp's lines")
    return Illuminant(name or lines_in_words(pairs), np.zeros(0), np.zeros(0), pairs)


def with_lines(lamp: Illuminant, lines: ArrayLike) -> Illuminant:
    """Return a lamp that gives also these lines (k, 2): [nm], its unit times nm."""
    more = as_lines(lines, "the lines beside a lamp")
    every = np.concatenate([lamp.lines, more])
    every = every[np.argsort(every[:, 0], kind="stable")]
    return replace(lamp, name=f"{lamp.name} + {lines_in_words(more)}", lines=every)


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
        A CIE name, a black body: ``"3200 K"``, ``"black body 3200 K"``, or a line:
        ``"632.8 nm"``.

    Raises
    ------
    ArgumentError
        If the name is unknown or the temperature outside :func:`black_body`'s range.
    """
    if isinstance(light, Illuminant):
        return light
    text = str(light).strip()
    if hot := _BLACK_BODY.fullmatch(text):
        return black_body(float(hot[1]))
    if line := _LINE.fullmatch(text):
        return line_lamp([[float(line[1]), 1.0]])
    return cie_illuminant(light)


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
        Relative power, as by :meth:`Illuminant.spd`.

    Raises
    ------
    ArgumentError
        If the name is unknown or a wavelength is outside the table.
    """
    return as_illuminant(light).spd(wavelengths)
