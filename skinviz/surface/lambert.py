"""A surface without any specular reflection, for comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from skinviz.surface.surface import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lambert(Surface):
    """Nothing but the diffuse term of eq. (10): no specular reflection."""

    name: ClassVar[str] = "lambert"

    @property
    def n(self) -> float:
        """1: nothing is reflected. [1]"""
        return 1.0

    @property
    def physical_beta(self) -> float:
        """0: there is no specular term. [1]"""
        return 0.0

    @property
    def beta(self) -> float:
        """0: there is no specular term. [1]"""
        return 0.0

    @property
    def description(self) -> str:
        """The model in a line of words."""
        return "Lambert, no specular reflection"

    @property
    def lobe(self) -> Any:
        """The compiled lobe; see ``surface.kernels.LOBE``."""
        from skinviz.surface import kernels

        return kernels.lambert

    @property
    def constants(self) -> Array:
        """What the lobe is given: nothing."""
        return np.zeros(1)

    def factors(self, cosines: Array) -> tuple[Array, Array]:
        """Return zeros."""
        return np.zeros(cosines.shape[1:]), np.zeros(cosines.shape[1:])

    def reach(self, incidence: float) -> float:
        """Return how far facets are tilted: all lie flat, but no rule is of width 0."""
        del incidence
        return float(np.pi / 2)
