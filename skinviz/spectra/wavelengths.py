"""Wavelength grids and resampling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

PAPER_WAVELENGTHS: Array = np.arange(400.0, 701.0, 5.0)
"""The paper's 61 wavelengths, 400–700 nm at 5 nm. [nm]"""
PAPER_WAVELENGTHS.setflags(write=False)


def resample(
    values: Array, old: Array, new: Array, what: str = "the spectrum"
) -> Array:
    """Return values (..., n_old) at new wavelengths by linear interpolation.

    Parameters
    ----------
    values : (..., n_old) ndarray
        Spectra on the last axis.
    old, new : (n_old,), (n_new,) ndarray
        Ascending wavelengths. [nm]
    what : str
        Named in the error.

    Returns
    -------
    resampled : (..., n_new) ndarray of float64
        In the unit of ``values``.

    Raises
    ------
    ArgumentError
        If a new wavelength lies outside the old ones: nothing is extrapolated.
    """
    if new[0] < old[0] or new[-1] > old[-1]:
        raise ArgumentError(
            f"{what} covers {old[0]:g} to {old[-1]:g} nm; {new[0]:g} to {new[-1]:g} nm "
            "was asked for, and nothing is extrapolated"
        )
    if old.size == 1:
        return values.copy()
    right = np.clip(np.searchsorted(old, new), 1, old.size - 1)
    share = (new - old[right - 1]) / (old[right] - old[right - 1])
    return np.asarray(values[..., right - 1] * (1 - share) + values[..., right] * share)


def band_widths(wavelengths: Array) -> Array:
    """Return Δλ of each band, so that Σ f Δλ is its integral; 1 for a single band."""
    if wavelengths.size == 1:
        return np.ones(1)
    return np.asarray(np.gradient(wavelengths))
