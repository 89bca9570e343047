"""Spectral lines: power at single wavelengths, and how bands hold it.

What does not belong here: the lamps that give lines (:mod:`.illuminants`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError
from skinviz.spectra.wavelengths import band_widths

Array = NDArray[np.float64]

_SAME = 1e-9  # relative difference of two wavelengths that only rounding keeps apart


def as_lines(lines: ArrayLike, what: str) -> Array:
    """Return lines as a (k, 2) array of wavelength [nm] and power, checked.

    Raises
    ------
    ArgumentError
        If they are no pairs of finite numbers, a wavelength is not above 0, the
        wavelengths do not ascend, or a power is negative.
    """
    pairs = as_numbers(lines, what)
    if pairs.ndim != 2 or pairs.shape[1] != 2:
        raise ArgumentError(
            f"{what} must be pairs of wavelength and power, as [[435.8, 0.3], "
            f"[546.1, 1]]; got shape {pairs.shape}"
        )
    if not np.isfinite(pairs).all():
        raise ArgumentError(f"{what} must be finite; remove NaN or infinity")
    nm, power = pairs.T
    if (nm <= 0).any():
        raise ArgumentError(f"{what} must lie above 0 nm; got {nm.min():g} nm")
    steps = np.flatnonzero(np.diff(nm) <= 0)
    if steps.size:
        i = int(steps[0]) + 1
        raise ArgumentError(
            f"{what} must be strictly ascending; line {i} is at {nm[i]:g} after "
            f"{nm[i - 1]:g} nm; sort them, and add the powers of equal ones"
        )
    dark = np.flatnonzero(power < 0)
    if dark.size:
        i = int(dark[0])
        raise ArgumentError(
            f"{what} must have powers ≥ 0; it is {power[i]:g} at {nm[i]:g} nm"
        )
    return pairs


def within(lines: Array, first: float, last: float) -> NDArray[np.bool_]:
    """Return which lines (k,) lie from the first to the last wavelength.

    A line outside by rounding alone (1e-9 of the wavelength) is inside.
    """
    nm = lines[:, 0]
    return np.asarray((nm >= first * (1 - _SAME)) & (nm <= last * (1 + _SAME)))


def deposit(lines: Array, bands: Array) -> Array:
    """Return the power per nm (n,) by which bands (n,) hold the lines (k, 2).

    Each line is shared by its two neighbouring bands such that Σ P Δλ is its power
    and Σ λ P Δλ its power times its wavelength, with the widths of
    :func:`~skinviz.spectra.wavelengths.band_widths`. Lines outside the bands are
    left out; a single band holds only a line at its own wavelength.

    Raises
    ------
    ArgumentError
        If the power over a band's width is more than a float can hold.
    """
    nm, power = lines[within(lines, bands[0], bands[-1])].T
    widths, held = band_widths(bands), np.zeros(bands.size)
    with np.errstate(over="ignore"):
        if bands.size == 1:
            return _held(held + power.sum(), bands)
        left = np.clip(np.searchsorted(bands, nm, "right") - 1, 0, bands.size - 2)
        share = (nm - bands[left]) / (bands[left + 1] - bands[left])
        share = np.clip(share, 0.0, 1.0)
        np.add.at(held, left, power * (1 - share) / widths[left])
        np.add.at(held, left + 1, power * share / widths[left + 1])
    return _held(held, bands)


def _held(power: Array, bands: Array) -> Array:
    """Return the power per nm, if it is one."""
    if not np.isfinite(power).all():
        raise ArgumentError(
            f"the lines' power at {bands[~np.isfinite(power)][0]:g} nm is too large "
            "for a float; give it in a larger unit"
        )
    return power


def lines_in_words(lines: Array) -> str:
    """Return a name for lines: their wavelengths, if they are few."""
    nm = [f"{float(x)!r} nm".replace(".0 nm", " nm") for x in lines[:, 0]]
    if len(nm) > 4:
        return f"{len(nm)} lines from {nm[0]} to {nm[-1]}"
    return " + ".join(nm)
