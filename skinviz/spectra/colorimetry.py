"""From spectra to colour: tristimulus values, CIELAB, ΔE00 and sRGB."""

from __future__ import annotations

import csv
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_spectra, as_wavelengths, one_of
from skinviz.errors import ArgumentError
from skinviz.spectra.illuminants import Illuminant, illuminant_spd
from skinviz.spectra.wavelengths import band_widths, resample

Array = NDArray[np.float64]

OBSERVERS = ("cie1931", "cie1964")
"""Standard observers: 2° of 1931 (the default) and 10° of 1964."""

SRGB_FROM_XYZ = np.array(
    [
        [3.2406, -1.5372, -0.4986],
        [-0.9689, 1.8758, 0.0415],
        [0.0557, -0.2040, 1.0570],
    ]
)
"""XYZ, Y = 1 for white, to linear sRGB; IEC 61966-2-1:1999, eq. (7)."""


@cache
def _cmfs_table() -> Array:
    """Return wavelengths and both observers' functions, shape (7, n)."""
    path = files("skinviz.spectra") / "data" / "cie_cmfs_1nm.csv"
    with path.open(encoding="utf-8") as file:
        table = np.array(list(csv.reader(file))[1:], dtype=np.float64).T
    table.setflags(write=False)
    return table


def colour_matching_functions(
    wavelengths: ArrayLike, observer: str = "cie1931"
) -> Array:
    """Return x̄, ȳ, z̄ of a standard observer, interpolated from 1 nm.

    Parameters
    ----------
    wavelengths : (n,) array_like
        Within 360–830. [nm]
    observer : {"cie1931", "cie1964"}
        2° or 10°.

    Returns
    -------
    cmfs : (n, 3) ndarray of float64
        [1]
    """
    first = 1 + 3 * OBSERVERS.index(one_of(observer, OBSERVERS, "observer"))
    table = _cmfs_table()
    new = as_wavelengths(wavelengths)
    return resample(table[first : first + 3], table[0], new, "the observer's table").T


def xyz_weights(
    wavelengths: ArrayLike, illuminant: ArrayLike, observer: str = "cie1931"
) -> Array:
    """Return the weights by which reflectance becomes XYZ, perfect white Y = 1.

    Parameters
    ----------
    wavelengths : (n,) array_like
        [nm]
    illuminant : (n,) array_like
        Relative spectral power at the wavelengths.
    observer : str
        See :func:`colour_matching_functions`.

    Returns
    -------
    weights : (n, 3) ndarray of float64
        ``reflectance @ weights`` is XYZ.

    Raises
    ------
    ArgumentError
        If the illuminant is negative, or gives no light that the observer sees.
    """
    bands = as_wavelengths(wavelengths)
    spd = as_spectra(illuminant, bands.size, "illuminant")
    cmfs = colour_matching_functions(bands, observer)
    if spd.ndim != 1 or spd.min() < 0 or spd.max() == 0:
        raise ArgumentError("illuminant must be one spectrum, ≥ 0 and not all zero")
    # The largest value first, so that powers of 1e-30 or 1e30 neither vanish nor
    # overflow in the sum.
    weights = (spd / spd.max() * band_widths(bands))[:, None] * cmfs
    white = weights[:, 1].sum()
    if white == 0:
        raise ArgumentError("illuminant has no power where the observer sees")
    return np.asarray(weights / white)


def spectrum_to_xyz(
    reflectance: ArrayLike,
    wavelengths: ArrayLike,
    illuminant: str | Illuminant = "D65",
    observer: str = "cie1931",
) -> Array:
    """Return XYZ of reflectances under an illuminant, perfect white Y = 1.

    Parameters
    ----------
    reflectance : (..., n) array_like
        [1]
    wavelengths : (n,) array_like
        [nm]
    illuminant : str or Illuminant
        As for :func:`skinviz.spectra.illuminants.as_illuminant`.
    observer : str
        See :func:`colour_matching_functions`.

    Returns
    -------
    xyz : (..., 3) ndarray of float64
        Sums over the given bands, times their widths.
    """
    bands = as_wavelengths(wavelengths)
    values = as_spectra(reflectance, bands.size, "reflectance")
    return values @ xyz_weights(bands, illuminant_spd(illuminant, bands), observer)


