"""Seeded random fields in space: what is uneven about skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_WAVES = 256
_NUMBERS = 2**22  # of cosines that are held at once


def smooth_noise(points: Array, size: float, rng: np.random.Generator) -> Array:
    """Return a smooth random field at points: mean 0, standard deviation 1.

    A sum of cosines with random directions and phases [1]_, nearly Gaussian, alike in
    all directions; its correlation over a distance r is exp(−r²/(2 size²)).

    Parameters
    ----------
    points : (n, 3) ndarray
        [mm]
    size : float
        Of its spots, from a middle to where it is down to 0.6. [mm]
    rng : numpy.random.Generator
        What is random.

    Returns
    -------
    values : (n,) ndarray
        [1]

    References
    ----------
    .. [1] A. Rahimi and B. Recht, Advances in Neural Information Processing Systems 20
       (2007): random Fourier features.
    """
    waves = rng.standard_normal((3, _WAVES)) / size
    phases = rng.uniform(0, 2 * np.pi, _WAVES)
    out = np.zeros(len(points))
    step = max(1, _NUMBERS // _WAVES)
    for start in range(0, len(points), step):
        part = slice(start, start + step)
        out[part] = np.cos(points[part] @ waves + phases).sum(axis=1)
    return np.asarray(np.sqrt(2 / _WAVES) * out)


def network(points: Array, seed: int) -> Array:
    """Return how far points (n, 3) are from a network of walls (n,).

    About one cell in each unit cube; near a wall the distance is exact to first order.
    """
    from skinviz.scene.kernels import all_ridges

    values, slopes = np.zeros(len(points)), np.zeros(points.shape)
    all_ridges(np.ascontiguousarray(points), seed, values, slopes)
    return np.asarray(values / np.maximum(np.linalg.norm(slopes, axis=1), 0.5))
