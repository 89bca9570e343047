"""Refitting the five numbers of the ``effective`` table to measured people.

Variable projection: for given numbers every spectrum's weights are fitted anew, so
that only the five numbers are sought. Priors from the literature hold what spectra
alone do not determine. What does not belong here: the formulas (``formulas``) and
the fit of one spectrum (``fit``).
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, as_wavelengths
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import Coefficients
from skinviz.skin.fit import fit_skin
from skinviz.skin.formulas import (
    EffectiveNumbers,
    effective_coefficients,
    effective_numbers,
)
from skinviz.skin.priors import NAMES, coordinate_bounds, literature
from skinviz.skin.skin_fit import REFUSED
from skinviz.skin.two_layer import TwoLayer

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

Array = NDArray[np.float64]

RESIDUAL_SCALE = 0.13
"""Standard deviation that a band's misfit counts with, against the priors. [1]

The misfit of 50 people is 0.009 in root mean square. It is no noise: neighbouring
bands and different people share it, so that 61 bands of 50 people say as much as a
few independent values. ``implied_scale`` works that out; it and this agree.
"""

_STEP = 1e-3  # of a prior's deviation, for derivatives: far above the fit's tolerance
_NEAR = 1e-3  # of a prior's deviation from a bound counts as at it


@dataclass(frozen=True, eq=False)
class Tuning:
    """Numbers fitted to people, and how far the people determine them.

    Attributes
    ----------
    numbers : EffectiveNumbers
        The estimates.
    covariance : (5, 5) ndarray
        Of the coordinates (see ``Priors``), from the residual scale and the priors.
    sampling : (5, 5) ndarray
        Covariance of the coordinates between samples of as many people.
    pull : (5,) ndarray
        How far each lies from its prior's mean, in the prior's deviations.
    learned : (5,) ndarray
        Share of the prior's variance that the people removed: 0 means that the
        number is the prior's; NaN without priors. [1]
    at_bound : (5,) ndarray of bool
        Numbers that ran into the bounds of the search: not determined.
    sse : (m,) ndarray
        Each spectrum's sum of squares.
    implied_scale : float
        The residual scale that the residuals themselves ask for. [1]
    converged : bool
        Whether the search came to rest.
    """

    numbers: EffectiveNumbers
    covariance: Array
    sampling: Array
    pull: Array
    learned: Array
    at_bound: NDArray[np.bool_]
    sse: Array
    implied_scale: float
    converged: bool

    def standard_errors(self, *, between_people: bool = False) -> Array:
        """Return the standard error (5,) of each number, in its own unit."""
        matrix = self.sampling if between_people else self.covariance
        spread = np.sqrt(np.diag(matrix))
        plain = np.array(astuple(self.numbers))
        return np.where(literature().log, plain * spread, spread)

    @property
    def correlation(self) -> Array:
        """Correlation (5, 5) of the coordinates, from ``covariance``. [1]"""
        spread = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(spread, spread))


def misfits(
    reflectance: ArrayLike,
    wavelengths: ArrayLike,
    thickness: tuple[float, float],
    *,
    coefficients: Coefficients,
    specular: str | float,
) -> Array:
    """Return fitted − measured (m, n) of m spectra with a table, weights fitted.

    Arguments as :func:`tune`. A band that is NaN has no misfit. [1]

    Raises
    ------
    ArgumentError
        If a spectrum cannot be fitted.
    """
    data = np.atleast_2d(as_numbers(reflectance, "reflectance"))
    bands = as_wavelengths(wavelengths)
    fit = fit_skin(data, bands, TwoLayer(thickness, coefficients, specular))
    refused = np.flatnonzero(fit.status == REFUSED)
    if refused.size:
        raise ArgumentError(
            f"{refused.size} of {len(data)} spectra cannot be fitted, the first at "
            f"index {refused[0]}; leave them out"
        )
    used = data[:, np.isin(bands, fit.wavelengths)]
    return np.where(np.isnan(used), 0.0, fit.fitted - used)


def tune(
    reflectance: ArrayLike,
    wavelengths: ArrayLike,
    thickness: tuple[float, float],
    *,
    specular: str | float,
    residual_scale: float = RESIDUAL_SCALE,
    prior_scale: float = 1.0,
) -> Tuning:
    """Return the five numbers that fit measured people best, with priors.

    Parameters
    ----------
    reflectance : (m, n) array_like
        One spectrum a person, at one body site. [1]
    wavelengths : (n,) array_like
        As :func:`fit_skin` takes them. [nm]
    thickness : (float, float)
        Of epidermis and dermis at that site. [mm]
    specular : {"excluded", "included"} or float
        How the spectra were measured, as :func:`skin_model` takes it.
    residual_scale : float
        Standard deviation that a band's misfit counts with. [1]
    prior_scale : float
        Factor on the priors' deviations; ``inf`` leaves the priors out.

    Returns
    -------
    tuning : Tuning
        The minimum of Σ (misfit/residual_scale)² + Σ (distance from the prior's
        mean/its deviation)², the better one of two starts: the shipped numbers and
        the priors' means.

    Raises
    ------
    ArgumentError
        If a scale is not positive, there are fewer than 5 spectra, or one cannot
        be fitted.

    References
    ----------
    .. [1] G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10:413 (1973).
    """
    from scipy.optimize import least_squares

    data = np.atleast_2d(as_numbers(reflectance, "reflectance"))
    _check(len(data), residual_scale, prior_scale)
    priors = literature()
    deviation = priors.deviation * prior_scale

    def residuals(coordinates: Array) -> Array:
        table = effective_coefficients(priors.numbers(coordinates), "trial")
        apart = misfits(
            data, wavelengths, thickness, coefficients=table, specular=specular
        )
        # Division by an infinite deviation leaves 0: no prior.
        pull = (coordinates - priors.mean) / deviation
        return np.concatenate([apart.ravel() / residual_scale, pull])

    def slopes(coordinates: Array) -> Array:
        steps = np.diag(_STEP * priors.deviation)
        pairs = [
            (residuals(coordinates + h), residuals(coordinates - h)) for h in steps
        ]
        differences = np.stack([up - down for up, down in pairs], axis=-1)
        return differences / (2 * _STEP * priors.deviation)

    starts = (priors.coordinates(effective_numbers()), priors.mean)
    found = [
        least_squares(
            residuals,
            start,
            slopes,
            bounds=coordinate_bounds(priors),
            x_scale=priors.deviation,
            xtol=1e-6,
            ftol=1e-9,
        )
        for start in starts
    ]
    best = min(found, key=lambda result: float(result.cost))
    return _tuning(best, len(data), residual_scale, prior_scale)


def implied_scale(apart: Array) -> float:
    """Return the standard deviation that misfits (m, n) should count with.

    Their root mean square times the square root of the design effect: n bands over
    the number of independent ones, (tr C)²/tr C² of their covariance C, times
    1 + (m − 1) ρ, where ρ is the share of the misfit that all people have in common
    [1]_. With it, m people whose misfit is the same say as much as one.

    References
    ----------
    .. [1] L. Kish, Survey Sampling (1965), section 5.4: the design effect.
    """
    m, n = apart.shape
    square = float((apart**2).sum(axis=1).mean())
    if square == 0 or m < 2:
        return float(np.sqrt(square / n))
    covariance = apart.T @ apart / m
    independent = np.trace(covariance) ** 2 / (covariance**2).sum()
    common = apart.mean(axis=0)
    scatter = ((apart - common) ** 2).sum() / (m * (m - 1))
    shared = max(float((common**2).sum() - scatter), 0.0) / square
    return float(np.sqrt(square / n * (n / independent) * (1 + (m - 1) * shared)))


def _tuning(
    found: OptimizeResult, m: int, residual_scale: float, prior_scale: float
) -> Tuning:
    """Return what follows from m people's residuals and slopes at the minimum."""
    priors = literature()
    size = len(NAMES)
    apart = found.fun[:-size].reshape(m, -1)
    by_person = found.jac[:-size].reshape(m, -1, size)
    covariance = np.linalg.pinv(found.jac.T @ found.jac, hermitian=True)
    gradients = np.einsum("mnp,mn->mp", by_person, apart)
    gradients -= gradients.mean(axis=0)
    between = gradients.T @ gradients * m / (m - 1)
    prior_variance = (priors.deviation * prior_scale) ** 2
    learned = 1 - np.diag(covariance) / prior_variance
    low, high = coordinate_bounds(priors)
    near = _NEAR * priors.deviation
    return Tuning(
        numbers=priors.numbers(found.x),
        covariance=covariance,
        sampling=covariance @ between @ covariance,
        pull=(found.x - priors.mean) / priors.deviation,
        learned=np.where(np.isfinite(prior_variance), learned, np.nan),
        at_bound=(found.x - low < near) | (high - found.x < near),
        sse=(apart**2).sum(axis=1) * residual_scale**2,
        implied_scale=implied_scale(apart * residual_scale),
        converged=bool(found.success),
    )


def _check(n_spectra: int, residual_scale: float, prior_scale: float) -> None:
    """Refuse scales that mean nothing and too few people."""
    for name, value in (("residual", residual_scale), ("prior", prior_scale)):
        if not value > 0:
            raise ArgumentError(f"{name}_scale must be greater than 0; got {value:g}")
    if n_spectra < len(NAMES):
        raise ArgumentError(
            f"tuning {len(NAMES)} numbers needs at least {len(NAMES)} spectra; got "
            f"{n_spectra}"
        )
