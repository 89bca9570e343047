"""Which body site has the most of something: paired within people, and corrected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, one_of
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

LEVEL = 0.95
"""Probability that an interval is meant to hold; 1 minus it decides a test."""

FEWEST = 6
"""Pairs under which no order of the differences is rarer than 5 %."""

EXTREMES = ("most", "least")
"""What can be claimed of a site."""


@dataclass(frozen=True)
class Contrast:
    """How paired values differ.

    Attributes
    ----------
    n : int
        Pairs.
    difference : float
        Hodges and Lehmann's median of the differences, first minus second.
    interval : (float, float)
        Its 95 % interval.
    effect : float
        Matched-pairs rank-biserial correlation: 1 if the first is always larger,
        −1 if always smaller, 0 if the ranks balance. [1]
    share : float
        Of the pairs in which the first is larger; ties count half. [1]
    p : float
        Two-sided, of Wilcoxon's signed-rank test.
    """

    n: int
    difference: float
    interval: tuple[float, float]
    effect: float
    share: float
    p: float


def paired_contrast(first: ArrayLike, second: ArrayLike) -> Contrast:
    """Return how the values of the same people at two sites differ.

    Parameters
    ----------
    first, second : (n,) array_like
        A value a person; pairs of which one is NaN are left out.

    Raises
    ------
    ArgumentError
        If fewer than 6 pairs are left, or the lengths differ.

    Notes
    -----
    p is exact up to 50 pairs without ties; else the normal approximation's, ties
    corrected, zero differences ranked and their ranks left out [1]_. The interval is
    that of the Walsh averages.

    References
    ----------
    .. [1] J. W. Pratt, J. Am. Stat. Assoc. 54:655 (1959).
    .. [2] D. S. Kerby, Comprehensive Psychology 3:1 (2014): the effect size.
    """
    from scipy.stats import rankdata, wilcoxon

    a, b = as_numbers(first, "first"), as_numbers(second, "second")
    if a.shape != b.shape or a.ndim != 1:
        raise ArgumentError(
            f"paired values must be two lists of equal length; got {a.shape} and "
            f"{b.shape}"
        )
    gap = a - b
    gap = gap[np.isfinite(gap)]
    if gap.size < FEWEST:
        raise ArgumentError(
            f"a paired test needs at least {FEWEST} people with both values; there "
            f"are {gap.size}"
        )
    ranks = rankdata(np.abs(gap))
    above, below = ranks[gap > 0].sum(), ranks[gap < 0].sum()
    middle, interval = _walsh(gap)
    p = 1.0
    if gap.any():
        p = float(wilcoxon(gap, zero_method="pratt", method="auto").pvalue)
    return Contrast(
        n=gap.size,
        difference=middle,
        interval=interval,
        effect=float((above - below) / max(above + below, 1.0)),
        share=float(np.mean(np.sign(gap) / 2 + 0.5)),
        p=p,
    )


def verdict(contrasts: Sequence[Contrast], corrected: ArrayLike, extreme: str) -> str:
    """Return what contrasts of one site with each other one make of a claim.

    Parameters
    ----------
    contrasts : sequence of Contrast
        The site first.
    corrected : (n,) array_like
        Their p-values, corrected.
    extreme : {"most", "least"}
        What is claimed of the site.

    Returns
    -------
    verdict : str
        "holds" if every contrast says so, "contradicted" if one says the reverse,
        else "open"; each at 5 %.
    """
    sign = 1 if one_of(extreme, EXTREMES, "claim") == "most" else -1
    sure = as_numbers(corrected, "corrected") < 1 - LEVEL
    ways = np.array([sign * np.sign(contrast.effect) for contrast in contrasts])
    if (sure & (ways > 0)).all():
        return "holds"
    return "contradicted" if (sure & (ways < 0)).any() else "open"


def _walsh(gap: Array) -> tuple[float, tuple[float, float]]:
    """Return the median of the means of all pairs of differences, and its interval."""
    from scipy.special import ndtri

    n = gap.size
    i, j = np.triu_indices(n)
    means = np.sort((gap[i] + gap[j]) / 2)
    half = ndtri((1 + LEVEL) / 2) * np.sqrt(n * (n + 1) * (2 * n + 1) / 24)
    cut = max(int(np.floor(n * (n + 1) / 4 - half)), 0)
    return float(np.median(means)), (float(means[cut]), float(means[-1 - cut]))
