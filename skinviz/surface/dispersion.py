"""Refractive index by wavelength, and how Fresnel's law factors over it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_NODES = 4


def dispersion_basis(n: ArrayLike) -> tuple[Array, Array]:
    """Return nodes n_i (k,) and weights (k, bands): F(μ, n(λ)) ≈ Σ F(μ, n_i) w_i(λ).

    Interpolation between Chebyshev's nodes over the indices (bands,) that occur; one
    node where they are equal.
    """
    index = np.asarray(n, dtype=np.float64)
    low, high = index.min(), index.max()
    if low == high:
        return np.array([low]), np.ones((1, index.size))
    turns = np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
    nodes = (low + high) / 2 + (high - low) / 2 * turns
    weights = np.ones((_NODES, index.size))
    for i in range(_NODES):
        for j in range(_NODES):
            if i != j:
                weights[i] *= (index - nodes[j]) / (nodes[i] - nodes[j])
    return nodes, weights
