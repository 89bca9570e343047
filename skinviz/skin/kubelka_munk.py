"""Kubelka–Munk: one layer, two layers over a backing, and what the fit derives.

Everything here is flux ratios and their derivatives over plain arrays; pigments
and tissue are in ``coefficients`` and the models.

The textbook hyperbolic form divides by S, cancels where K is much less than S
and overflows in thick layers. With

    κ = √K √(K + 2S),  x = 2κD,  φ = (1 − e⁻ˣ)/κ (or 2D at κ = 0),
    q = (K + S)φ + 1 + e⁻ˣ

it is R = Sφ/q and T = 2e^(−x/2)/q: sums and products of positive terms only, as
are the derivatives below. Eq. (3) of Doi et al. prints the last term of T's
denominator as b coth(bSD); it is b cosh(bSD), as T(D = 0) = 1 demands.
"""

from __future__ import annotations

from math import factorial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

SMALLEST, LARGEST = 1e-16, 1e16
"""Range in which K, S [mm⁻¹] and thickness [mm] may lie, besides 0 and D = inf."""


class LayerFluxes(NamedTuple):
    """What a layer does to light that falls on it, each of broadcast shape.

    Attributes
    ----------
    reflectance, transmittance : ndarray
        R and T. [1]
    complement : ndarray
        1 − R, free of cancellation. [1]
    absorptance : ndarray
        1 − R − T, free of cancellation. [1]
    """

    reflectance: Array
    transmittance: Array
    complement: Array
    absorptance: Array


class LayerSlopes(NamedTuple):
    """Derivatives of a layer's R and T with respect to its K, both ≤ 0. [mm]"""

    reflectance: Array
    transmittance: Array


def kubelka_munk_layer(
    K: ArrayLike, S: ArrayLike, thickness: ArrayLike
) -> tuple[Array, Array]:
    """Reflectance and transmittance of one Kubelka–Munk layer over black.

    Diffuse light, no interfaces. The arguments broadcast together.

    Parameters
    ----------
    K : array_like
        Kubelka–Munk absorption. [mm⁻¹], 0 or 1e-16 to 1e16
    S : array_like
        Kubelka–Munk back-scattering. [mm⁻¹], 0 or 1e-16 to 1e16
    thickness : array_like
        Layer thickness D. [mm], 0 or 1e-16 to 1e16, or ``inf``

    Returns
    -------
    R, T : ndarray of float64
        Diffuse reflectance and transmittance. [1]

    Raises
    ------
    ArgumentError
        If an argument is negative, NaN or outside the declared range, or the
        shapes do not broadcast.

    Notes
    -----
    Accurate to 1e-12 relative over the declared range wherever T is a normal
    float (T ≥ 2.3e-308). K = S = 0 gives (0, 1) for every thickness, ``inf`` too.

    References
    ----------
    .. [1] P. Kubelka, J. Opt. Soc. Am. 38:448 (1948).
    .. [2] Doi, Tanaka & Tominaga, J. Imaging Sci. Technol. 49:574 (2005), eq. (3).

    Examples
    --------
    >>> R, T = kubelka_munk_layer(0.0, 3.0, 1.0)
    >>> float(R), float(T)  # SD/(1 + SD), 1/(1 + SD)
    (0.75, 0.25)
    """
    absorption = _coefficient(K, "K")
    scattering = _coefficient(S, "S")
    depth = _coefficient(thickness, "thickness", infinite_allowed=True)
    try:
        np.broadcast_shapes(absorption.shape, scattering.shape, depth.shape)
    except ValueError as error:
        raise ArgumentError(
            f"K {absorption.shape}, S {scattering.shape} and thickness "
            f"{depth.shape} do not broadcast together"
        ) from error
    fluxes = layer_fluxes(absorption, scattering, depth)
    return np.asarray(fluxes.reflectance), np.asarray(fluxes.transmittance)


