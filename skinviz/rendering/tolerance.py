"""What it means that a picture keeps a tolerance, and how a sample can show it.

Compared are linear XYZ after exposure, before display encoding, Y clipped at 1 by
scaling, as ΔE00 with the perfect diffuser under light 1 as the white. The pixels are
those that all sixteen rays of the reference fill with skin, lit in the reference or in
the picture (a shadow left out counts), and apart from them those at edges, which some
rays miss.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.plan import MOST_SAMPLES
from skinviz.spectra.colorimetry import delta_e_2000, xyz_to_lab

Array = NDArray[np.float64]

FEW = 1000
"""Filled pixels below which the largest difference counts, not a percentile."""

_SHARE = 0.01  # of pixels, that may differ by more: the 99th percentile
_DOUBT = 0.001  # that a bound from a sample is too low
_EDGE = 2.0  # ΔE00 that edges are always allowed


@dataclass(frozen=True)
class Difference:
    """How a picture differs from the reference. ΔE00 throughout.

    Attributes
    ----------
    filled, edge : float
        99th percentile over filled and over edge pixels, 0 where there are none.
    most_filled, most_edge : float
        Largest over them, which counts where fewer than ``FEW`` are filled.
    n_filled, n_edge : int
        How many lit pixels of the reference these are.
    unlit : float
        Share of the pixels filled with skin that no light reaches in the reference. [1]
    """

    filled: float
    edge: float
    most_filled: float
    most_edge: float
    n_filled: int
    n_edge: int
    unlit: float

    def kept(self, tolerance: float) -> bool:
        """Return whether this tolerance is kept. [ΔE00]"""
        few = self.n_filled < FEW
        filled, edge = (
            (self.most_filled, self.most_edge) if few else (self.filled, self.edge)
        )
        return filled <= tolerance and edge <= edge_allowance(tolerance)


def colour_differences(xyz: Array, reference: Array, white: Array) -> Array:
    """Return ΔE00 (n,) of XYZ (n, 3), clipped at Y = 1 by scaling.

    ``white`` (3,) is the perfect diffuser under light 1; equal energy stands for it
    where its X or Z is below 0.01 Y.
    """
    if min(white[0], white[2]) < 0.01 * white[1]:
        white = np.full(3, white[1])
    return delta_e_2000(
        xyz_to_lab(_clipped(xyz), white), xyz_to_lab(_clipped(reference), white)
    )


def is_lit(xyz: Array, reference: Array) -> NDArray[np.bool_]:
    """Return which pixels (n,) are lit in a picture (n, 3) or in the reference."""
    return (xyz[:, 1] > 0) | (reference[:, 1] > 0)


def edge_allowance(tolerance: float) -> float:
    """Return what edge pixels may differ by where others may by ``tolerance``."""
    return max(tolerance, _EDGE)


def compare(
    xyz: NDArray[np.floating],
    reference: NDArray[np.floating],
    covered: NDArray[np.uint8],
    white: Array,
) -> Difference:
    """Return how a picture differs from the reference picture of the same scene.

    Parameters
    ----------
    xyz, reference : (..., 3) ndarray
        Both pictures.
    covered : (...) ndarray
        How many of the reference's sixteen rays hit the mesh.
    white : (3,) ndarray
        The perfect diffuser under light 1.
    """
    hits = np.ravel(covered)
    ours = np.reshape(xyz, (-1, 3)).astype(np.float64)
    true = np.reshape(reference, (-1, 3)).astype(np.float64)
    full = hits == MOST_SAMPLES
    lit = is_lit(ours, true)
    edges = (hits > 0) & ~full
    filled = colour_differences(ours[full & lit], true[full & lit], white)
    edge = colour_differences(ours[edges], true[edges], white)
    n_filled = int((full & (true[:, 1] > 0)).sum())
    return Difference(
        _percentile(filled),
        _percentile(edge),
        float(filled.max(initial=0.0)),
        float(edge.max(initial=0.0)),
        n_filled,
        edge.size,
        1 - n_filled / int(full.sum()) if full.any() else 0.0,
    )


def percentile_bound(differences: Array, population: int) -> float:
    """Return what the 99th percentile is below, with 99.9 % confidence.

    Parameters
    ----------
    differences : (n,) ndarray
        Of pixels drawn at random.
    population : int
        How many there are to draw from, at least n. If they are fewer than ``FEW``
        and all of them are here, the largest counts.

    Returns
    -------
    bound : float
        The order statistic that the percentile exceeds with a chance below 0.001;
        ``inf`` where the sample is too small to tell.
    """
    n = differences.size
    if n >= population and population < FEW:
        return float(differences.max(initial=0.0))
    spare = _spare(n, max(n, population))
    if spare < 0:
        return np.inf
    return float(np.partition(differences, n - 1 - spare)[n - 1 - spare])


def percentile_floor(some: Array, n: int, population: int) -> float:
    """Return what :func:`percentile_bound` of ``n`` pixels cannot be below.

    It is known from some of them (m,) already: at least as many of all exceed it.
    """
    spare = _spare(n, max(n, population))
    if spare < 0 or some.size <= spare:
        return 0.0
    return float(np.partition(some, some.size - 1 - spare)[some.size - 1 - spare])


@lru_cache
def _spare(n: int, population: int) -> int:
    """Return how many of ``n`` draws may exceed a value that is then a bound; or -1.

    If it were no bound, more than one in a hundred would exceed it: the chance of so
    few among the draws, which are not put back, is hypergeometric.
    """
    from scipy.special import gammaln

    beyond = int(_SHARE * (population - 1)) + 1

    def choices(of: int, some: NDArray[np.int64]) -> Array:
        return np.asarray(
            gammaln(of + 1.0) - gammaln(some + 1.0) - gammaln(of - some + 1.0)
        )

    few = np.arange(max(0, n - (population - beyond)), min(n, beyond) + 1)
    log = choices(beyond, few) + choices(population - beyond, n - few)
    chance = np.cumsum(np.exp(log - choices(population, np.array([n]))))
    return int(few[0]) - 1 + int(np.searchsorted(chance, _DOUBT, side="right"))


def _percentile(differences: Array) -> float:
    """Return the 99th percentile, 0 of nothing."""
    if differences.size == 0:
        return 0.0
    return float(np.percentile(differences, 100 * (1 - _SHARE)))


def _clipped(xyz: Array) -> Array:
    """Return XYZ with Y scaled down to 1 where it is above."""
    return xyz / np.maximum(xyz[..., 1:2], 1.0)
