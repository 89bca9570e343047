"""Refractive index by wavelength, and how Fresnel's law factors over it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, in_range, one_of
from skinviz.errors import ArgumentError
from skinviz.surface.fresnel import as_index, fresnel_reflectance

Array = NDArray[np.float64]

LOWEST_INDEX, HIGHEST_INDEX = 1.0, 3.0
"""Refractive indices that a surface may have."""

_MOST_NODES = 12
_TRIALS = 33  # indices at which a basis is tried
_SHARE = 0.9  # of a tolerance that is used up at the cosines below

# Dense at normal and at grazing incidence, where F varies most.
_COSINES = np.concatenate(
    [np.sin(np.linspace(0, np.pi / 2, 160)) ** 2, np.geomspace(1e-9, 1e-2, 40)]
)


@dataclass(frozen=True)
class Dispersion:
    """A refractive index that falls with wavelength: Cauchy's n = A + B/λ² + C/λ⁴.

    Attributes
    ----------
    name : str
        Of what has this index.
    a, b, c : float
        A [1], B [nm²] and C [nm⁴].
    shortest, longest : float
        Where the formula holds; it is never extrapolated. [nm]
    """

    name: str
    a: float
    b: float
    c: float = 0.0
    shortest: float = 300.0
    longest: float = 1600.0

    def __post_init__(self) -> None:
        """Refuse ranges that are none, and indices that no surface has."""
        in_range(self.shortest, 1.0, 1e6, "shortest wavelength", "nm")
        in_range(self.longest, self.shortest, 1e6, "longest wavelength", "nm")
        for value, name in ((self.a, "A"), (self.b, "B"), (self.c, "C")):
            in_range(value, -1e30, 1e30, f"Cauchy's {name}")
        # In x = 1/λ² it is a parabola: its vertex may lie inside.
        ends = np.array([self.longest, self.shortest]) ** -2.0
        vertex = -self.b / (2 * self.c) if self.c else ends[0]
        n = self._at(np.array([*ends, np.clip(vertex, *ends)]))
        if n.min() < LOWEST_INDEX or n.max() > HIGHEST_INDEX:
            raise ArgumentError(
                f"the refractive index of {self.name} must stay in [{LOWEST_INDEX:g}, "
                f"{HIGHEST_INDEX:g}] from {self.shortest:g} to {self.longest:g} nm; it "
                f"runs from {n.min():.4g} to {n.max():.4g}"
            )

    def index(self, wavelengths: ArrayLike) -> Array:
        """Return the refractive index at wavelengths (...) [nm], of the same shape.

        Raises
        ------
        ArgumentError
            If a wavelength is outside the range for which the formula holds.
        """
        nm = as_numbers(wavelengths, "wavelengths")
        inside = (nm >= self.shortest) & (nm <= self.longest)
        if not inside.all():
            raise ArgumentError(
                f"the refractive index of {self.name} is known from {self.shortest:g} "
                f"to {self.longest:g} nm; got {nm[~inside].ravel()[0]:g} nm"
            )
        return self._at(nm**-2.0)

    def _at(self, x: Array) -> Array:
        """Return n at x = 1/λ² [nm⁻²]."""
        return np.asarray(self.a + x * (self.b + x * self.c))


_READY = {
    d.name: d
    for d in (
        Dispersion("epidermis", 1.4134, 7907.9596, -389.9784),
        Dispersion("dermis", 1.3696, 3916.8026, -2558.7704),
    )
}
# Fits of Ding, Lu, Wooden, Kragel & Hu, Phys. Med. Biol. 51:1479 (2006), to skin of
# abdomen and arm at eight wavelengths, 325 to 1557 nm; doi 10.1088/0031-9155/51/6/008.


def dispersions() -> tuple[str, ...]:
    """Return the names that :func:`dispersion` knows."""
    return tuple(_READY)


def dispersion(name: str) -> Dispersion:
    """Return the measured dispersion of a tissue by name.

    References
    ----------
    .. [1] Ding, Lu, Wooden, Kragel & Hu, Phys. Med. Biol. 51:1479 (2006).

    Examples
    --------
    >>> from skinviz.surface.dispersion import dispersion
    >>> float(dispersion("epidermis").index(550))
    1.43954
    """
    return _READY[one_of(name, _READY, "dispersion")]


def require_refraction(n: object) -> None:
    """Refuse a refractive index that is neither a Dispersion nor a number of 1 to 3."""
    if not isinstance(n, Dispersion):
        in_range(n, LOWEST_INDEX, HIGHEST_INDEX, "refractive index n")  # type: ignore[arg-type]


def one_index(n: float | Dispersion, given: ArrayLike | None) -> Array:
    """Return the index that is given, or else the surface's own ``n``."""
    if given is not None:
        return as_index(given)
    if isinstance(n, Dispersion):
        raise ArgumentError(
            f"the surface's refractive index, that of {n.name}, varies with "
            "wavelength; give n, as surface.n.index(550)"
        )
    return as_index(n)


def dispersion_basis(n: ArrayLike, tolerance: float = 1e-9) -> tuple[Array, Array]:
    """Return nodes and weights with F(μ, n(λ)) = Σ F(μ, nodes_i) · weights_i(λ).

    So that a point needs Fresnel's law at a few indices instead of at every band.

    Parameters
    ----------
    n : (bands,) array_like
        Refractive indices that occur. [1], ≥ 1
    tolerance : float
        Largest relative error of F at any cosine μ. [1]

    Returns
    -------
    nodes : (k,) ndarray
        As few as keep the tolerance. Where twelve do not, as over indices of 1 to 3,
        those that occur, once each: then nothing is approximated.
    weights : (k, bands) ndarray
        Least squares of the relative error over all μ.

    Notes
    -----
    The nodes are Chebyshev's between the smallest and the largest index. Weights from
    least squares need one node fewer than the polynomial through them.
    """
    index = as_index(n).ravel()
    in_range(tolerance, 1e-13, 1.0, "tolerance")
    distinct, which = np.unique(index, return_inverse=True)
    low, high = distinct[0], distinct[-1]
    trial = np.linspace(low, high, min(distinct.size, _TRIALS))
    for k in range(1, min(distinct.size, _MOST_NODES + 1)):
        turns = np.cos(np.pi * (np.arange(k) + 0.5) / k)
        nodes = (low + high) / 2 + (high - low) / 2 * turns
        if _weights(nodes, trial)[1] <= _SHARE * tolerance:
            return nodes, _weights(nodes, distinct)[0][:, which]
    return distinct, np.eye(distinct.size)[:, which]


def _weights(nodes: Array, index: Array) -> tuple[Array, float]:
    """Return weights (k, bands) of Fresnel's law at nodes, and the relative error."""
    wanted = fresnel_reflectance(_COSINES[:, None], index)
    basis = fresnel_reflectance(_COSINES[:, None], nodes)
    scale = basis.mean(axis=1, keepdims=True)  # so that errors are relative
    weights = np.linalg.lstsq(basis / scale, wanted / scale)[0]
    error = np.abs(basis @ weights - wanted)
    beyond = np.divide(
        error, wanted, out=np.full(error.shape, np.inf), where=wanted > 0
    )
    return weights, float(beyond.max())
