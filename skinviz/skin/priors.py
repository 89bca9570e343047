"""What the literature says of the five numbers of the ``effective`` table.

The figures and their sources are in ``data/effective.toml``; this is how a fit sees
them, and the bounds within which it looks.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.formulas import EffectiveNumbers, effective_data

Array = NDArray[np.float64]

NAMES = tuple(field.name for field in fields(EffectiveNumbers))
"""Names of the five numbers, in their order."""

_BOUNDS = {
    "melanin_slope": (0.0, 10.0),
    "epidermis_scattering": (0.01, 100.0),
    "dermis_scattering": (0.01, 100.0),
    "rayleigh_share": (0.0, 1.0),
    "mie_slope": (0.0, 6.0),
}


@dataclass(frozen=True, eq=False)
class Priors:
    """What the literature says of the numbers, as normal densities.

    Attributes
    ----------
    mean, deviation : (5,) ndarray
        In the number itself or, where ``log``, in its natural logarithm.
    log : (5,) ndarray of bool
        Which numbers are described by their logarithm.
    """

    mean: Array
    deviation: Array
    log: NDArray[np.bool_]

    def coordinates(self, numbers: EffectiveNumbers) -> Array:
        """Return the numbers (5,) as the priors see them, some by their logarithm."""
        plain = np.array(astuple(numbers))
        return np.where(self.log, np.log(np.where(self.log, plain, 1.0)), plain)

    def numbers(self, coordinates: Array) -> EffectiveNumbers:
        """Return the numbers from their coordinates (5,)."""
        grown = np.exp(np.where(self.log, coordinates, 0.0))
        return EffectiveNumbers(
            *(float(v) for v in np.where(self.log, grown, coordinates))
        )


def literature() -> Priors:
    """Return the priors of ``effective.toml``, where their sources stand."""
    data = effective_data()
    given = [data[name]["prior"] for name in NAMES]
    log = np.array([prior["scale"] == "log" for prior in given])
    mean = np.array([float(prior["mean"]) for prior in given])
    deviation = np.array([float(prior["deviation"]) for prior in given])
    return Priors(np.where(log, np.log(mean), mean), deviation, log)


def coordinate_bounds(priors: Priors) -> tuple[Array, Array]:
    """Return the lowest and highest coordinates (5,) that a search may reach."""
    lowest, highest = zip(*(_BOUNDS[name] for name in NAMES), strict=True)
    return (
        priors.coordinates(EffectiveNumbers(*lowest)),
        priors.coordinates(EffectiveNumbers(*highest)),
    )
