"""Fits of spectra whose scale is uncertain: an error that all bands share."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from skinviz._validate import as_measured, as_wavelengths, in_range
from skinviz.skin.fit import fit_skin
from skinviz.skin.model import SkinModel
from skinviz.skin.skin_fit import SkinFit

LARGEST_SCALE_ERROR = 0.1
"""[1]"""

_REACH = 1.959963984540054  # standard deviations of a normal 95 % interval


def fit_uncertain_scale(
    reflectance: ArrayLike,
    wavelengths: ArrayLike,
    model: SkinModel,
    *,
    scale: float,
    uncertainty: ArrayLike | None = None,
    advance: Callable[[int], object] | None = None,
) -> SkinFit:
    """Fit spectra that a white tile may have put on a wrong scale.

    A tile that is off its certificate is off in all bands alike. Such an error moves
    the weights as noise that is independent from band to band cannot, so intervals
    from the bands' own uncertainties would be too narrow.

    Parameters
    ----------
    reflectance, wavelengths, model, uncertainty, advance
        As for :func:`skinviz.fit_skin`.
    scale : float
        Standard uncertainty of all bands together, as a share. [1], 0 to 0.1

    Returns
    -------
    fit : SkinFit
        The values of :func:`skinviz.fit_skin`; covariance and intervals include the
        scale.

    Raises
    ------
    ArgumentError
        As :func:`skinviz.fit_skin`, or if the scale's uncertainty is out of range.

    Notes
    -----
    With Δ the step of the estimates when the data grow by one standard uncertainty of
    the scale, the covariance grows by ΔΔᵀ and an interval's half-widths become
    √(h² + (1.96 Δ)²).
    """
    in_range(scale, 0.0, LARGEST_SCALE_ERROR, "scale")
    data = as_measured(reflectance, as_wavelengths(wavelengths).size, "reflectance")
    fit, grown = (
        fit_skin(
            data * (1 + share),
            wavelengths,
            model,
            uncertainty=uncertainty,
            advance=advance,
        )
        for share in (0.0, scale)
    )
    step = grown.values - fit.values
    half = np.abs(fit.interval - fit.values[..., np.newaxis])
    wider = np.hypot(half, _REACH * np.abs(step)[..., np.newaxis])
    bounds = np.array([[p.lower, p.upper] for p in model.parameters])
    ends = fit.values[..., np.newaxis] + wider * np.array([-1.0, 1.0])
    return dataclasses.replace(
        fit,
        covariance=fit.covariance + step[..., np.newaxis] * step[..., np.newaxis, :],
        interval=np.clip(ends, bounds[:, 0, np.newaxis], bounds[:, 1, np.newaxis]),
    )
