"""Fitting a skin model to measured spectra, and how sure the result is."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_spectra, as_wavelengths
from skinviz.errors import ArgumentError, FitError
from skinviz.skin.model import SkinModel
from skinviz.skin.solver import Solution, solve
from skinviz.skin.uncertainty import covariance_and_interval
from skinviz.spectra.colorimetry import delta_e_2000, xyz_to_lab, xyz_weights
from skinviz.spectra.illuminants import illuminant_spd

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

STATUSES = ("converged", "at_bound", "not_converged", "refused")
"""What can be said of one spectrum's fit."""

CONVERGED, AT_BOUND, NOT_CONVERGED, REFUSED = STATUSES

WHY_REFUSED = "too few bands for the parameters, or a value below 0 or above 1.5"
"""What makes a spectrum one that cannot be fitted."""

_COVERED = (400.0, 700.0)  # nm that the data must span
_HIGHEST = 1.5  # above this it is no reflectance, however glossy
_NO_BLOOD = 1e-300  # keeps a quotient of zeros finite
_CHUNK = 4096  # spectra solved at once, which bounds the memory


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
    delta_e : (...) ndarray
        ΔE00 of measured and fitted under D65, 2° observer.
    fitted : (..., n) ndarray
        The model's version of what was measured. [1]
    reflectance : (..., n) ndarray
        R_b, the body under the surface. [1]
    diffuse : (..., n) ndarray
        What has left the skin from inside: the diffuse term of a picture. [1]
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
    delta_e: Array
    fitted: Array
    reflectance: Array
    diffuse: Array
    status: NDArray[np.str_]

    @property
    def rmse(self) -> Array:
        """Root mean square difference over the bands used. [1]"""
        return np.sqrt(self.sse / np.maximum(self.n_bands, 1))

    @property
    def sse_61(self) -> Array:
        """The sum of squares scaled to the paper's 61 bands."""
        return self.sse * 61 / np.maximum(self.n_bands, 1)

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

    def _of(self, table: Array, name: str) -> Array:
        """Return a parameter's part of a table with the parameters after the batch."""
        if name not in self.parameters:
            raise ArgumentError(f"the {self.model.name} model has no parameter {name}")
        index = self.parameters.index(name)
        return np.asarray(np.take(table, index, axis=self.values.ndim - 1))


def fit_skin(
    reflectance: ArrayLike,
    wavelengths: ArrayLike,
    model: SkinModel,
    *,
    uncertainty: ArrayLike | None = None,
) -> SkinFit:
    """Fit a skin model's parameters to measured spectra by least squares.

    Parameters
    ----------
    reflectance : (..., n) array_like
        One spectrum or a batch; a NaN band is left out of its spectrum. [1]
    wavelengths : (n,) array_like
        Ascending, spanning 400–700, within the model's tables. [nm]
    model : SkinModel
        From :func:`skin_model`, built for what was measured.
    uncertainty : (n,) or (..., n) array_like, optional
        Standard deviation of each band. The fit is then weighted and the
        covariance absolute; without it the residual scales the covariance. [1]

    Returns
    -------
    fit : SkinFit
        A status per spectrum; one that cannot be fitted (too few bands, a value
        below 0 or above 1.5) is "refused" with NaN values.

    Raises
    ------
    ArgumentError
        If shapes or wavelengths are wrong, or an uncertainty is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> from skinviz import skin_model
    >>> model = skin_model(site="cheek", specular="included")
    >>> wavelengths = np.arange(400, 701, 10)
    >>> spectrum = model.measured([0.1, 8e-3, 4e-3], wavelengths)
    >>> fit_skin(spectrum, wavelengths, model).values.round(6).tolist()
    [0.1, 0.008, 0.004]
    """
    bands = as_wavelengths(wavelengths)
    if bands[0] > _COVERED[0] or bands[-1] < _COVERED[1]:
        raise ArgumentError(
            f"a fit needs spectra that span {_COVERED[0]:g} to {_COVERED[1]:g} nm; "
            f"these cover {bands[0]:g} to {bands[-1]:g} nm"
        )
    data = as_spectra(reflectance, bands.size, "reflectance", nan_allowed=True)
    # The paper's range: beyond it the tables are weaker and the model unproven.
    inside = (bands >= _COVERED[0]) & (bands <= _COVERED[1])
    bands, data = bands[inside], data[..., inside]
    sigma = _sigma(uncertainty, inside, data.shape)
    flat = data.reshape(-1, bands.size)
    batch = data.shape[:-1]
    flat_sigma = None if sigma is None else sigma.reshape(flat.shape)
    parts = [
        _fit_chunk(
            flat[i : i + _CHUNK],
            bands,
            model,
            None if flat_sigma is None else flat_sigma[i : i + _CHUNK],
        )
        for i in range(0, max(len(flat), 1), _CHUNK)
    ]
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    shaped = {name: a.reshape(batch + a.shape[1:]) for name, a in joined.items()}
    names = tuple(parameter.name for parameter in model.parameters)
    return SkinFit(model=model, wavelengths=bands, parameters=names, **shaped)


