"""How sure a least-squares fit is: covariance and 95 % intervals, within bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._compile import compiled, inlined
from skinviz.skin.cholesky import factorise, substitute

if TYPE_CHECKING:
    from skinviz.skin.problem import Solutions

Array = NDArray[np.float64]

LEVEL = 0.95
"""Probability that an interval is meant to hold."""

_TINY = 1e-300  # keeps quotients finite where residuals or slopes vanish
_NO_SHARE = 1e-12  # of a direction: the rounding in an eigenvector, squared
_FAR = 30.0  # standard deviations, where the normal tail's own quantile underflows
_POOR = 1e-9  # pivot of a matrix of unit diagonal that asks for the careful inverse


def covariance_and_interval(
    found: Solutions, stiffness: Array, bounds: Array, *, absolute: bool
) -> tuple[Array, Array]:
    """Return the covariance and the 95 % intervals of m fits.

    Parameters
    ----------
    found : Solutions
        Where the solver stopped.
    stiffness : (p,) ndarray
        1/variance of each parameter's prior, 0 for none.
    bounds : (2, p) ndarray
        Lowest and highest values.
    absolute : bool
        Whether σ of the data is known. If not, the residuals say how large it is.

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
    freedom = np.maximum(found.n_used - (~found.held).sum(axis=1), 1)
    variance = found.unit if absolute else found.cost / freedom
    p = stiffness.size
    information = found.information.copy()
    information[:, range(p), range(p)] += variance[:, None] * stiffness
    covariance = np.zeros_like(information)
    alone = np.zeros_like(found.values)
    poor = np.zeros(len(variance), dtype=np.bool_)
    _invert(information, found.held, covariance, alone, poor)
    if poor.any():
        covariance[poor], alone[poor] = _careful(information[poor], found.held[poor])
    covariance = _scaled(covariance, variance)
    half = _quantile(freedom, absolute=absolute)[:, None] * np.sqrt(
        _diagonal(covariance)
    )
    lower, upper = found.values - half, found.values + half

    rows, columns = np.nonzero(found.held)
    width = np.sqrt(alone[rows, columns]) * np.sqrt(variance[rows])
    slope = np.abs(found.pull[rows, columns]) / np.maximum(variance[rows], _TINY)
    reach = _one_sided_reach(slope, width)
    values, low = found.values[rows, columns], bounds[0, columns]
    upper[rows, columns] = np.where(values <= low, values + reach, values)
    lower[rows, columns] = np.where(values <= low, values, values - reach)
    interval = np.stack([np.clip(lower, *bounds), np.clip(upper, *bounds)], axis=-1)
    return covariance, interval


@compiled()
def _invert(
    information: Any, held: Any, covariance: Any, alone: Any, poor: Any
) -> None:
    """Invert matrices (m, p, p) over the parameters not held.

    ``alone`` (m, p) becomes the variance of each held parameter if it alone were let
    go. Rows whose matrix is near singular are only marked in ``poor`` (m,).
    """
    p = held.shape[1]
    L, scale, column = np.zeros((p, p)), np.zeros(p), np.zeros(p)
    free = np.zeros(p, np.int64)
    for i in range(held.shape[0]):
        M = information[i]
        k = _factorise_free(M, held[i], scale, free, L)
        poor[i] = k < 0
        for c in range(p):
            if held[i, c] and k >= 0:
                rest = _unexplained(M, c, free, k, scale, L, column)
                poor[i] = poor[i] or not rest > _POOR
                alone[i, c] = 1 / (max(rest, _POOR) * scale[c] * scale[c])
        for c in range(k):
            for a in range(k):
                column[a] = 1.0 if a == c else 0.0
            substitute(L, k, column)
            for a in range(k):
                size = scale[free[a]] * scale[free[c]]
                covariance[i, free[a], free[c]] = column[a] / size


@inlined
def _factorise_free(M: Any, held: Any, scale: Any, free: Any, L: Any) -> int:
    """Factorise over the k parameters not held; return k, −1 if near singular."""
    k = 0
    for a in range(held.size):
        scale[a] = np.sqrt(M[a, a]) if M[a, a] > 0 else 1.0
        if not held[a]:
            free[k] = a
            k += 1
    for a in range(k):
        for b in range(a + 1):
            L[a, b] = M[free[a], free[b]] / (scale[free[a]] * scale[free[b]])
    return k if factorise(L, k, _POOR) else -1


@inlined
def _unexplained(
    M: Any, held: int, free: Any, k: int, scale: Any, L: Any, column: Any
) -> float:
    """Return how much of a held parameter's effect the free ones cannot copy. [1]"""
    for a in range(k):
        column[a] = M[free[a], held] / (scale[free[a]] * scale[held])
    substitute(L, k, column)
    rest = M[held, held] / (scale[held] * scale[held])
    for a in range(k):
        rest -= column[a] * M[free[a], held] / (scale[free[a]] * scale[held])
    return rest


def _careful(information: Array, held: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return covariance (m, p, p) and ``alone`` (m, p) of matrices near singular."""
    p = held.shape[1]
    alone = np.zeros(held.shape)
    for k in range(p):
        freed = ~held | (np.arange(p) == k)
        alone[:, k] = _diagonal(_inverse(information, freed))[:, k]
    return _inverse(information, ~held), np.where(held, alone, 0.0)


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
    from scipy.special import ndtri, stdtrit

    upper = (1 + LEVEL) / 2
    if absolute:
        return np.full(len(freedom), ndtri(upper))
    table = stdtrit(np.arange(1, freedom.max(initial=1) + 1), upper)
    return np.asarray(table[freedom - 1])


def _one_sided_reach(slope: Array, sigma: Array) -> Array:
    """Return the 95 % quantile of the distance d ≥ 0 from a bound.

    Its density is proportional to exp(−(d + slope σ²)²/(2σ²)).
    """
    from scipy.special import ndtr, ndtri

    flat = np.isinf(sigma)
    width = np.where(flat, 0.0, sigma)
    offset = slope * width
    near = -width * (ndtri((1 - LEVEL) * ndtr(-offset)) + offset)
    # Far in the tail the density is exponential with the slope.
    far = -np.log(1 - LEVEL) / np.maximum(slope, _TINY)
    return np.where(flat, np.inf, np.where(offset < _FAR, near, far))
