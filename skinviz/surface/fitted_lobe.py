"""The result of a lobe's fit: estimates, how sure they are, and the surface itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import FitError
from skinviz.surface.torrance_sparrow import TorranceSparrow, physical_beta

Array = NDArray[np.float64]

STATUSES = ("converged", "at_bound", "not_converged")
"""What can be said of a fit."""

CONVERGED, AT_BOUND, NOT_CONVERGED = STATUSES

_COVERED = 0.95  # of the probability, by an interval
_ALIKE = 1e-7  # least share of a direction in the data that still shows


@dataclass(frozen=True, eq=False)
class LobeFit:
    """Torrance–Sparrow's lobe fitted to goniometer readings.

    Attributes
    ----------
    parameters : tuple of str
        Names of what was free, in the order of ``values``.
    values : (p,) ndarray
        The estimates.
    covariance : (p, p) ndarray
        Of the estimates; rows and columns of one at its bound are 0, and the variance
        of one that the readings do not determine is infinite.
    interval : (p, 2) ndarray
        95 % interval, cut at the bounds; one-sided for one at its bound.
    status : str
        "converged", "at_bound" (converged, a parameter at its bound) or
        "not_converged".
    beta, gamma, n : float
        All three, whether free or given. [1], [rad], [1]
    masking : str
        As in :class:`skinviz.TorranceSparrow`.
    illumination, viewing : (m,) ndarray
        Angles of the readings. [rad]
    specular : (m,) ndarray
        The readings, in units of the perfect diffuser. [1]
    uncertainty : (m,) ndarray or None
        Their standard deviations, where given. [1]
    fitted : (m,) ndarray
        The lobe at the readings, in their unit. [1]
    """

    parameters: tuple[str, ...]
    values: Array
    covariance: Array
    interval: Array
    status: str
    beta: float
    gamma: float
    n: float
    masking: str
    illumination: Array
    viewing: Array
    specular: Array
    uncertainty: Array | None
    fitted: Array

    @property
    def surface(self) -> TorranceSparrow:
        """The surface that was found."""
        scale = self.beta / physical_beta(self.gamma)
        return TorranceSparrow(self.gamma, self.n, scale, self.masking)

    @property
    def rmse(self) -> float:
        """Root mean square difference between readings and lobe. [1]"""
        return float(np.sqrt(np.square(self.fitted - self.specular).mean()))

    @property
    def chi_square(self) -> float:
        """Sum of squared differences over their σ²; NaN where σ was not given. [1]"""
        if self.uncertainty is None:
            return float("nan")
        off = (self.fitted - self.specular) / self.uncertainty
        return float(off @ off)

    @property
    def correlation(self) -> Array:
        """Correlation of the estimates (p, p); 0 beside one at its bound. [1]"""
        deviation = np.sqrt(np.diag(self.covariance))
        known = np.isfinite(deviation) & (deviation > 0)
        scale = np.where(known, deviation, 1.0)
        own = np.where(np.isfinite(self.covariance), self.covariance, 0.0)
        return np.asarray(own / np.outer(scale, scale))

    def raise_for_status(self) -> None:
        """Raise if the fit did not converge.

        Raises
        ------
        FitError
            Says where it stopped.
        """
        if self.status == NOT_CONVERGED:
            found = ", ".join(
                f"{name} {value:g}"
                for name, value in zip(self.parameters, self.values, strict=True)
            )
            raise FitError(f"the lobe's fit did not converge; it stopped at {found}")


def covariance_and_interval(
    slopes: Array,
    residuals: Array,
    sigma: Array | None,
    values: Array,
    held: NDArray[np.bool_],
    bounds: Array,
) -> tuple[Array, Array]:
    """Return the covariance (p, p) and the 95 % interval (p, 2) of a fit.

    ``slopes`` (m, p) and ``residuals`` (m,) are of the curve; without ``sigma`` the
    residuals say how large noise is. ``held`` are the parameters at their ``bounds``
    (2, p).
    """
    from scipy.special import ndtri, stdtrit

    freedom = residuals.size - int((~held).sum())
    tail = (1 + _COVERED) / 2
    if sigma is None:
        noise = np.full(residuals.size, np.sqrt(residuals @ residuals / freedom))
        reach = float(stdtrit(freedom, tail))
    else:
        noise, reach = sigma, float(ndtri(tail))
    if not noise.any():  # a perfect fit
        nothing = np.zeros((values.size, values.size))
        return nothing, np.stack([values, values], axis=1)
    J, r = slopes / noise[:, None], residuals / noise
    covariance = _covariance(J, held)
    half = reach * np.sqrt(np.diag(covariance))
    for i in np.flatnonzero(held).tolist():
        half[i] = _one_sided_reach(J, r, held, i)
    low, high = bounds
    interval = np.stack(
        [np.maximum(values - half, low), np.minimum(values + half, high)], axis=1
    )
    return covariance, interval


def _covariance(J: Array, held: NDArray[np.bool_]) -> Array:
    """Return the inverse of JᵀJ for what is not held; infinite where it has none."""
    covariance = np.zeros((held.size, held.size))
    size = np.sqrt(np.square(J).sum(axis=0))
    covariance[np.diag_indices(held.size)] = np.where(held | (size > 0), 0.0, np.inf)
    shown = np.flatnonzero(~held & (size > 0))
    if shown.size == 0:
        return covariance
    _, share, directions = np.linalg.svd(J[:, shown] / size[shown], full_matrices=False)
    seen = share > _ALIKE * share[0]
    along = directions[seen] / share[seen, None]
    part = along.T @ along / np.outer(size[shown], size[shown])
    lost = (np.abs(directions[~seen]) > _ALIKE).any(axis=0)
    part[lost], part[:, lost] = 0.0, 0.0
    part[lost, lost] = np.inf
    covariance[np.ix_(shown, shown)] = part
    return covariance


def _one_sided_reach(J: Array, r: Array, held: NDArray[np.bool_], i: int) -> float:
    """Return how far from its bound a held parameter's 95 % reach, others adapting.

    Its density is a normal one's tail, cut at the bound.
    """
    from scipy.special import log_ndtr, ndtri_exp

    others = J[:, ~held]
    own = J[:, i] - others @ np.linalg.lstsq(others, J[:, i])[0]
    sharpness = float(np.sqrt(own @ own))
    if sharpness == 0:
        return np.inf
    offset = abs(float(J[:, i] @ r)) / sharpness
    outside = log_ndtr(-offset) + np.log(1 - _COVERED)
    return float(-ndtri_exp(outside) - offset) / sharpness
