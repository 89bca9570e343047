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


def network(points: Array, cell: Array, seed: int) -> Array:
    """Return how far places on a plane are from a network of walls (n,). [mm]

    Parameters
    ----------
    points : (n, 2) ndarray
        [mm]
    cell : (2,) ndarray
        About the size of the fields between walls. [mm]
    seed : int
        Which of all such networks.

    Returns
    -------
    distance : (n,) ndarray
        Exact to first order near a wall, along the plane. [mm]
    """
    from skinviz.scene.kernels import all_ridges

    places = np.full((len(points), 3), 0.5)  # through the middle of a layer of cells
    places[:, :2] = points / cell
    values, slopes = np.zeros(len(points)), np.zeros(places.shape)
    all_ridges(places, seed, values, slopes)
    slope = np.linalg.norm(slopes[:, :2] / cell, axis=1)
    far = np.full_like(values, np.max(cell))
    near = slope * np.max(cell) > values
    return np.asarray(np.divide(values, slope, out=far, where=near))