def layer_fluxes(K: Array, S: Array, D: Array) -> LayerFluxes:
    """Return R, T, 1 − R and 1 − R − T of a layer, arguments taken as valid."""
    kappa, x, decay, phi = _terms(K, S, D)
    infinite = np.isinf(D)
    # At D = inf, φ = 1/κ: every term is multiplied by κ so that K = 0 needs no limit.
    q = np.where(infinite, K + S + kappa, (K + S) * phi + 1 + decay)
    nothing = q == 0  # endless, but no matter in it: the light goes through
    q = np.where(nothing, 1.0, q)
    with np.errstate(under="ignore"):
        R = np.where(infinite, S, S * phi) / q
        A = np.where(infinite, K + kappa, K * phi + np.expm1(-x / 2) ** 2) / q
        U = np.where(infinite, K + kappa, K * phi + 1 + decay) / q
        T = np.where(infinite, 0.0, 2 * np.exp(-x / 2)) / q
    return LayerFluxes(R, np.where(nothing, 1.0, T), np.where(nothing, 1.0, U), A)


def layer_slopes(K: Array, S: Array, D: Array) -> LayerSlopes:
    """Return ∂R/∂K and ∂T/∂K of a layer, one-sided at K = 0.

    ∂R/∂K = −S [φ² + 8D³(K + S) g(x)]/q² and
    ∂T/∂K = −(T/q) [φ + (K + S)((K + S) 4D³ h(x) + Dφ)], with
    g = (1 − e⁻²ˣ − 2x e⁻ˣ)/x³ and h = (x(1 + e⁻ˣ) − 2(1 − e⁻ˣ))/x³.
    At D = inf, ∂R/∂K = −R (1 + (K + S)/κ)/(K + S + κ), infinite at K = 0.
    """
    kappa, x, decay, phi = _terms(K, S, D)
    infinite = np.isinf(D)
    depth = np.where(infinite, 0.0, D)
    total = K + S
    with np.errstate(under="ignore"):
        q = total * phi + 1 + decay
        T = 2 * np.exp(-x / 2) / q
        # Powers of D are spread over the factors so that none overflows alone.
        R_slope = -(S * phi / q) * (phi / q) - (S * depth / q) * (
            8 * total * depth / q
        ) * (depth * _g(x))
        T_slope = -(T / q) * (
            phi + total * depth * (4 * total * depth * depth * _h(x) + phi)
        )
    if not infinite.any():
        return LayerSlopes(R_slope, T_slope)
    spread = total + kappa
    # κ = 0 with S > 0 is K = 0 in an endless layer, where R leaves 1 vertically.
    growth = np.divide(total, kappa, out=np.full_like(spread, np.inf), where=kappa > 0)
    steep = np.divide(
        -S * (1 + np.where(S > 0, growth, 0.0)),
        spread * spread,
        out=np.zeros_like(spread),
        where=S > 0,
    )
    return LayerSlopes(
        np.where(infinite, steep, R_slope), np.where(infinite, 0.0, T_slope)
    )


def over_backing(layer: LayerFluxes, backing: float) -> tuple[Array, Array]:
    """Return R and 1 − R of a layer on a backing of reflectance 0 to 1.

    Eq. (6), for any backing g: R_dt = R + T² g/V and 1 − R_dt =
    A + T (A + (R + T)(1 − g))/V, with V = 1 − R g = U + R (1 − g).
    """
    R, T, U, A = layer
    lost = 1 - backing
    gap = U + R * lost
    with np.errstate(under="ignore"):
        base = R + T * _ratio(T * backing, gap)
        complement = A + T * _ratio(A + (R + T) * lost, gap)
    return base, complement


def stack_reflectance(top: LayerFluxes, bottom: LayerFluxes, backing: float) -> Array:
    """Return the reflectance of two layers over a backing of reflectance 0 to 1.

    Eq. (5) in complements, R_b = R_e + T_e² R_dt/(U_e + R_e U_dt): nothing is
    subtracted, so nothing cancels.
    """
    base, base_complement = over_backing(bottom, backing)
    gap = top.complement + top.reflectance * base_complement
    with np.errstate(under="ignore"):
        through = top.transmittance * _ratio(top.transmittance * base, gap)
    return top.reflectance + through


class StackSlopes(NamedTuple):
    """R_b and its derivatives with respect to K of the top and bottom layer. [mm]"""

    reflectance: Array
    top: Array
    bottom: Array


