"""Peaks of a height that every vertex of a surface has, and the passes between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.scan import topology
from skinviz.scene.geodesics import Surface

Array = NDArray[np.float64]
Whole = NDArray[np.int64]


def peaks_of(surface: Surface, height: Array) -> tuple[Whole, Array, Whole]:
    """Return the peaks (k,) of a height over the vertices, and how they are passed.

    From each, the highest pass (k,) over which a higher peak is reached, and that
    peak (k,); from the highest one, the lowest vertex and itself.
    """
    edges, _ = topology.edge_counts(surface.faces)
    uphill = np.arange(len(height))
    both = np.concatenate([edges, edges[:, ::-1]])
    order = np.argsort(height[both[:, 1]], kind="stable")
    own, other = both[order].T
    best = np.full(len(height), -1)
    best[own] = other  # the last one written is the highest neighbour
    rises = (best >= 0) & (height[best] > height)
    uphill[rises] = best[rises]
    while (uphill[uphill] != uphill).any():
        uphill = uphill[uphill]
    a, b = uphill[edges].T
    passes = np.minimum(height[edges[:, 0]], height[edges[:, 1]])
    across = np.flatnonzero(a != b)
    across = across[np.argsort(-passes[across], kind="stable")]
    peaks = np.unique(uphill[edges])
    low = dict.fromkeys(peaks.tolist(), float(height.min()))
    head = {peak: peak for peak in low}

    def top(peak: int) -> int:
        while head[peak] != peak:
            peak = head[peak]
        return peak

    for i in across.tolist():
        one, two = top(int(a[i])), top(int(b[i]))
        if one != two:
            lower, higher = sorted((one, two), key=lambda p: (height[p], p))
            head[lower], low[lower] = higher, float(passes[i])
    order = peaks.tolist()
    return peaks, np.array([low[p] for p in order]), np.array([head[p] for p in order])


def ground_of(
    surface: Surface, height: Array, peak: int, low: float
) -> NDArray[np.bool_]:
    """Return which vertices (n,) belong to a peak's ground above a height."""
    edges, _ = topology.edge_counts(surface.faces)
    inside = (height[edges] > low).all(axis=1)
    label = topology.components(len(height), edges[inside])
    return np.asarray(label == label[peak])
