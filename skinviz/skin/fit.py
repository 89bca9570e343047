"""Fitting a skin model to measured spectra: from arrays to the solver and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._threads import in_slices
from skinviz._validate import as_measured, as_spectra, as_wavelengths
from skinviz.errors import ArgumentError
from skinviz.skin.model import SkinModel
from skinviz.skin.skin_fit import REFUSED, STATUSES, SkinFit
from skinviz.skin.uncertainty import covariance_and_interval
from skinviz.spectra.colorimetry import xyz_weights
from skinviz.spectra.illuminants import illuminant_spd

if TYPE_CHECKING:
    from skinviz.skin.problem import Problem, Solutions

Array = NDArray[np.float64]

_STATUSES = np.array(STATUSES)
_COVERED = (400.0, 700.0)  # nm that the data must span
_SAMPLED = 8  # bands that tell one start from another
_SIGMAS = (1e-75, 1e75)  # whose squares, and the quotients of these, are normal floats
_CHUNK = 2048  # spectra that a thread solves in one go, which bounds the memory


def fit_skin(
    reflectance: ArrayLike,
    wavelengths: ArrayLike,
    model: SkinModel,
    *,
    uncertainty: ArrayLike | None = None,
    advance: Callable[[int], object] | None = None,
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

    advance : callable, optional
        Told the number of spectra of each part that is done, for a progress bar.

    Returns
    -------
    fit : SkinFit
        A status per spectrum; one that cannot be fitted (too few bands, a value
        below 0 or above 1.5) is "refused" with NaN values.

    Raises
    ------
    ArgumentError
        If shapes or wavelengths are wrong, or an uncertainty is not positive or not
        within 1e-75 to 1e75.

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
    data = as_measured(reflectance, bands.size, "reflectance")
    # The paper's range: beyond it the tables are weaker and the model unproven.
    inside = slice(
        int(np.searchsorted(bands, _COVERED[0])),
        int(np.searchsorted(bands, _COVERED[1], side="right")),
    )
    sigma = _sigma(uncertainty, data.shape)[..., inside]
    bands, data = bands[inside], data[..., inside]
    flat, batch = data.reshape(-1, bands.size), data.shape[:-1]
    problem = _problem(model, bands)
    results = _room(len(flat), len(model.parameters))

    def work(rows: slice) -> None:
        from skinviz.skin import problem as memory
        from skinviz.skin.solver import solve

        part = np.array(flat[rows], dtype=np.float64, order="C")
        own = np.array(sigma[rows] if len(sigma) > 1 else sigma, order="C")
        found = memory.room(len(part), len(problem.low))
        solve(model.evaluate, problem, part, own, model.prior_unit, found)
        for name, values in _conclusions(problem, found, absolute=len(own) > 0).items():
            results[name][rows] = values

    in_slices(work, len(flat), _CHUNK, advance)
    shaped = {name: a.reshape(batch + a.shape[1:]) for name, a in results.items()}
    names = tuple(parameter.name for parameter in model.parameters)
    return SkinFit(model=model, wavelengths=bands, parameters=names, **shaped)


def _sigma(uncertainty: ArrayLike | None, shape: tuple[int, ...]) -> Array:
    """Return the standard deviations of each row, of all rows, or none (0, n)."""
    if uncertainty is None:
        return np.zeros((0, shape[-1]))
    sigma = as_spectra(uncertainty, shape[-1], "uncertainty")
    low, high = _SIGMAS
    if not ((sigma >= low) & (sigma <= high)).all():
        raise ArgumentError(
            f"uncertainty must be greater than 0 in every band, from {low:g} to "
            f"{high:g}; got {sigma.min():g} to {sigma.max():g}"
        )
    if sigma.ndim == 1:
        return sigma[None]
    try:
        return np.broadcast_to(sigma, shape).reshape(-1, shape[-1])
    except ValueError as error:
        raise ArgumentError(
            f"uncertainty {sigma.shape} does not broadcast to {shape}"
        ) from error


def _problem(model: SkinModel, bands: Array) -> Problem:
    """Return what all spectra share, padded to whole vectors."""
    from skinviz.skin.problem import Problem

    table, constants = model.arrays(bands, model.interface)
    starts, n = model.starts, table.shape[1]
    curves, slopes = model.curves_and_slopes(starts, table, constants)
    sampled = np.arange(0, bands.size, max(1, bands.size // _SAMPLED))
    observer = np.zeros((3, n))
    observer[:, : bands.size] = xyz_weights(bands, illuminant_spd("D65", bands)).T
    parameters = model.parameters
    return Problem(
        table,
        constants,
        low=np.array([p.lower for p in parameters]),
        high=np.array([p.upper for p in parameters]),
        centre=np.array([p.expected for p in parameters]),
        stiffness=np.array([p.spread**-2.0 for p in parameters]),
        starts=starts,
        curves=curves,
        slopes=slopes,
        sampled=sampled,
        sketch=np.array(curves[:, sampled].T, dtype=np.float32, order="C"),
        observer=observer,
    )


def _room(m: int, p: int) -> dict[str, NDArray[Any]]:
    """Return SkinFit's arrays for m spectra and p parameters."""
    return {
        "values": np.zeros((m, p)),
        "covariance": np.zeros((m, p, p)),
        "interval": np.zeros((m, p, 2)),
        "sse": np.zeros(m),
        "n_bands": np.zeros(m, dtype=np.int64),
        "xyz": np.zeros((m, 2, 3)),
        "chi_square": np.zeros(m),
        "status": np.zeros(m, dtype=_STATUSES.dtype),
    }


def _conclusions(
    problem: Problem, found: Solutions, *, absolute: bool
) -> dict[str, NDArray[Any]]:
    """Return SkinFit's arrays of spectra that were solved."""
    covariance, interval = covariance_and_interval(
        found,
        problem.stiffness,
        np.stack([problem.low, problem.high]),
        absolute=absolute,
    )
    status = _STATUSES[found.status]
    refused = status == REFUSED
    known: dict[str, NDArray[Any]] = {
        "values": found.values,
        "covariance": covariance,
        "interval": interval,
        "sse": found.sse,
        "xyz": found.colours,
        "chi_square": found.cost / found.unit,  # NaN where σ is not known
    }
    for values in known.values():
        values[refused] = np.nan
    return {**known, "n_bands": np.where(refused, 0, found.n_used), "status": status}