def _sigma(
    uncertainty: ArrayLike | None, inside: NDArray[np.bool_], shape: tuple[int, ...]
) -> Array | None:
    """Return the standard deviations at the bands used, broadcast to the data."""
    if uncertainty is None:
        return None
    sigma = as_spectra(uncertainty, inside.size, "uncertainty")[..., inside]
    if not (sigma > 0).all():
        raise ArgumentError("uncertainty must be greater than 0 in every band")
    try:
        return np.broadcast_to(sigma, shape)
    except ValueError as error:
        raise ArgumentError(
            f"uncertainty {sigma.shape} does not broadcast to {shape}"
        ) from error


def _fit_chunk(
    data: Array, bands: Array, model: SkinModel, sigma: Array | None
) -> dict[str, NDArray[Any]]:
    """Fit a moderate number of spectra (m, n); return SkinFit's arrays."""
    used = np.isfinite(data)
    fit_for_it = used.sum(axis=1) > len(model.parameters)
    fit_for_it &= ~((data < 0) | (data > _HIGHEST)).any(axis=1)
    used &= fit_for_it[:, None]
    target = np.where(used, data, 0.0)
    weights = used.astype(np.float64) if sigma is None else used / sigma**2
    bounds = np.array([(p.lower, p.upper) for p in model.parameters]).T

    def predict(values: Array) -> tuple[Array, Array]:
        return model.measured_and_jacobian(values, bands)

    start = _best_start(predict(model.starts)[0], model.starts, target, weights)
    found = solve(predict, target, weights, start, bounds)
    covariance, interval = covariance_and_interval(
        found,
        target,
        weights,
        n_used=used.sum(axis=1),
        bounds=bounds,
        absolute=sigma is not None,
    )
    status = np.where(found.held.any(axis=1), AT_BOUND, CONVERGED)
    status = np.where(found.converged, status, NOT_CONVERGED)
    body = model.reflectance(found.values, bands)
    square = np.where(used, target - found.predicted, 0.0) ** 2
    known = {
        "values": found.values,
        "covariance": covariance,
        "interval": interval,
        "sse": square.sum(axis=1),
        "delta_e": _delta_e(np.where(used, target, found.predicted), found, bands),
        "fitted": found.predicted,
        "reflectance": body,
        "diffuse": model.interface.diffuse(body),
    }
    for values in known.values():
        values[~fit_for_it] = np.nan
    return {
        **known,
        "n_bands": used.sum(axis=1),
        "status": np.where(fit_for_it, status, REFUSED),
    }


def _best_start(curves: Array, starts: Array, target: Array, weights: Array) -> Array:
    """Return for each problem the start (m, p) whose curve already fits it best."""
    # Σ w (c − t)² without forming (m, k, n): the t² term is the same for all.
    cost = weights @ (curves**2).T - 2 * (weights * target) @ curves.T
    return np.asarray(starts[np.argmin(cost, axis=1)])


def _delta_e(measured: Array, found: Solution, bands: Array) -> Array:
    """Return ΔE00 (m,) of measured and fitted under D65, 2° observer."""
    weights = xyz_weights(bands, illuminant_spd("D65", bands))
    white = weights.sum(axis=0)
    return delta_e_2000(
        xyz_to_lab(measured @ weights, white),
        xyz_to_lab(found.predicted @ weights, white),
    )
