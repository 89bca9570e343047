"""The paper's model: two Kubelka–Munk layers over the hypodermis, three pigments."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_wavelengths, in_range
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import Coefficients
from skinviz.skin.interface import Interface, interface
from skinviz.skin.kubelka_munk import (
    LARGEST,
    SMALLEST,
    layer_fluxes,
    stack_reflectance,
    stack_slopes,
)
from skinviz.skin.model import Parameter

Array = NDArray[np.float64]

PIGMENTS = (
    Parameter("w_m", "1", 0.0, 1e12, "effective melanosome fraction of the epidermis"),
    Parameter("w_h", "1", 0.0, 1e12, "oxygenated whole-blood fraction of the dermis"),
    Parameter("w_dh", "1", 0.0, 1e12, "deoxygenated whole-blood fraction"),
)


@dataclass(frozen=True)
class TwoLayer:
    """Epidermis with melanin over dermis with blood over a white hypodermis.

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

    References
    ----------
    .. [1] Doi, Tanaka & Tominaga, J. Imaging Sci. Technol. 49:574 (2005),
       eqs (5)–(9).
    """

    thickness: tuple[float, float]
    coefficients: Coefficients
    specular: str | float
    hypodermis: float = 1.0

    name = "two-layer"
    parameters = PIGMENTS

    def __post_init__(self) -> None:
        """Refuse a thickness or backing that no skin has."""
        for depth, tissue in zip(self.thickness, ("epidermis", "dermis"), strict=True):
            if depth not in (0, np.inf):
                in_range(depth, SMALLEST, LARGEST, f"thickness of the {tissue}", "mm")
        in_range(self.hypodermis, 0.0, 1.0, "hypodermis")
        interface(self.specular)

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
            "thickness_mm": list(self.thickness),
        }

    @cached_property
    def starts(self) -> Array:
        """Parameter sets (k, 3) that span human skin, for a fit to start from."""
        melanin, blood, saturation = (
            (0.02, 0.1, 0.3, 0.8),
            (2e-3, 0.01, 0.04),
            (0.3, 0.8),
        )
        return np.array(
            [(m, b * s, b * (1 - s)) for m, b, s in product(melanin, blood, saturation)]
        )

    def reflectance(self, values: ArrayLike, wavelengths: ArrayLike) -> Array:
        """Return R_b, the reflectance of the body under the surface.

        Parameters
        ----------
        values : (..., 3) array_like
            The weights w_m, w_h, w_dh. [1], ≥ 0
        wavelengths : (n,) array_like
            Within the coefficients' table. [nm]

        Returns
        -------
        reflectance : (..., n) ndarray of float64
            Eq. (5). [1]

        Raises
        ------
        ArgumentError
            If a weight is negative, not finite or above 1e12, or a wavelength
            lies outside the table.
        """
        K, S = self._layers(self._checked(values), as_wavelengths(wavelengths))
        top, bottom = (
            layer_fluxes(k, s, np.asarray(depth, dtype=np.float64))
            for k, s, depth in zip(K, S, self.thickness, strict=True)
        )
        return stack_reflectance(top, bottom, self.hypodermis)

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
        """Return ``measured`` (m, n) and its derivatives (m, n, 3), unchecked."""
        at = self.coefficients.at(wavelengths)
        K, S = self._layers(values, wavelengths)
        body, by_top, by_bottom = stack_slopes(K, S, self.thickness, self.hypodermis)
        slope = self.interface.slope(body)
        jacobian = np.stack(
            [
                slope * by_top * at.melanin,
                slope * by_bottom * at.oxyhaemoglobin,
                slope * by_bottom * at.deoxyhaemoglobin,
            ],
            axis=-1,
        )
        return self.interface.measured(body), jacobian

    def _layers(
        self, values: Array, wavelengths: Array
    ) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Return (K_et, K_dt) and (S_e, S_d) of eq. (9)."""
        at = self.coefficients.at(wavelengths)
        w_m, w_h, w_dh = (values[..., i, None] for i in range(3))
        epidermis = w_m * at.melanin
        dermis = w_h * at.oxyhaemoglobin + w_dh * at.deoxyhaemoglobin
        return (epidermis, dermis), (at.epidermis, at.dermis)

    def _checked(self, values: ArrayLike) -> Array:
        """Return weights as float64 after checking their bounds."""
        weights = np.asarray(values, dtype=np.float64)
        if weights.ndim == 0 or weights.shape[-1] != len(self.parameters):
            raise ArgumentError(
                f"the {self.name} model takes {len(self.parameters)} weights on the "
                f"last axis; got shape {weights.shape}"
            )
        upper = self.parameters[0].upper
        if not ((weights >= 0) & (weights <= upper)).all():
            raise ArgumentError(
                f"weights must be between 0 and {upper:g}; got {weights.min():g} to "
                f"{weights.max():g}"
            )
        return weights
