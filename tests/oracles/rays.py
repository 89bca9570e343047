"""Rays by brute force: every ray against every triangle, in float64."""

from typing import NamedTuple

import numpy as np


class Nearest(NamedTuple):
    """What rays meet first.

    ``triangle`` (n,) is -1 where there is nothing; ``weights`` (n, 3) are of its
    corners; ``margin`` (n,) is how far the ray's crossing is from any triangle's edge,
    as the smallest weight, of all the triangles that it crosses or just misses.
    """

    triangle: np.ndarray
    distance: np.ndarray
    weights: np.ndarray
    margin: np.ndarray


def nearest(origins, directions, points, faces):
    """Return what rays (n, 3) meet first, by Möller and Trumbore's solution.

    References
    ----------
    .. [1] J. Graphics Tools 2(1):21 (1997).
    """
    a, b, c = (points[faces[:, k]] for k in range(3))
    out = [
        _nearest(o, d, a, b - a, c - a)
        for o, d in zip(origins, directions, strict=True)
    ]
    triangle, distance, weights, margin = zip(*out, strict=True)
    return Nearest(*map(np.array, (triangle, distance, weights, margin)))


def hidden(origins, directions, lengths, points, faces):
    """Return whether anything stands within a length of rays (n, 3)."""
    return nearest(origins, directions, points, faces).distance < lengths


def _nearest(origin, direction, a, ab, ac):
    """Return triangle, distance, weights and margin of one ray."""
    across = np.cross(direction, ac)
    volume = (ab * across).sum(axis=1)
    parallel = volume == 0
    inverse = 1 / np.where(parallel, 1, volume)
    from_a = origin - a
    u = (from_a * across).sum(axis=1) * inverse
    other = np.cross(from_a, ab)
    v = (other @ direction) * inverse
    t = (ac * other).sum(axis=1) * inverse
    inner = np.minimum(np.minimum(u, v), 1 - u - v)
    ahead = ~parallel & (t > 0)
    margin = np.abs(inner[ahead]).min(initial=np.inf)
    met = np.flatnonzero(ahead & (inner >= 0))
    if met.size == 0:
        return -1, np.inf, np.zeros(3), margin
    first = met[t[met].argmin()]
    return first, t[first], (1 - u[first] - v[first], u[first], v[first]), margin
