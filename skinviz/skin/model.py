"""What every skin model is: a few parameters, tissue around them, spectra from both."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, as_wavelengths, in_range
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import Coefficients
from skinviz.skin.interface import Interface, interface
from skinviz.skin.kubelka_munk import LARGEST, SMALLEST
from skinviz.spectra.measurement import as_specular

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


PIGMENTS = (
    Parameter("w_m", "1", 0.0, 1e12, "effective melanosome fraction of the epidermis"),
    Parameter("w_h", "1", 0.0, 1e12, "oxygenated whole-blood fraction of the dermis"),
    Parameter("w_dh", "1", 0.0, 1e12, "deoxygenated whole-blood fraction"),
)
"""The paper's three weights."""


@dataclass(frozen=True)
class SkinModel(ABC):
    """From a few parameters to spectra; parameters and wavelengths on last axes.

    A model is a subclass with a name and two methods, ``_body`` and
    ``_body_slopes``; it touches neither the fit nor the solver.

    Attributes
    ----------
    thickness : (float, float)
        Of epidermis and dermis. [mm], 0 to ``inf``
    coefficients : Coefficients
        K of the pigments, S of the tissues.
    specular : str or float
        How the surface reflection was measured; see ``skin_model``.
    hypodermis : float
        Reflectance of the backing, 1 in the paper. [1]
    """

    thickness: tuple[float, float]
    coefficients: Coefficients
    specular: str | float
    hypodermis: float = 1.0

    name: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]] = PIGMENTS

    def __post_init__(self) -> None:
        """Refuse a thickness or backing that no skin has."""
        for depth, tissue in zip(self.thickness, ("epidermis", "dermis"), strict=True):
            if depth not in (0, np.inf):
                in_range(depth, SMALLEST, LARGEST, f"thickness of the {tissue}", "mm")
        in_range(self.hypodermis, 0.0, 1.0, "hypodermis")
        object.__setattr__(self, "specular", as_specular(self.specular))

    @abstractmethod
    def _body(self, values: Array, at: Coefficients) -> Array:
        """Return R_b (..., n) of valid values (..., p)."""

    @abstractmethod
    def _body_slopes(self, values: Array, at: Coefficients) -> tuple[Array, Array]:
        """Return R_b (m, n) and its derivatives (m, n, p) of valid values (m, p)."""

    @cached_property
    def interface(self) -> Interface:
        """The surface that follows from ``specular``."""
        return interface(self.specular)

    @property
    def description(self) -> dict[str, Any]:
        """What it takes to make the model anew, as plain data."""
        return {
            "model": self.name,
            "specular": self.specular,
            "coefficients": self.coefficients.name,
            # JSON has no infinity; skin_model takes the word.
            "thickness_mm": [d if np.isfinite(d) else "inf" for d in self.thickness],
            "hypodermis": self.hypodermis,
        }

    @cached_property
    def starts(self) -> Array:
        """Parameter sets (k, p) that span human skin, for a fit to start from."""
        melanin, blood, oxygen = (0.02, 0.1, 0.3, 0.8), (2e-3, 0.01, 0.04), (0.3, 0.8)
        return np.array(
            [(m, b * s, b * (1 - s)) for m, b, s in product(melanin, blood, oxygen)]
        )

    def reflectance(self, values: ArrayLike, wavelengths: ArrayLike) -> Array:
        """Return R_b, the reflectance of the body under the surface.

        Parameters
        ----------
        values : (..., p) array_like
            The parameters, in the order of ``parameters``.
        wavelengths : (n,) array_like
            Within the coefficients' table. [nm]

        Returns
        -------
        reflectance : (..., n) ndarray of float64
            [1]

        Raises
        ------
        ArgumentError
            If a parameter is outside its bounds or not finite, or a wavelength
            lies outside the table.
        """
        bands = as_wavelengths(wavelengths)
        return self._body(self.checked(values), self.coefficients.at(bands))

    def diffuse(self, values: ArrayLike, wavelengths: ArrayLike) -> Array:
        """Return the light that has been inside the skin and left it.

        This is what a picture shows as the diffuse term. It equals R_b unless
        ``specular`` is "included", where the surface turns part of it back.

        Parameters and errors as :meth:`reflectance`; returns (..., n). [1]
        """
        return self.interface.diffuse(self.reflectance(values, wavelengths))

    def measured(self, values: ArrayLike, wavelengths: ArrayLike) -> Array:
        """Return what the instrument reads, surface reflection as measured.

        Parameters and errors as :meth:`reflectance`; returns (..., n). [1]
        """
        return self.interface.measured(self.reflectance(values, wavelengths))

    def measured_and_jacobian(
        self, values: Array, wavelengths: Array
    ) -> tuple[Array, Array]:
        """Return ``measured`` (m, n) and its derivatives (m, n, p), unchecked."""
        body, slopes = self._body_slopes(values, self.coefficients.at(wavelengths))
        return (
            self.interface.measured(body),
            self.interface.slope(body)[..., None] * slopes,
        )

    def checked(self, values: ArrayLike) -> Array:
        """Return parameters (..., p) as float64 after checking their bounds.

        Raises
        ------
        ArgumentError
            If one is no number, not finite or outside its bounds.
        """
        given = as_numbers(values, "weights")
        if given.ndim == 0 or given.shape[-1] != len(self.parameters):
            raise ArgumentError(
                f"the {self.name} model takes {len(self.parameters)} weights on the "
                f"last axis; got shape {given.shape}"
            )
        for k, parameter in enumerate(self.parameters):
            own = given[..., k]
            if not ((own >= parameter.lower) & (own <= parameter.upper)).all():
                raise ArgumentError(
                    f"weights out of bounds: {parameter.name} must be between "
                    f"{parameter.lower:g} and {parameter.upper:g}; got "
                    f"{own.min():g} to {own.max():g}"
                )
        return given
