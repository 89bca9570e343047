"""Compiled noise: cells round scattered points, for veins and for furrows of skin."""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz._compile import compiled, inlined

_FAR = 1e30
_JITTER = 0.8  # of a cell, within which its point lies


@inlined
def _scrambled(h: Any) -> Any:
    """Return a whole number with its bits mixed (Steele's variant 13 of murmur)."""
    h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return h ^ (h >> np.uint64(31))


@inlined
def ridges(x: Any, y: Any, z: Any, seed: Any, slope: Any) -> Any:
    """Return how much farther the second nearest of scattered points is than the next.

    It is 0 on the walls between the points' cells, a network [1]_. There is one point
    in each unit cube; ``slope`` (3,) is made the gradient.

    References
    ----------
    .. [1] S. Worley, A cellular texture basis function, SIGGRAPH (1996) 291: F2 − F1.
    """
    i, j, k = np.floor(x), np.floor(y), np.floor(z)
    first = second = _FAR
    ax = ay = az = bx = by = bz = 0.0
    for di in range(-1, 2):
        for dj in range(-1, 2):
            for dk in range(-1, 2):
                h = _scrambled(np.uint64(np.int64(i) + di) + np.uint64(seed))
                h = _scrambled(h + np.uint64(np.int64(j) + dj))
                h = _scrambled(h + np.uint64(np.int64(k) + dk))
                # Three numbers of 21 bits each.
                u = np.float64(h & np.uint64(0x1FFFFF)) * (1.0 / 2097152)
                v = np.float64((h >> np.uint64(21)) & np.uint64(0x1FFFFF))
                w = np.float64((h >> np.uint64(42)) & np.uint64(0x1FFFFF))
                u = 0.5 + _JITTER * (u - 0.5)
                v = 0.5 + _JITTER * (v * (1.0 / 2097152) - 0.5)
                w = 0.5 + _JITTER * (w * (1.0 / 2097152) - 0.5)
                px, py, pz = x - (i + di + u), y - (j + dj + v), z - (k + dk + w)
                square = px * px + py * py + pz * pz
                if square < first:
                    second, bx, by, bz = first, ax, ay, az
                    first, ax, ay, az = square, px, py, pz
                elif square < second:
                    second, bx, by, bz = square, px, py, pz
    near, far = np.sqrt(first), np.sqrt(second)
    towards = 1 / near if near > 0 else 0.0
    away = 1 / far if far > 0 else 0.0
    slope[0] = bx * away - ax * towards
    slope[1] = by * away - ay * towards
    slope[2] = bz * away - az * towards
    return far - near


@compiled()
def all_ridges(points: Any, seed: Any, values: Any, slopes: Any) -> None:
    """Write :func:`ridges` at points (n, 3) into (n,), its gradients into (n, 3)."""
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        values[i] = ridges(x, y, z, seed, slopes[i])
