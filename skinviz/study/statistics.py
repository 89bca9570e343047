"""Means, differences and corrected p-values of a few numbers, by Student's t.

What does not belong here: skin. Numbers that are NaN were not measured and are left
out; what cannot be said of so few is None, with the reason.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln, stdtr, stdtrit

from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

LEVEL = 0.95
"""Probability that an interval is meant to hold."""

PAIRED, WELCH, WITHIN_ORIGIN = "paired t", "Welch t", "t within origins"
"""Tests of a difference: of pairs, of two sets, of two sets origin by origin."""

COHEN, HEDGES = "Cohen d_z", "Hedges g"
"""Effect sizes: of pairs, and of two sets."""

TOO_FEW, ALIKE = "too few", "no variance"
"""Why an interval or a test cannot be had."""

CONFOUNDED = "confounded with origin"
"""Why a difference cannot be tested: no origin has both sets."""

_ROUNDING = 1e-12  # of the largest number: a smaller spread is that of rounding


@dataclass(frozen=True)
class Mean:
    """The mean of n numbers and its 95 % interval.

    Attributes
    ----------
    n : int
        Numbers that were there.
    mean, deviation : float or None
        Their mean and standard deviation (n − 1).
    low, high : float or None
        Student's t interval of the mean; None of fewer than two.
    """

    n: int
    mean: float | None
    deviation: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Difference:
    """How far a second set of numbers lies above a first.

    Attributes
    ----------
    test : str
        How it was tested.
    n : (int, int)
        Numbers of the first and of the second set that were used.
    difference : float or None
        Second less first.
    low, high : float or None
        Its 95 % interval.
    effect_name : str
        What ``effect`` is.
    effect : float or None
        The difference in standard deviations.
    p : float or None
        Two-sided; None where it cannot be had.
    why : str
        Why something is None, else "".
    """

    test: str
    n: tuple[int, int]
    difference: float | None
    low: float | None
    high: float | None
    effect_name: str
    effect: float | None
    p: float | None
    why: str = ""


def mean_interval(values: ArrayLike) -> Mean:
    """Return the mean of numbers (n,) with its 95 % t interval.

    Examples
    --------
    >>> found = mean_interval([1.0, 2.0, 3.0, 4.0])
    >>> [found.mean, round(found.low, 3), round(found.high, 3)]
    [2.5, 0.446, 4.554]
    """
    own = _there(values)
    n = own.size
    if n == 0:
        return Mean(0, None, None, None, None)
    mean = float(own.mean())
    if n == 1:
        return Mean(1, mean, None, None, None)
    deviation = float(own.std(ddof=1))
    half = _quantile(n - 1) * deviation / float(np.sqrt(n))
    return Mean(n, mean, deviation, mean - half, mean + half)


def paired_difference(first: ArrayLike, second: ArrayLike) -> Difference:
    """Return how the second numbers of pairs differ from the first.

    Parameters
    ----------
    first, second : (n,) array_like
        Of each subject, in the same order; a pair with a NaN is left out.

    Returns
    -------
    difference : Difference
        With Cohen's d_z, the mean difference over the differences' own deviation.
    """
    one, two = as_numbers(first, "first"), as_numbers(second, "second")
    if one.shape != two.shape or one.ndim != 1:
        raise ArgumentError(f"pairs need two lists as long; got {one.shape, two.shape}")
    apart = _there(two - one)
    found = mean_interval(apart)
    n = found.n
    if found.mean is None or found.deviation is None:
        return _untested(PAIRED, (n, n), found.mean, COHEN, TOO_FEW)
    scale = max(np.nanmax(np.abs(one)), np.nanmax(np.abs(two)))
    if found.deviation <= _ROUNDING * scale:
        return _untested(PAIRED, (n, n), found.mean, COHEN, ALIKE)
    effect = found.mean / found.deviation
    p = _two_sided(effect * float(np.sqrt(n)), n - 1)
    return Difference(
        PAIRED, (n, n), found.mean, found.low, found.high, COHEN, effect, p
    )


def unpaired_difference(first: ArrayLike, second: ArrayLike) -> Difference:
    """Return how a second set of numbers differs from a first of other subjects.

    Welch's t, which does not need both to spread alike, and Hedges's g: the difference
    over the pooled deviation, freed of its bias in small sets.
    """
    one, two = _there(first), _there(second)
    n = (one.size, two.size)
    apart = float(two.mean() - one.mean()) if min(n) else None
    if apart is None or min(n) < 2:
        return _untested(WELCH, n, apart, HEDGES, TOO_FEW)
    shares = np.array([one.var(ddof=1) / n[0], two.var(ddof=1) / n[1]])
    error = float(np.sqrt(shares.sum()))
    if error <= _ROUNDING * max(np.abs(one).max(), np.abs(two).max()):
        return _untested(WELCH, n, apart, HEDGES, ALIKE)
    # In shares of the whole: squares of tiny variances would underflow.
    parts = shares / shares.sum()
    freedom = float(1 / (parts**2 / (np.array(n) - 1)).sum())
    squares = one.var() * n[0] + two.var() * n[1]
    pooled = np.sqrt(squares / (sum(n) - 2))
    effect = _unbiased(sum(n) - 2) * apart / pooled
    return _tested(WELCH, n, apart, (error, freedom), float(effect))


def difference_within(
    first: ArrayLike,
    second: ArrayLike,
    first_origins: ArrayLike,
    second_origins: ArrayLike,
) -> Difference:
    """Return how two sets differ with the origin of the numbers as a factor.

    The least-squares fit of set + origin to the numbers of the origins that have both
    sets; the others cannot tell a set from their own level.

    Parameters
    ----------
    first, second : array_like
        Numbers of two sets of subjects.
    first_origins, second_origins : array_like of str
        Where each was measured.

    Returns
    -------
    difference : Difference
        With Hedges's g, over the deviation within sets and origins.
    """
    sets = (as_numbers(first, "first"), as_numbers(second, "second"))
    values = np.concatenate(sets)
    in_second = np.repeat([0.0, 1.0], [s.size for s in sets])
    origins = np.concatenate([np.asarray(o) for o in (first_origins, second_origins)])
    there = np.isfinite(values)
    values, in_second, origins = values[there], in_second[there], origins[there]
    shared = np.intersect1d(origins[in_second == 0], origins[in_second == 1])
    kept = np.isin(origins, shared)
    if not shared.size:
        n = (int((in_second == 0).sum()), int((in_second == 1).sum()))
        why = CONFOUNDED if min(n) else TOO_FEW
        return _untested(WITHIN_ORIGIN, n, None, HEDGES, why)
    values, in_second = values[kept], in_second[kept]
    _, where = np.unique(origins[kept], return_inverse=True)
    n = (int((in_second == 0).sum()), int((in_second == 1).sum()))
    size = np.abs(values).max()
    x, y = _less_means(in_second, where), _less_means(values, where)
    apart = float(x @ y / (x @ x))
    freedom = values.size - shared.size - 1
    if freedom < 2:
        return _untested(WITHIN_ORIGIN, n, apart, HEDGES, TOO_FEW)
    spread = float(np.sqrt(((y - apart * x) ** 2).sum() / freedom))
    if spread <= _ROUNDING * size:
        return _untested(WITHIN_ORIGIN, n, apart, HEDGES, ALIKE)
    error = spread / float(np.sqrt(x @ x))
    effect = _unbiased(freedom) * apart / spread
    return _tested(WITHIN_ORIGIN, n, apart, (error, freedom), effect)


def holm(p_values: ArrayLike) -> Array:
    """Return p-values (n,) corrected for their number by Holm's step-down method.

    NaN, of what was not tested, stays NaN and does not count.

    References
    ----------
    .. [1] Holm, Scand. J. Statist. 6:65 (1979).

    Examples
    --------
    >>> holm([0.01, 0.04, 0.03]).tolist()
    [0.03, 0.06, 0.06]
    """
    p = as_numbers(p_values, "p_values")
    corrected = np.full(p.shape, np.nan)
    tested = np.flatnonzero(np.isfinite(p))
    order = tested[np.argsort(p[tested], kind="stable")]
    steps = np.arange(order.size, 0, -1) * p[order]
    corrected[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return corrected


def _there(values: ArrayLike) -> Array:
    """Return the numbers that were measured."""
    own = as_numbers(values, "values").ravel()
    return own[np.isfinite(own)]


def _less_means(values: Array, where: NDArray[np.int64]) -> Array:
    """Return values less the mean of their own origin."""
    means = np.bincount(where, values) / np.bincount(where)
    return np.asarray(values - means[where])


def _tested(
    test: str,
    n: tuple[int, int],
    apart: float,
    sure: tuple[float, float],
    effect: float,
) -> Difference:
    """Return a difference of two sets, its standard error and freedom being known."""
    error, freedom = sure
    half = _quantile(freedom) * error
    p = _two_sided(apart / error, freedom)
    return Difference(test, n, apart, apart - half, apart + half, HEDGES, effect, p)


def _untested(
    test: str, n: tuple[int, int], apart: float | None, effect_name: str, why: str
) -> Difference:
    """Return a difference of which no more can be said."""
    return Difference(test, n, apart, None, None, effect_name, None, None, why)


def _quantile(freedom: float) -> float:
    """Return the quantile of Student's t that a two-sided interval reaches to."""
    return float(stdtrit(freedom, (1 + LEVEL) / 2))


def _two_sided(t: float, freedom: float) -> float:
    """Return the probability of a t as far from 0, on either side."""
    return float(2 * stdtr(freedom, -abs(t)))


def _unbiased(freedom: float) -> float:
    """Return Hedges's exact factor that makes g unbiased; of at least 2 freedoms."""
    parts = gammaln(freedom / 2) - gammaln((freedom - 1) / 2)
    return float(np.exp(parts) / np.sqrt(freedom / 2))
