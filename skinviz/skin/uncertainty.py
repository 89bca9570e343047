"""How sure a least-squares fit is: covariance and 95 % intervals, within bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.solver import Solution

Array = NDArray[np.float64]

LEVEL = 0.95
"""Probability that an interval is meant to hold."""

_TINY = 1e-300  # keeps quotients finite where residuals or slopes vanish
_NO_SHARE = 1e-12  # of a direction: the rounding in an eigenvector, squared
_FAR = 30.0  # standard deviations, where the normal tail's own quantile underflows


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
        Of the free parameters; rows and columns of held ones are 0. The variance
        of one that the data do not determine is infinite.
    interval : (m, p, 2) ndarray
        A free parameter: Student's t (normal if ``absolute``), cut at the bounds.
        A held one: the parabola that the residuals draw along it while the free
        ones adapt, as a normal density cut off at the bound; its 95 % quantile.
    """
    residual = weights * (found.predicted - target)
    information = np.einsum("mnp,mn,mnq->mpq", found.jacobian, weights, found.jacobian)
    freedom = np.maximum(n_used - (~found.held).sum(axis=1), 1)
    cost = (residual * (found.predicted - target)).sum(axis=1)
    variance = np.ones(len(cost)) if absolute else cost / freedom

    covariance = _scaled(_inverse(information, ~found.held), variance)
    deviation = np.sqrt(_diagonal(covariance))
    half = _quantile(freedom, absolute=absolute)[:, None] * deviation
    lower, upper = found.values - half, found.values + half

    # A held parameter is let go alone, so that the free ones adapt to it.
    sigma = np.zeros_like(found.values)
    for k in range(found.values.shape[1]):
        freed = ~found.held | (np.arange(found.values.shape[1]) == k)
        variances = _diagonal(_scaled(_inverse(information, freed), variance))
        sigma[:, k] = np.sqrt(variances[:, k])
    slope = np.abs(np.einsum("mnp,mn->mp", found.jacobian, residual))
    reach = _one_sided_reach(slope / np.maximum(variance, _TINY)[:, None], sigma)
    low, high = bounds
    upper = np.where(found.held & (found.values <= low), found.values + reach, upper)
    lower = np.where(found.held & (found.values > low), found.values - reach, lower)
    interval = np.stack([np.clip(lower, low, high), np.clip(upper, low, high)], axis=-1)
    return covariance, interval


def _inverse(information: Array, chosen: NDArray[np.bool_]) -> Array:
    """Return the inverse (m, p, p) over the chosen parameters, 0 for the others.

    A parameter that the data do not determine, alone or among the chosen, has an
    infinite variance and no covariance.
    """
    p = chosen.shape[1]
    diagonal = _diagonal(information)
    moving = chosen & (diagonal > 0)
    both = moving[:, :, None] & moving[:, None, :]
    scale = np.sqrt(np.where(moving, diagonal, 1.0))
    scales = scale[:, :, None] * scale[:, None, :]
    values, vectors = np.linalg.eigh(np.where(both, information / scales, np.eye(p)))
    empty = values <= 4 * p * np.finfo(np.float64).eps
    inverted = np.where(empty, 0.0, 1 / np.where(empty, 1.0, values))
    inverse = np.einsum("mpk,mk,mqk->mpq", vectors, inverted, vectors)
    loose = (empty[:, None, :] & (vectors**2 > _NO_SHARE)).any(axis=2)
    loose = chosen & (loose | ~moving)
    tied = both & ~(loose[:, :, None] | loose[:, None, :])
    return np.where(
        loose[:, :, None] & np.eye(p, dtype=bool),
        np.inf,
        np.where(tied, inverse / scales, 0.0),
    )


def _scaled(inverse: Array, variance: Array) -> Array:
    """Return an inverse times the variances (m,), infinity staying infinite."""
    finite = np.where(np.isinf(inverse), 0.0, inverse)
    return np.where(np.isinf(inverse), np.inf, finite * variance[:, None, None])


def _diagonal(matrices: Array) -> Array:
    """Return the diagonals (m, p) of matrices (m, p, p)."""
    return np.asarray(np.einsum("mpp->mp", matrices))


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

    flat = np.isinf(sigma)
    width = np.where(flat, 0.0, sigma)
    offset = slope * width
    near = width * (norm.isf((1 - LEVEL) * norm.sf(offset)) - offset)
    # Far in the tail the density is exponential with the slope.
    far = -np.log(1 - LEVEL) / np.maximum(slope, _TINY)
    return np.where(flat, np.inf, np.where(offset < _FAR, near, far))
