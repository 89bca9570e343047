"""How far a fit's uncertainty moves the colour of the skin that it describes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_wavelengths, in_range
from skinviz.errors import ArgumentError
from skinviz.skin.model import SkinModel
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.colorimetry import delta_e_2000, xyz_to_lab, xyz_weights
from skinviz.spectra.illuminants import Illuminant, illuminant_spd

Array = NDArray[np.float64]

LEVEL = 0.95
"""Share of the draws that a colour error or an interval holds."""

DRAWS = 1000
"""Draws by default: the 95 % quantile is then good to 2 %, one standard error."""

_AT_ONCE = 2**21  # numbers of spectra that are held at once


@dataclass(frozen=True, eq=False)
class ColourError:
    """Colours of fitted skin and of what it may be instead.

    Attributes
    ----------
    lab : (..., 3) ndarray
        L*a*b* of the estimates; NaN where there is no fit.
    samples : (..., draws, 3) ndarray
        L*a*b* of the draws; NaN where there is no fit or no finite covariance.
    """

    lab: Array
    samples: Array

    @property
    def delta_e(self) -> Array:
        """Within which ΔE00 of the estimate's colour 95 % of the draws lie (...).

        Infinite where the data do not determine a parameter; NaN without a fit.
        """
        apart = delta_e_2000(self.lab[..., None, :], self.samples)
        reach = np.quantile(apart, LEVEL, axis=-1)
        loose = np.isfinite(self.lab).all(axis=-1) & np.isnan(reach)
        return np.where(loose, np.inf, reach)

    @property
    def covariance(self) -> Array:
        """Of L*, a* and b* over the draws (..., 3, 3)."""
        away = self.samples - self.samples.mean(axis=-2, keepdims=True)
        n = self.samples.shape[-2]
        return np.asarray(np.swapaxes(away, -1, -2) @ away / (n - 1))

    def ellipse(self, first: int = 1, second: int = 2) -> tuple[Array, Array]:
        """Return the 95 % ellipse of two of L*, a* and b*, of a normal distribution.

        Parameters
        ----------
        first, second : int
            Which: 0, 1 and 2 for L*, a* and b*.

        Returns
        -------
        radii : (..., 2) ndarray
            Half axes, the longer first.
        angle : (...) ndarray
            Of the longer one from the first coordinate. [rad]
        """
        pair = [first, second]
        values, vectors = np.linalg.eigh(self.covariance[..., pair, :][..., pair])
        scale = -2 * np.log(1 - LEVEL)  # the quantile of χ² with two degrees of freedom
        radii = np.sqrt(scale * np.maximum(values[..., ::-1], 0))
        return radii, np.arctan2(vectors[..., 1, 1], vectors[..., 0, 1])


def colour_error(
    fit: SkinFit,
    model: SkinModel | None = None,
    wavelengths: ArrayLike | None = None,
    illuminant: str | Illuminant = "D65",
    *,
    draws: int = DRAWS,
    seed: int = 0,
) -> ColourError:
    """Return the colours that the covariance of a fit allows, by Monte Carlo.

    Parameters are drawn from the normal distribution of the estimates and put
    through the model: no curve is straightened. A draw beyond a bound stands at it,
    as an estimate would, and a parameter held at its bound stays there. Colours are
    those of what the instrument reads, surface reflection as measured, by the 2°
    observer.

    Parameters
    ----------
    fit : SkinFit
        Of one spectrum or a batch (...).
    model : SkinModel, optional
        With the fit's parameters; the fit's own if not said.
    wavelengths : (n,) array_like, optional
        Over which colours are summed; the fit's bands if not said. [nm]
    illuminant : str or Illuminant
        Its white is the white of L*a*b*.
    draws : int
        How many for each spectrum, 2 to a million; each keeps 24 bytes.
    seed : int
        The same seed gives the same draws.

    Returns
    -------
    error : ColourError
        Draws of different spectra are independent, so that
        :func:`difference_interval` holds for any two.

    Raises
    ------
    ArgumentError
        If the model has other parameters than the fit, or ``draws`` is too small.
    """
    model = fit.model if model is None else model
    if tuple(p.name for p in model.parameters) != fit.parameters:
        raise ArgumentError(
            f"the fit has the parameters {', '.join(fit.parameters)}; give a model "
            f"with the same; got {model.name}"
        )
    draws = int(in_range(draws, 2, 1_000_000, "draws"))
    bands = fit.wavelengths if wavelengths is None else as_wavelengths(wavelengths)
    weights = xyz_weights(bands, illuminant_spd(illuminant, bands))

    def lab(values: Array) -> Array:
        return xyz_to_lab(model.measured(values, bands) @ weights, weights.sum(axis=0))

    shape = fit.values.shape[:-1]
    values = fit.values.reshape(-1, len(fit.parameters))
    covariance = fit.covariance.reshape(len(values), *fit.covariance.shape[-2:])
    fitted = np.isfinite(values).all(axis=1)
    known = fitted & np.isfinite(covariance).all(axis=(1, 2))
    colours = np.full((len(values), 3), np.nan)
    colours[fitted] = lab(values[fitted])
    samples = np.full((len(values), draws, 3), np.nan)
    bounds = np.array([(p.lower, p.upper) for p in model.parameters])
    rng = np.random.default_rng(seed)
    step = max(1, _AT_ONCE // (draws * bands.size))
    for some in np.array_split(np.flatnonzero(known), -(-known.sum() // step) or 1):
        normal = rng.standard_normal((some.size, draws, len(bounds)))
        spread = normal @ np.swapaxes(_root(covariance[some]), -1, -2)
        drawn = np.clip(values[some, None] + spread, *bounds.T)
        samples[some] = lab(drawn)
    return ColourError(colours.reshape(*shape, 3), samples.reshape(*shape, draws, 3))


def difference_interval(first: ColourError, second: ColourError) -> Array:
    """Return the 95 % interval of ΔE00 between skins, from both fits' covariances.

    Parameters
    ----------
    first, second : ColourError
        Their shapes broadcast; with as many draws.

    Returns
    -------
    interval : (..., 2) ndarray
        NaN where one has no draws. ΔE00 has no sign: of two skins of one colour the
        interval lies above zero, as far as their uncertainties reach.
    """
    apart = delta_e_2000(first.samples, second.samples)
    tail = (1 - LEVEL) / 2
    return np.moveaxis(np.quantile(apart, [tail, 1 - tail], axis=-1), 0, -1)


def _root(covariance: Array) -> Array:
    """Return A (m, p, p) with A Aᵀ = covariance, whose rows of held ones are 0."""
    deviation = np.sqrt(np.maximum(np.einsum("mpp->mp", covariance), 0))
    scale = np.where(deviation > 0, deviation, 1.0)  # weights differ by magnitudes
    unit = covariance / (scale[:, :, None] * scale[:, None, :])
    values, vectors = np.linalg.eigh(unit)
    root = vectors * np.sqrt(np.maximum(values, 0))[:, None, :]
    return np.asarray(deviation[:, :, None] * root)
