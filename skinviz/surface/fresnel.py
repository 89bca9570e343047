"""Fresnel reflectance of a smooth dielectric."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError

_LARGEST_INDEX = 1e100  # a mirror to every digit; its square is still finite


def fresnel_reflectance(cosine: ArrayLike, n: ArrayLike) -> NDArray[np.float64]:
    """Return the reflectance for unpolarised light from the outside.

    Parameters
    ----------
    cosine : array_like
        Cosine of the angle of incidence. [1], 0 to 1
    n : array_like
        Refractive index against the outside, broadcast with ``cosine``. [1], ≥ 1,
        finite

    Returns
    -------
    reflectance : ndarray of float64
        1 at grazing incidence; 0 at every angle where n = 1. [1]

    Raises
    ------
    ArgumentError
        If the index is below 1 or not finite, or the cosine outside [0, 1].
    """
    mu, index = np.asarray(cosine, np.float64), as_index(n)
    if not ((mu >= 0) & (mu <= 1 + 1e-12)).all():
        raise ArgumentError("the cosine of incidence must be in [0, 1]")
    mu = np.minimum(mu, 1.0)
    # g² = n² − sin²θ; g − μ from its square, so that n → 1 does not cancel.
    excess = (index - 1) * (index + 1)
    g = np.sqrt(excess + mu * mu)
    total = g + mu
    gap = np.divide(excess, total, out=np.zeros(total.shape), where=total > 0)
    ratio = np.divide(gap, total, out=np.zeros(total.shape), where=total > 0)
    p_over_s = (mu * total - 1) / (mu * gap + 1)
    return np.asarray(ratio**2 * (1 + p_over_s**2) / 2)


def as_index(n: ArrayLike) -> NDArray[np.float64]:
    """Return refractive indices as float64, or say which is below 1 or not finite."""
    index = as_numbers(n, "the refractive index")
    inside = (index >= 1) & (index <= _LARGEST_INDEX)
    if not inside.all():
        raise ArgumentError(
            f"the refractive index must be at least 1 and finite; got "
            f"{index[~inside].ravel()[0]:g}"
        )
    return index
