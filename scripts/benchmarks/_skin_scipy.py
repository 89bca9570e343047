"""The same fit as a user of SciPy would write it: model in NumPy, one spectrum a call.

The layer is eq. (3) divided by cosh, so that nothing overflows, and its derivative is
that form's own: another formula than the package's.
"""

from collections.abc import Callable

import numpy as np
from _skin_data import NM, Batch
from scipy.optimize import OptimizeResult, least_squares

from skinviz.skin.coefficients import load_coefficients

SCALE = np.array([0.1, 0.01, 0.01])  # sizes of skin's weights
START = (0.1, 0.01, 0.005)
STARTS = ((0.03, 1e-3, 3e-3), (0.1, 0.01, 0.003), (0.4, 0.03, 0.03), (0.0, 0.0, 0.05))
TIGHT = {"ftol": 1e-15, "xtol": 1e-13, "gtol": 1e-15, "max_nfev": 500}
LEAST = 1e-9  # absorption that stands for none [mm⁻¹]

Curve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def numpy_curve(batch: Batch) -> Curve:
    """Return the two-layer model and its Jacobian (61, 3), in NumPy."""
    at, model = load_coefficients().at(NM), batch.model
    surface, (D_e, D_d) = model.interface, model.thickness
    blood = np.stack([at.oxyhaemoglobin, at.deoxyhaemoglobin], axis=1)

    def curve(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        R_e, T_e, dR_e, dT_e = _layer(weights[0] * at.melanin, at.epidermis, D_e)
        R_d, T_d, dR_d, dT_d = _layer(blood @ weights[1:], at.dermis, D_d)
        through = T_d / (1 - R_d)
        below = R_d + T_d * through
        gap = 1 / (1 - R_e * below)
        body = R_e + T_e**2 * below * gap
        back = T_e * below * gap
        by_K_e = dR_e * (1 + back**2) + 2 * back * dT_e
        by_K_d = (T_e * gap) ** 2 * (dR_d * (1 + through**2) + 2 * through * dT_d)
        out = 1 / (1 - surface.internal * body)
        slope = surface.transmission * out**2
        jacobian = np.zeros((NM.size, 3))
        jacobian[:, 0] = slope * by_K_e * at.melanin
        jacobian[:, 1:] = (slope * by_K_d)[:, None] * blood
        return surface.offset + surface.transmission * body * out, jacobian

    return curve


def compiled_curve(batch: Batch) -> Curve:
    """Return the package's own compiled model and Jacobian."""
    model = batch.model
    table, constants = model.arrays(NM, model.interface)

    def curve(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        curves, slopes = model.curves_and_slopes(weights[None], table, constants)
        return curves[0, : NM.size], slopes[0, :, : NM.size].T

    return curve


def fit(
    curve: Curve, spectrum: np.ndarray, start: tuple = START, **options: object
) -> OptimizeResult:
    """Return SciPy's bounded fit; the Jacobian comes with the residual, for once."""
    kept: dict[bytes, np.ndarray] = {}

    def residual(weights: np.ndarray) -> np.ndarray:
        measured, jacobian = curve(weights)
        kept.clear()
        kept[weights.tobytes()] = jacobian
        return measured - spectrum

    def slopes(weights: np.ndarray) -> np.ndarray:
        found = kept.get(weights.tobytes())
        return curve(weights)[1] if found is None else found

    return least_squares(residual, start, slopes, bounds=(0, np.inf), **options)


def best_sse(batch: Batch, own: np.ndarray) -> np.ndarray:
    """Return the least sum of squares (m,) that SciPy reaches from several starts.

    One of them is what the package found (m, 3), moved off its bounds: is there
    anything better beside it? The sums are of the package's own curve at SciPy's
    weights, so that no difference of two formulas enters.
    """
    curve, model = numpy_curve(batch), batch.model
    found = np.full((len(own), len(STARTS) + 1, 3), np.nan)
    for i, (spectrum, values) in enumerate(zip(batch.spectra, own, strict=True)):
        near = tuple(np.maximum(values, 1e-6) * 1.01)
        for k, start in enumerate((*STARTS, near)):
            found[i, k] = fit(
                curve, spectrum, start, method="dogbox", x_scale=SCALE, **TIGHT
            ).x
    off = model.measured(found, NM) - batch.spectra[:, None]
    return (off**2).sum(axis=-1).min(axis=1)


def _layer(K: np.ndarray, S: np.ndarray, D: float) -> tuple[np.ndarray, ...]:
    """Return R, T and their slopes by K."""
    K = np.maximum(K, LEAST)
    a = K + S
    kappa = np.sqrt(K * (a + S))
    E = np.exp(-kappa * D)
    t = (1 - E * E) / (1 + E * E)  # tanh
    ratio = a / kappa  # ∂κ/∂K
    t_slope = (1 - t * t) * (D * ratio)
    q = 1 / (a * t + kappa)
    R, T = S * t * q, kappa * q * 2 * E / (1 + E * E)
    q_slope = t + a * t_slope + ratio
    return (
        R,
        T,
        (S * t_slope - R * q_slope) * q,
        T * (ratio * (1 / kappa - t * D) - q_slope * q),
    )
