"""What every skin model is: a few parameters, tissue around them, spectra from both."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._threads import in_slices
from skinviz._validate import as_numbers, as_wavelengths, in_range
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import Coefficients
from skinviz.skin.interface import BARE, Interface, interface
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
    expected, spread : float
        Mean and standard deviation of a normal prior; a spread of ``inf`` is none.
    """

    name: str
    unit: str
    lower: float
    upper: float
    meaning: str
    expected: float = 0.0
    spread: float = np.inf


PIGMENTS = (
    Parameter("w_m", "1", 0.0, 1e12, "effective melanosome fraction of the epidermis"),
    Parameter("w_h", "1", 0.0, 1e12, "oxygenated whole-blood fraction of the dermis"),
    Parameter("w_dh", "1", 0.0, 1e12, "deoxygenated whole-blood fraction"),
)
"""The paper's three weights."""


VECTOR = 4
"""Numbers that a processor computes at once."""

_USUAL_EPIDERMIS = 0.035  # mm
_USUAL_WEIGHTS = (
    (0.01, 0.02, 0.04, 0.06, 0.08, 0.11, 0.15, 0.2, 0.28, 0.4, 0.8),  # w_m
    (1e-3, 3e-3, 5e-3, 8e-3, 0.014, 0.025, 0.05),  # w_h + w_dh
    (0.0, 0.35, 0.65, 1.0),  # the share of w_h
)
_CHUNK = 4096  # spectra that a thread computes in one go


@dataclass(frozen=True)
class SkinModel:
    """From a few parameters to spectra; parameters and wavelengths on last axes.

    A model is a subclass with a name and one compiled function, ``evaluate``; it
    touches neither the fit nor the solver. ``evaluate(values, table, constants,
    scratch, measured, jacobian)`` fills in what is measured (n,) and, unless
    ``jacobian`` has no rows, its derivatives (p, n), for ``_table`` at n bands and
    the numbers of ``_constants``.

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

    prior_unit: ClassVar[float] = 1e-4
    """σ² of a band against which priors weigh where no uncertainty is given. [1]"""

    name: ClassVar[str]
    evaluate: ClassVar[Any]

    def __post_init__(self) -> None:
        """Refuse a thickness or backing that no skin has."""
        for depth, tissue in zip(self.thickness, ("epidermis", "dermis"), strict=True):
            if depth not in (0, np.inf):
                in_range(depth, SMALLEST, LARGEST, f"thickness of the {tissue}", "mm")
        in_range(self.hypodermis, 0.0, 1.0, "hypodermis")
        object.__setattr__(self, "specular", as_specular(self.specular))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What a fit seeks, in the order of the values."""
        return PIGMENTS

    def _table(self, at: Coefficients) -> Array:
        """Return what ``evaluate`` needs at each band (k, n)."""
        return np.stack(
            [
                at.melanin,
                at.oxyhaemoglobin,
                at.deoxyhaemoglobin,
                at.epidermis,
                at.dermis,
            ]
        )

    def _constants(self, surface: Interface | None) -> tuple[float, ...]:
        """Return what ``evaluate`` needs once; with no surface it gives R_b."""
        surface = surface or BARE
        return (
            *(*self.thickness, self.hypodermis),
            *(surface.offset, surface.transmission, surface.internal),
        )

    @property
    def limits(self) -> tuple[float, float]:
        """Between which wavelengths the coefficients are known. [nm]"""
        known = self.coefficients.wavelengths
        return float(known[0]), float(known[-1])

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
        # Only w_m times the thickness shows, as long as light crosses it.
        crossed = min(max(self.thickness[0], _USUAL_EPIDERMIS / 10), 1.0)
        thin = _USUAL_EPIDERMIS / crossed
        return np.array(
            [(m * thin, b * s, b * (1 - s)) for m, b, s in product(*_USUAL_WEIGHTS)]
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
        return self._spectra(self.checked(values), wavelengths, None)

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
        return self._spectra(self.checked(values), wavelengths, self.interface)

    def arrays(
        self, wavelengths: ArrayLike, surface: Interface | None
    ) -> tuple[Array, Array]:
        """Return table and constants for ``evaluate``, padded to whole vectors.

        The added bands repeat the last; loops over a multiple of ``VECTOR`` bands
        have no slow rest.
        """
        bands = as_wavelengths(wavelengths)
        table = self._table(self.coefficients.at(bands))
        padded = np.pad(table, ((0, 0), (0, -bands.size % VECTOR)), mode="edge")
        return padded, np.array(self._constants(surface), dtype=np.float64)

    def curves_and_slopes(
        self, values: Array, table: Array, constants: Array
    ) -> tuple[Array, Array]:
        """Return what is measured (m, N) and its derivatives (m, p, N), unchecked."""
        from skinviz.skin.kernels import SCRATCH

        n = table.shape[1]
        scratch = np.zeros((SCRATCH, n))
        curves, slopes = np.zeros((len(values), n)), np.zeros((*values.shape, n))
        for own, curve, slope in zip(values, curves, slopes, strict=True):
            self.evaluate(own, table, constants, scratch, curve, slope)
        return curves, slopes

    def _spectra(
        self, values: Array, wavelengths: ArrayLike, surface: Interface | None
    ) -> Array:
        """Return spectra (..., n) of valid values (..., p) seen through a surface."""
        from skinviz.skin.kernels import spectra

        table, constants = self.arrays(wavelengths, surface)
        # A copy, because compiled code takes no array that may only be read.
        flat = np.array(values.reshape(-1, values.shape[-1]), order="C")
        n = np.size(wavelengths)
        measured = np.zeros((len(flat), n))

        def fill(rows: slice) -> None:
            spectra(self.evaluate, flat[rows], table, constants, measured[rows])

        in_slices(fill, len(flat), _CHUNK)
        return measured.reshape(*values.shape[:-1], n)

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
