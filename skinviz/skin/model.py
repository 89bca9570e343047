"""What every skin model offers, and the parameters that it has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz.skin.interface import Interface

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """One number that a model has and a fit seeks.

    Attributes
    ----------
    name : str
        Its name, the label used everywhere.
    unit : str
        Its unit, "1" for a pure number.
    lower, upper : float
        Bounds within which it has a meaning.
    meaning : str
        One line for people.
    """

    name: str
    unit: str
    lower: float
    upper: float
    meaning: str


class SkinModel(Protocol):
    """From a few parameters to spectra; parameters and wavelengths on last axes."""

    @property
    def name(self) -> str:
        """The name that ``skin_model`` knows it by."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters, in the order of the last axis of ``values``."""

    @property
    def specular(self) -> str | float:
        """How the surface reflection was measured."""

    @property
    def interface(self) -> Interface:
        """The surface that follows from ``specular``."""

    @property
    def description(self) -> dict[str, Any]:
        """What it takes to make the model anew, as plain data."""

    @property
    def starts(self) -> Array:
        """Parameter sets (k, p) that a fit may start from."""

    def reflectance(self, values: ArrayLike, wavelengths: ArrayLike) -> Array:
        """Return R_b, the reflectance of the body under the surface. [1]"""

    def diffuse(self, values: ArrayLike, wavelengths: ArrayLike) -> Array:
        """Return the part of ``measured`` that has been inside the skin. [1]"""

    def measured(self, values: ArrayLike, wavelengths: ArrayLike) -> Array:
        """Return what the instrument reads. [1]"""

    def measured_and_jacobian(
        self, values: Array, wavelengths: Array
    ) -> tuple[Array, Array]:
        """Return ``measured`` (m, n) and its derivatives (m, n, p), unchecked."""
