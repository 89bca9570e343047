"""The formulas behind the coefficient tables, and the numbers that stand in them.

The package reads the tables as they are shipped (``coefficients``);
``scripts/make_coefficients.py`` writes them from here. With x = λ/500 nm, both sets
have scattering with a Rayleigh and a Mie part, and blood as Bosschaart et al.
tabulate it.
"""

from __future__ import annotations

import csv
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.coefficients import COLUMNS, Coefficients
from skinviz.spectra.wavelengths import resample

Array = NDArray[np.float64]

TABLE_WAVELENGTHS: Array = np.arange(380.0, 781.0, 5.0)
"""Of the shipped tables. [nm]"""
TABLE_WAVELENGTHS.setflags(write=False)

_DATA = files("skinviz.skin") / "data"
_REFERENCE = 500.0  # nm, at which scattering is stated


@dataclass(frozen=True)
class EffectiveNumbers:
    """The five numbers of the ``effective`` table.

    Attributes
    ----------
    melanin_slope : float
        Exponent of melanin's fall with wavelength. [1]
    epidermis_scattering, dermis_scattering : float
        S at 500 nm. [mm⁻¹]
    rayleigh_share : float
        Share of Rayleigh scattering in the dermis at 500 nm. [1]
    mie_slope : float
        Exponent of the fall of the other scattering, of both tissues. [1]
    """

    melanin_slope: float
    epidermis_scattering: float
    dermis_scattering: float
    rayleigh_share: float
    mie_slope: float


def effective_data() -> dict[str, Any]:
    """Return ``effective.toml``: each number's value, unit, meaning and prior."""
    with (_DATA / "effective.toml").open("rb") as file:
        return tomllib.load(file)


def effective_numbers() -> EffectiveNumbers:
    """Return the numbers of the shipped ``effective`` table."""
    data = effective_data()
    names = EffectiveNumbers.__dataclass_fields__
    return EffectiveNumbers(**{name: float(data[name]["value"]) for name in names})


def effective_coefficients(
    numbers: EffectiveNumbers, name: str = "effective"
) -> Coefficients:
    """Return the table that follows from five numbers.

    Parameters
    ----------
    numbers : EffectiveNumbers
        The numbers.
    name : str
        The table's name.

    Returns
    -------
    coefficients : Coefficients
        At 380–780 nm, 5 nm. K_m = 2 · 51.9 x^−melanin_slope, S_e =
        epidermis_scattering x^−mie_slope, S_d = dermis_scattering
        (rayleigh_share x⁻⁴ + (1 − rayleigh_share) x^−mie_slope), K_h and K_dh twice
        the absorption of whole blood. [mm⁻¹]
    """
    x = TABLE_WAVELENGTHS / _REFERENCE
    melanin_at_500 = float(effective_data()["melanin_at_500"])
    slope, share = numbers.mie_slope, numbers.rayleigh_share
    oxygenated, deoxygenated = 2 * blood_absorption(TABLE_WAVELENGTHS)
    return Coefficients(
        name,
        TABLE_WAVELENGTHS,
        2 * melanin_at_500 * x**-numbers.melanin_slope,
        oxygenated,
        deoxygenated,
        _scattering(numbers.epidermis_scattering, 0.0, slope, x),
        _scattering(numbers.dermis_scattering, share, slope, x),
    )


def textbook_coefficients() -> Coefficients:
    """Return the table of published optics, K = 2 μ_a and S = ¾ μ_s′.

    Returns
    -------
    coefficients : Coefficients
        At 380–780 nm, 5 nm: Jacques' melanosome 6.6e10 λ^−3.33 mm⁻¹ [1]_, μ_s′ of
        epidermis and dermis in Rayleigh and Mie parts [2]_, blood [3]_. [mm⁻¹]

    References
    ----------
    .. [1] S. L. Jacques, Skin optics summary, Oregon Medical Laser Center (1998).
    .. [2] S. L. Jacques, Phys. Med. Biol. 58:R37 (2013), table 1, from Salomatina
       et al., J. Biomed. Opt. 11:064026 (2006).
    .. [3] N. Bosschaart et al., Lasers Med. Sci. 29:453 (2014).
    """
    x = TABLE_WAVELENGTHS / _REFERENCE
    oxygenated, deoxygenated = 2 * blood_absorption(TABLE_WAVELENGTHS)
    return Coefficients(
        "textbook",
        TABLE_WAVELENGTHS,
        2 * 6.6e10 * TABLE_WAVELENGTHS**-3.33,
        oxygenated,
        deoxygenated,
        0.75 * _scattering(6.67, 0.29, 0.689, x),
        0.75 * _scattering(4.36, 0.41, 0.562, x),
    )


def blood_absorption(wavelengths: Array) -> Array:
    """Return μ_a of whole blood (2, n), oxygenated and deoxygenated. [mm⁻¹]

    Haematocrit 45 %, saturation > 98 % and 0 %; interpolated linearly between the
    source's own wavelengths, 370–790 nm.

    Raises
    ------
    ArgumentError
        If a wavelength lies outside the source's.

    References
    ----------
    .. [1] N. Bosschaart et al., Lasers Med. Sci. 29:453 (2014), CC BY.
    """
    table = _blood_table()
    return resample(table[1:], table[0], wavelengths, "the blood table")


def table_text(coefficients: Coefficients) -> str:
    """Return a coefficient set as CSV with six digits, as it is shipped."""
    columns = (
        coefficients.wavelengths,
        coefficients.melanin,
        coefficients.oxyhaemoglobin,
        coefficients.deoxyhaemoglobin,
        coefficients.epidermis,
        coefficients.dermis,
    )
    rows = (",".join(f"{value:.6g}" for value in row) for row in np.transpose(columns))
    return "\n".join((",".join(COLUMNS), *rows)) + "\n"


@cache
def _blood_table() -> Array:
    """Return the source's wavelengths and absorption (3, n), as they stand."""
    with (_DATA / "blood.csv").open(encoding="utf-8") as file:
        table = np.array(list(csv.reader(file))[1:], dtype=np.float64).T
    table.setflags(write=False)
    return table


def _scattering(at_500: float, rayleigh: float, slope: float, x: Array) -> Array:
    """Return scattering with a Rayleigh share at 500 nm and a power law."""
    return np.asarray(at_500 * (rayleigh * x**-4 + (1 - rayleigh) * x**-slope))
