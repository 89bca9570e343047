"""Noise of range: how large it is, and points that it no longer moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.scan import topology
from skinviz.scan.topology import Faces, Points

_MEDIAN_OF_NORMAL = 0.6745  # of the absolute value, in standard deviations
_SHARE = 0.5  # of the way to its neighbours' mean that a point goes in a round


def range_noise(height: NDArray[np.float64]) -> float:
    """Return the standard deviation of a grid's range from its twists. [mm]

    In a cell the difference of the two diagonals' sums is zero on any slope and
    nearly so on a curved surface: it is noise of twice the range's own.

    Parameters
    ----------
    height : (rows, columns) ndarray
        Range, NaN for no return. [mm]
    """
    twist = height[:-1, :-1] - height[:-1, 1:] - height[1:, :-1] + height[1:, 1:]
    known = np.abs(twist[np.isfinite(twist)])
    return float(np.median(known)) / (2 * _MEDIAN_OF_NORMAL) if known.size else 0.0


def smoothed(points: Points, faces: Faces, rounds: int) -> Points:
    """Return points moved towards their neighbours' mean, curvature kept.

    A plane stays where it is. What smoothing once took away is smoothed and added
    back, so that a curved surface does not shrink [1]_.

    Parameters
    ----------
    points, faces : (n, 3), (m, 3) ndarray
        A surface; points of no face stay. [mm]
    rounds : int
        The smoothing is as wide as about half their root, in edges.

    References
    ----------
    .. [1] J. W. Tukey, Exploratory Data Analysis (1977), "twicing".
    """
    if rounds == 0 or len(faces) == 0:
        return points
    once = _towards_neighbours(points, faces, rounds)
    return once + _towards_neighbours(points - once, faces, rounds)


def _towards_neighbours(values: Points, faces: Faces, rounds: int) -> Points:
    """Return values (n, 3) at points, each mixed with its neighbours' mean."""
    from scipy.sparse import coo_matrix, diags_array

    edges, _ = topology.edge_counts(faces)
    n, (a, b) = len(values), edges.T
    half = coo_matrix((np.ones(len(edges)), (a, b)), (n, n)).tocsr()
    neighbours = half + half.T
    count = np.asarray(neighbours.sum(axis=1)).ravel()
    joined = count > 0
    share = np.where(joined, _SHARE, 0.0)
    mean = diags_array(share / np.where(joined, count, 1)) @ neighbours
    for _ in range(rounds):
        values = (1 - share)[:, None] * values + mean @ values
    return values
