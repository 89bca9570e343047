"""How sure a least-squares fit is: covariance and 95 % intervals, within bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.solver import Solution

Array = NDArray[np.float64]

LEVEL = 0.95
"""Probability that an interval is meant to hold."""

_TINY = 1e-300  # keeps quotients finite where the data determine nothing


def covariance_and_interval(
    found: Solution,
    target: Array,
    weights: Array,
    *,
    n_used: NDArray[np.int64],
    bounds: Array,
    absolute: bool,
) -> tuple[Array, Array]:
    """Return the covariance and the 95 % intervals of m fits.

    Parameters
    ----------
    found : Solution
        Where the solver stopped.
    target, weights : (m, n) ndarray
        What was fitted, and the weights of the bands.
    n_used : (m,) ndarray of int
        Bands that had weight.
    bounds : (2, p) ndarray
        Lowest and highest values.
    absolute : bool
        Whether the weights are 1/σ². If not, the residuals say how large σ is.

    Returns
    -------
    covariance : (m, p, p) ndarray
        Of the free parameters; rows and columns of held ones are 0.
    interval : (m, p, 2) ndarray
        A free parameter: Student's t (normal if ``absolute``), cut at the bounds.
        A held one: the parabola that the residuals draw along it, as a normal
        density cut off at the bound; its 95 % quantile, one-sided.
    """
    residual = weights * (found.predicted - target)
    information = np.einsum("mnp,mn,mnq->mpq", found.jacobian, weights, found.jacobian)
    freedom = np.maximum(n_used - (~found.held).sum(axis=1), 1)
    cost = (residual * (found.predicted - target)).sum(axis=1)
    variance = np.ones(len(cost)) if absolute else cost / freedom

    free = ~found.held
    both = free[:, :, None] & free[:, None, :]
    inverse = np.linalg.pinv(
        np.where(both, information, np.eye(free.shape[1])), hermitian=True
    )
    covariance = np.where(both, inverse, 0.0) * variance[:, None, None]

    deviation = np.sqrt(np.maximum(np.einsum("mpp->mp", covariance), 0.0))
    half = _quantile(freedom, absolute=absolute)[:, None] * deviation
    lower, upper = found.values - half, found.values + half

    scale = np.maximum(variance, _TINY)[:, None]
    curvature = np.einsum("mpp->mp", information) / scale
    slope = np.abs(np.einsum("mnp,mn->mp", found.jacobian, residual)) / scale
    reach = _one_sided_reach(slope, 1 / np.sqrt(np.maximum(curvature, _TINY)))
    low, high = bounds
    upper = np.where(found.held & (found.values <= low), found.values + reach, upper)
    lower = np.where(found.held & (found.values > low), found.values - reach, lower)
    interval = np.stack([np.clip(lower, low, high), np.clip(upper, low, high)], axis=-1)
    return covariance, interval


def _quantile(freedom: NDArray[np.int64], *, absolute: bool) -> Array:
    """Return how many standard deviations reach the interval's ends (m,)."""
    from scipy.stats import norm, t

    upper = (1 + LEVEL) / 2
    if absolute:
        return np.full(len(freedom), norm.ppf(upper))
    return np.asarray(t.ppf(upper, freedom))


def _one_sided_reach(slope: Array, sigma: Array) -> Array:
    """Return the 95 % quantile of the distance d ≥ 0 from a bound.

    Its density is proportional to exp(−(d + slope σ²)²/(2σ²)).
    """
    from scipy.stats import norm

    offset = slope * sigma
    far = norm.isf((1 - LEVEL) * norm.sf(offset))
    # Far in the tail the density is exponential with the slope.
    steep = -np.log(1 - LEVEL) / np.maximum(slope, _TINY)
    return np.where(offset < 30, sigma * (far - offset), steep)