def stack_slopes(
    K: tuple[Array, Array],
    S: tuple[Array, Array],
    D: tuple[float, float],
    backing: float,
) -> StackSlopes:
    """Return R_b of two layers and its derivatives, (top, bottom) in each argument."""
    depths = [np.asarray(depth, dtype=np.float64) for depth in D]
    top, bottom = (layer_fluxes(*args) for args in zip(K, S, depths, strict=True))
    d_top, d_bottom = (layer_slopes(*args) for args in zip(K, S, depths, strict=True))
    base, base_complement = over_backing(bottom, backing)
    gap = top.complement + top.reflectance * base_complement
    bottom_gap = bottom.complement + bottom.reflectance * (1 - backing)
    with np.errstate(under="ignore"):
        pass_top = _ratio(top.transmittance, gap)
        pass_bottom = _ratio(bottom.transmittance * backing, bottom_gap)
        d_base = (
            d_bottom.reflectance * (1 + pass_bottom**2)
            + 2 * pass_bottom * d_bottom.transmittance
        )
        reflectance = top.reflectance + top.transmittance * pass_top * base
        by_top = (
            d_top.reflectance * (1 + (pass_top * base) ** 2)
            + 2 * pass_top * base * d_top.transmittance
        )
        # Where no light comes through the top, an infinite slope below is unseen.
        by_bottom = np.multiply(
            pass_top**2, d_base, out=np.zeros_like(gap), where=pass_top > 0
        )
    return StackSlopes(reflectance, by_top, by_bottom)


def _terms(K: Array, S: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """Return κ, x = 2κD, e⁻ˣ and φ, with φ and x set to 0 where D is infinite."""
    finite = np.where(np.isinf(D), 0.0, D)
    kappa = np.sqrt(K) * np.sqrt(K + 2 * S)
    x = 2 * kappa * finite
    with np.errstate(under="ignore"):
        decay = np.exp(-x)
        phi = np.where(
            x > 0, -np.expm1(-x) / np.where(kappa > 0, kappa, 1.0), 2 * finite
        )
    return kappa, x, decay, phi


def _g(x: Array) -> Array:
    """Return (1 − e⁻²ˣ − 2x e⁻ˣ)/x³, which is 1/3 at 0."""
    near, far = np.where(x < 1, x, 0.0), np.where(x < 1, 1.0, x)
    series = 2 * np.exp(-near) * np.polyval(_SINH_SERIES, near**2)
    direct = (1 - np.exp(-2 * far) - 2 * far * np.exp(-far)) / far**3
    return np.where(x < 1, series, direct)


def _h(x: Array) -> Array:
    """Return (x(1 + e⁻ˣ) − 2(1 − e⁻ˣ))/x³, which is 1/6 at 0."""
    near, far = np.where(x < 1, x / 2, 0.0), np.where(x < 1, 1.0, x)
    series = np.exp(-near) / 2 * np.polyval(_COSH_SERIES, near**2)
    direct = (far * (1 + np.exp(-far)) + 2 * np.expm1(-far)) / far**3
    return np.where(x < 1, series, direct)


def _ratio(numerator: Array, denominator: Array) -> Array:
    """Return a quotient, 0 where the denominator is: no light comes through there."""
    nothing = denominator == 0
    return np.where(nothing, 0.0, numerator / np.where(nothing, 1.0, denominator))


def _coefficient(
    value: ArrayLike, name: str, *, infinite_allowed: bool = False
) -> Array:
    """Return an argument as float64 after checking the declared range."""
    array = as_numbers(value, name)
    inside = (array == 0) | ((array >= SMALLEST) & (array <= LARGEST))
    if infinite_allowed:
        inside |= array == np.inf
    if not inside.all():
        worst = array[~inside].ravel()[0]
        also = " or infinite" if infinite_allowed else ""
        raise ArgumentError(
            f"{name} must be 0, within {SMALLEST:g} to {LARGEST:g}{also}; got {worst:g}"
        )
    return array


# (sinh x − x)/x³ and (x cosh x − sinh x)/x³ in powers of x², highest first.
_SINH_SERIES = [1 / factorial(2 * k + 1) for k in range(10, 0, -1)]
_COSH_SERIES = [2 * k / factorial(2 * k + 1) for k in range(10, 0, -1)]
