"""The result of a fit: estimates, how sure they are, and what follows from them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError, FitError
from skinviz.skin.model import SkinModel
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

STATUSES = ("converged", "at_bound", "not_converged", "refused")
"""What can be said of one spectrum's fit."""

CONVERGED, AT_BOUND, NOT_CONVERGED, REFUSED = STATUSES

WHY_REFUSED = "too few bands for the parameters, or a value below 0 or above 1.5"
"""What makes a spectrum one that cannot be fitted."""

ALIKE = 0.9
"""Correlation from which two parameters are said not to be told apart."""

_NO_BLOOD = 1e-300  # keeps a quotient of zeros finite


@dataclass(frozen=True, eq=False)
class SkinFit:
    """A model fitted to one spectrum or a batch of them.

    Attributes
    ----------
    model : SkinModel
        What was fitted.
    wavelengths : (n,) ndarray
        Bands of the data. [nm]
    parameters : tuple of str
        Names of the parameters, in the order of ``values``.
    values : (..., p) ndarray
        The estimates; NaN where refused.
    covariance : (..., p, p) ndarray
        Of the estimates; rows and columns of a parameter at its bound are 0.
    interval : (..., p, 2) ndarray
        95 % interval; one-sided for a parameter at its bound.
    sse : (...) ndarray
        Sum of squared differences over the bands used.
    n_bands : (...) ndarray of int
        How many bands were used.
    xyz : (..., 2, 3) ndarray
        XYZ under D65, 2° observer, of what was measured and of the fit, which also
        stands in where a band was not measured. White has Y = 1.
    chi_square : (...) ndarray
        Sum of squared differences over their σ²; NaN where σ was not given.
    status : (...) ndarray of str
        "converged", "at_bound" (converged, a parameter at its bound),
        "not_converged" or "refused".
    """

    model: SkinModel
    wavelengths: Array
    parameters: tuple[str, ...]
    values: Array
    covariance: Array
    interval: Array
    sse: Array
    n_bands: NDArray[np.int64]
    xyz: Array
    chi_square: Array
    status: NDArray[np.str_]

    @cached_property
    def fitted(self) -> Array:
        """The model's version of what was measured (..., n); NaN where refused. [1]"""
        return self._curves(self.model.measured)

    @cached_property
    def reflectance(self) -> Array:
        """R_b, the body under the surface (..., n); NaN where refused. [1]"""
        return self._curves(self.model.reflectance)

    @cached_property
    def diffuse(self) -> Array:
        """What has left the skin from inside (..., n): a picture's diffuse term. [1]"""
        return self._curves(self.model.diffuse)

    @cached_property
    def delta_e(self) -> Array:
        """ΔE00 of measured and fitted under D65, 2° observer."""
        white = spectrum_to_xyz(np.ones(self.wavelengths.size), self.wavelengths)
        lab = xyz_to_lab(self.xyz, white)
        return delta_e_2000(lab[..., 0, :], lab[..., 1, :])

    @property
    def rmse(self) -> Array:
        """Root mean square difference over the bands used. [1]"""
        return np.sqrt(self.sse / np.maximum(self.n_bands, 1))

    @property
    def sse_61(self) -> Array:
        """The sum of squares scaled to the paper's 61 bands."""
        return self.sse * 61 / np.maximum(self.n_bands, 1)

    @property
    def bic(self) -> Array:
        """Bayesian information criterion; of rival models the least is the best.

        From the χ² where σ was given, else from the residuals' own variance. It counts
        a parameter with a prior in full. [1]
        """
        n = np.maximum(self.n_bands, 1)
        with np.errstate(divide="ignore"):  # an exact fit is infinitely good
            spread = n * np.log(self.sse / n)
        misfit = np.where(np.isnan(self.chi_square), spread, self.chi_square)
        return np.asarray(misfit + len(self.parameters) * np.log(n))

    @property
    def correlation(self) -> Array:
        """Correlation of the estimates (..., p, p); 0 beside one at its bound. [1]"""
        deviation = np.sqrt(np.einsum("...pp->...p", self.covariance))
        known = np.isfinite(deviation) & (deviation > 0)
        scale = np.where(known, deviation, 1.0)
        own = np.where(np.isfinite(self.covariance), self.covariance, 0.0)
        return np.asarray(own / (scale[..., :, None] * scale[..., None, :]))

    def indistinct(
        self, limit: float = ALIKE
    ) -> dict[tuple[str, ...], NDArray[np.bool_]]:
        """Return what the data cannot tell apart, and in which spectra.

        Parameters
        ----------
        limit : float
            Correlation beyond which, in size, two parameters stand for one. [1]

        Returns
        -------
        indistinct : dict of tuple of str to ndarray of bool
            Pairs of parameters, and single ones that do not show at all, with the
            spectra (...) where it is so; without those that never occur.
        """
        said: dict[tuple[str, ...], NDArray[np.bool_]] = {}
        names, correlation = self.parameters, self.correlation
        variance = np.einsum("...pp->...p", self.covariance)
        for i, name in enumerate(names):
            said[(name,)] = np.isinf(variance[..., i])
            for j in range(i):
                said[(names[j], name)] = np.abs(correlation[..., j, i]) > limit
        return {key: where for key, where in said.items() if where.any()}

    @property
    def blood_fraction(self) -> Array:
        """w_h + w_dh, the effective blood fraction of the dermis. [1]"""
        return self._of(self.values, "w_h") + self._of(self.values, "w_dh")

    @property
    def oxygen_saturation(self) -> Array:
        """w_h/(w_h + w_dh); NaN where no blood was found. [1]"""
        blood = self.blood_fraction
        share = self._of(self.values, "w_h") / np.where(blood == 0, 1.0, blood)
        return np.where(blood == 0, np.nan, share)

    @property
    def oxygen_saturation_interval(self) -> Array:
        """Bounds (..., 2) of the oxygen saturation; 0 to 1 where no blood was found.

        From the ends of the intervals of w_h and w_dh: the data trade the one for
        the other, so they err in opposite directions. [1]
        """
        oxy, deoxy = (self._of(self.interval, name) for name in ("w_h", "w_dh"))
        low = oxy[..., 0] / np.maximum(oxy[..., 0] + deoxy[..., 1], _NO_BLOOD)
        high = oxy[..., 1] / np.maximum(oxy[..., 1] + deoxy[..., 0], _NO_BLOOD)
        empty = self.blood_fraction == 0
        return np.stack([np.where(empty, 0, low), np.where(empty, 1, high)], axis=-1)

    def __getitem__(self, index: Any) -> SkinFit:
        """Return the fit of some spectra of the batch, indexed as an array is."""
        arrays: dict[str, Any] = {
            field.name: np.asarray(getattr(self, field.name)[index])
            for field in dataclasses.fields(self)
            if field.name not in ("model", "wavelengths", "parameters")
        }
        return dataclasses.replace(self, **arrays)

    def raise_for_status(self) -> None:
        """Raise if any spectrum's fit did not converge or was refused.

        Raises
        ------
        FitError
            Says how many, and which came first.
        """
        failed = np.isin(self.status, (NOT_CONVERGED, REFUSED))
        if failed.any():
            first = tuple(int(i) for i in np.argwhere(failed)[0])
            raise FitError(
                f"{int(failed.sum())} of {self.status.size} spectra were not fitted; "
                f"the first, at index {first}, is {str(self.status[first])!r} "
                f"({REFUSED}: {WHY_REFUSED})"
            )

    def to_xarray(self) -> xarray.Dataset:
        """Return the fit as a labelled table, dims record, parameter, wavelength."""
        import xarray

        n, p = self.fitted.shape[-1], len(self.parameters)
        flat = ("record", "parameter")
        bands = ("record", "wavelength")
        return xarray.Dataset(
            {
                "value": (flat, self.values.reshape(-1, p)),
                "interval": ((*flat, "side"), self.interval.reshape(-1, p, 2)),
                "covariance": (
                    ("record", "parameter", "other_parameter"),
                    self.covariance.reshape(-1, p, p),
                ),
                "sse": ("record", self.sse.ravel()),
                "rmse": ("record", self.rmse.ravel()),
                "n_bands": ("record", self.n_bands.ravel()),
                "delta_e": ("record", self.delta_e.ravel()),
                "chi_square": ("record", self.chi_square.ravel()),
                "status": ("record", self.status.ravel()),
                "fitted": (bands, self.fitted.reshape(-1, n)),
                "reflectance": (bands, self.reflectance.reshape(-1, n)),
                "diffuse": (bands, self.diffuse.reshape(-1, n)),
            },
            coords={
                "parameter": list(self.parameters),
                "other_parameter": list(self.parameters),
                "side": ["lower", "upper"],
                "wavelength": self.wavelengths,
            },
            attrs={"model": self.model.name, "specular": str(self.model.specular)},
        )

    def _curves(self, spectra: Callable[[Array, Array], Array]) -> Array:
        """Return a model's spectra (..., n) of the values, NaN where refused."""
        some = self.status != REFUSED
        curves = np.full((*self.status.shape, self.wavelengths.size), np.nan)
        curves[some] = spectra(self.values[some], self.wavelengths)
        return curves

    def _of(self, table: Array, name: str) -> Array:
        """Return a parameter's part of a table with the parameters after the batch."""
        if name not in self.parameters:
            raise ArgumentError(f"the {self.model.name} model has no parameter {name}")
        index = self.parameters.index(name)
        return np.asarray(np.take(table, index, axis=self.values.ndim - 1))