def xyz_to_lab(xyz: ArrayLike, white: ArrayLike) -> Array:
    """Return CIELAB for XYZ and a white's XYZ, both on one scale. CIE 15:2004."""
    ratio = np.asarray(xyz, dtype=np.float64) / np.asarray(white, dtype=np.float64)
    limit = 6 / 29
    f = np.where(ratio > limit**3, np.cbrt(ratio), ratio / (3 * limit**2) + 4 / 29)
    L = 116 * f[..., 1] - 16
    a = 500 * (f[..., 0] - f[..., 1])
    b = 200 * (f[..., 1] - f[..., 2])
    return np.stack([L, a, b], axis=-1)


def lab_to_xyz(lab: ArrayLike, white: ArrayLike) -> Array:
    """Return XYZ for CIELAB and a white's XYZ, on the white's scale. CIE 15:2004."""
    L, a, b = np.moveaxis(np.asarray(lab, dtype=np.float64), -1, 0)
    y = (L + 16) / 116
    f = np.stack([y + a / 500, y, y - b / 200], axis=-1)
    limit = 6 / 29
    ratio = np.where(f > limit, f**3, 3 * limit**2 * (f - 4 / 29))
    return np.asarray(ratio * np.asarray(white, dtype=np.float64))


def delta_e_2000(lab: ArrayLike, other: ArrayLike) -> Array:
    """Return the colour difference ΔE00 of CIELAB colours.

    Parameters
    ----------
    lab, other : (..., 3) array_like
        L*, a*, b*; the shapes broadcast.

    Returns
    -------
    delta_e : (...) ndarray of float64
        With k_L = k_C = k_H = 1.

    References
    ----------
    .. [1] Sharma, Wu & Dalal, Color Res. Appl. 30:21 (2005).
    """
    L1, a1, b1 = np.moveaxis(np.asarray(lab, dtype=np.float64), -1, 0)
    L2, a2, b2 = np.moveaxis(np.asarray(other, dtype=np.float64), -1, 0)
    mean_c = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    G = 0.5 * (1 - np.sqrt(mean_c**7 / (mean_c**7 + 25.0**7)))
    a1, a2 = (1 + G) * a1, (1 + G) * a2
    C1, C2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.arctan2(b1, a1) % (2 * np.pi), np.arctan2(b2, a2) % (2 * np.pi)
    grey = (C1 == 0) | (C2 == 0)
    turn = h2 - h1
    # Rounding must not decide which way round exactly opposite hues differ.
    apart = np.abs(turn) > np.pi * (1 + 1e-12)
    turn = np.where(grey, 0.0, np.where(apart, turn - 2 * np.pi * np.sign(turn), turn))
    dL, dC = L2 - L1, C2 - C1
    dH = 2 * np.sqrt(C1 * C2) * np.sin(turn / 2)
    L, C = (L1 + L2) / 2, (C1 + C2) / 2
    h = np.where(grey, h1 + h2, (h1 + h2) / 2)
    h = np.where(apart & ~grey, np.where(h < np.pi, h + np.pi, h - np.pi), h)
    T = (
        1
        - 0.17 * np.cos(h - np.pi / 6)
        + 0.24 * np.cos(2 * h)
        + 0.32 * np.cos(3 * h + np.deg2rad(6))
        - 0.20 * np.cos(4 * h - np.deg2rad(63))
    )
    S_L = 1 + 0.015 * (L - 50) ** 2 / np.sqrt(20 + (L - 50) ** 2)
    S_C, S_H = 1 + 0.045 * C, 1 + 0.015 * C * T
    bend = np.deg2rad(30) * np.exp(-(((np.rad2deg(h) - 275) / 25) ** 2))
    R_T = -2 * np.sqrt(C**7 / (C**7 + 25.0**7)) * np.sin(2 * bend)
    l_term, c_term, h_term = dL / S_L, dC / S_C, dH / S_H
    square = l_term**2 + c_term**2 + h_term**2 + R_T * c_term * h_term
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def xyz_to_linear_srgb(xyz: ArrayLike) -> Array:
    """Return linear sRGB of XYZ with Y = 1 for display white; not clipped."""
    return np.asarray(np.asarray(xyz, dtype=np.float64) @ SRGB_FROM_XYZ.T)


def encode_srgb(linear: ArrayLike) -> Array:
    """Return sRGB's encoding of linear values clipped to [0, 1]. IEC 61966-2-1."""
    value = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    return np.where(
        value <= 0.0031308,
        12.92 * value,
        1.055 * np.maximum(value, 1e-9) ** (1 / 2.4) - 0.055,
    )


def decode_srgb(encoded: ArrayLike) -> Array:
    """Return the linear values of sRGB values in [0, 1]. IEC 61966-2-1."""
    value = np.asarray(encoded, dtype=np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
