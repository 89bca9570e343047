"""Kubelka–Munk layers and stacks, one wavelength at a time, compiled into loops.

What belongs here is scalar physics without branches, so that a loop over bands that
calls it becomes vector instructions; checks and array shapes are the callers'.

With a = K + S, κ² = K(K + 2S), y = κD and E = e^(−y) a layer has

    R = S s/Q,  T = 2κE/Q,  1 − R = (K s + κ C)/Q,  1 − R − T = (K s + κ m²)/Q

where s = 1 − E², C = 1 + E², m = 1 − E and Q = a s + κ C: sums and products of
terms ≥ 0 only. The functions below return such numerators and Q apart, because a
stack needs only one quotient of them. A layer without absorption is one with
κ = 1e-80, which is the same to the last digit; in an endless one E is 0.

References
----------
.. [1] First-order perturbation of the two-flux equations; by reciprocity a photon
   that goes up at depth z leaves with probability I(z), one that goes down with J(z).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types

from skinviz._compile import compiled, inlined
from skinviz._vector_math import DEEPEST, decay

_LEAST = 1e-160  # κ² of a layer without absorption; its powers stay normal floats
_NEAR = 0.0625  # y² below which differences are taken from their series

TOP, BOTTOM, CARRY = 0, 5, 10
"""First rows of two layers (K and S, then what :func:`prepare` makes of them), and of
what a model keeps of each band to carry slopes to what is measured."""

SCRATCH = 20
"""Rows that a model may use while it evaluates."""

_VECTOR, _MATRIX = types.float64[::1], types.float64[:, ::1]
EVALUATE = types.FunctionType(
    types.void(_VECTOR, _MATRIX, _VECTOR, _MATRIX, _VECTOR, _MATRIX)
)
"""A model: (values, table, constants, scratch, measured, jacobian), last two filled.

``jacobian`` is (p, n), or (0, n) where it is not wanted.
"""

# 2 (y cosh y − sinh y)/y³ and 4 (sinh y cosh y − y)/y³ in powers of y².
H0, H1, H2, H3, H4, H5 = (4 * k / math.factorial(2 * k + 1) for k in range(1, 7))
G0, G1, G2, G3, G4, G5 = (4 ** (k + 1) / math.factorial(2 * k + 1) for k in range(1, 7))


Layer = tuple[float, float, float, float, float]
Carry = tuple[float, float, float, float, float]


@inlined
def root(K: float, S: float) -> float:
    """Return κ [mm⁻¹], never 0."""
    square = K * (K + 2 * S)
    return math.sqrt(square if square > _LEAST else _LEAST)


@inlined
def depth(kappa: float, K: float, S: float, D: float) -> float:
    """Return y = κD, at most where e^(−y) is 0; 0 where there is no matter."""
    y = kappa * D if K + S > 0 else 0.0
    return y if y < DEEPEST else DEEPEST


@inlined
def layer(K: float, S: float, kappa: float, E: float, m: float) -> Layer:
    """Return R, T, 1 − R, 1 − R − T of a layer, each times Q, and Q."""
    s = m * (2 - m)
    R = S * s
    U = K * s + kappa * (1 + E * E)
    return R, 2 * kappa * E, U, K * s + kappa * (m * m), R + U


@inlined
def absorption_slopes(
    K: float, S: float, kappa: float, y: float, E: float, m: float
) -> tuple[float, float]:
    """Return ∂R/∂K and ∂T/∂K of a layer times Q²κ, both ≤ 0."""
    a = K + S
    s = m * (2 - m)
    h, g = _differences(y, E, s)
    R_slope = -S * (a * g + kappa * (s * s))
    return R_slope, -2 * E * (kappa * s * (kappa + a * y) + a * a * h)


@inlined
def over_backing(bottom: Layer, backing: float) -> tuple[float, float, Carry]:
    """Return R and 1 − R of a layer on a backing, and what carries slopes to R.

    Eq. (6) in complements, so that nothing cancels. What carries: the reflectance R′
    beneath the layer, 1 − R′, 1/(Q(1 − R R′)), 1/Q, and the flux that enters it.
    """
    R, T, U, A, Q = bottom
    lost = 1 - backing
    V = U + R * lost
    share = 1 / (V * Q)
    base = (R * V + T * T * backing) * share
    complement = (A * V + T * (A + (R + T) * lost)) * share
    return base, complement, (backing, lost, Q * share, V * share, 1.0)


@inlined
def stack(top: Layer, bottom: Layer, backing: float) -> tuple[float, Carry, Carry]:
    """Return R_b of two layers over a backing, eq. (5), and the carries of both."""
    base, complement, (beneath, lost, under, over, _) = over_backing(bottom, backing)
    R, T, U, _, Q = top
    V = U + R * complement
    share = 1 / (V * Q)
    body = (R * V + T * T * base) * share
    through = T * Q * share
    first = (base, complement, Q * share, V * share, 1.0)
    return body, first, (beneath, lost, under, over, through)


@inlined
def by_absorption(
    K: float, S: float, kappa: float, y: float, E: float, m: float, carry: Carry
) -> float:
    """Return ∂R_b/∂K of a layer. [mm]"""
    v, factor = absorbing(kappa, E, carry)
    return carried(absorption_slopes(K, S, kappa, y, E, m), v, factor)


@inlined
def absorbing(kappa: float, E: float, carry: Carry) -> tuple[float, float]:
    """Return what :func:`carried` needs: the flux that comes back, and a factor."""
    beneath, _, inverse_V, inverse_Q, enters = carry
    share = enters * inverse_Q
    return 2 * kappa * E * beneath * inverse_V, share * share / kappa


@inlined
def carried(slopes: tuple[float, float], v: float, factor: float) -> float:
    """Return ∂R_b/∂K from a layer's own slopes: light meets R once, or T twice."""
    return factor * (slopes[0] * (1 + v * v) + 2 * v * slopes[1])


@inlined
def by_scattering(
    K: float, S: float, kappa: float, y: float, E: float, m: float, carry: Carry
) -> float:
    """Return ∂R_b/∂S of a layer, ≥ 0. [mm]

    It is ∫ (I − J)² dz over the layer, I and J the fluxes down and up [1]_; in this
    form nothing cancels where scattering hardly shows, as over a white backing.
    """
    beneath, complement, inverse_V, _, enters = carry
    s = m * (2 - m)
    _, g = _differences(y, E, s)
    net, all_ = kappa * complement, K * (1 + beneath)
    share = enters * inverse_V
    inside = net * net * (4 * y * E * E + s * (1 + E * E))
    return (inside + 2 * net * all_ * (s * s) + all_ * all_ * g) * (
        share * share / (2 * kappa)
    )


@inlined
def by_thickness(K: float, S: float, kappa: float, E: float, carry: Carry) -> float:
    """Return ∂R_b/∂D of a layer, of either sign: more matter at its lower side."""
    beneath, complement, inverse_V, _, enters = carry
    reaches = 2 * kappa * E * inverse_V * enters
    return reaches * reaches * (S * complement * complement - 2 * K * beneath)


@inlined
def _differences(y: float, E: float, s: float) -> tuple[float, float]:
    """Return E·2(y cosh y − sinh y) and E²·4(sinh y cosh y − y), y ≥ 0."""
    y2, E2 = y * y, E * E
    C, cube = 1 + E2, y2 * y * E
    h = cube * (H0 + y2 * (H1 + y2 * (H2 + y2 * (H3 + y2 * (H4 + y2 * H5)))))
    g = cube * E * (G0 + y2 * (G1 + y2 * (G2 + y2 * (G3 + y2 * (G4 + y2 * G5)))))
    near = y2 < _NEAR
    return (h if near else y * C - s), (g if near else s * C - 4 * y * E2)


@inlined
def through_surface(
    body: float, offset: float, transmission: float, internal: float
) -> tuple[float, float]:
    """Return what is measured of a body under an interface, and its slope."""
    out = 1 / (1 - internal * body)
    return offset + transmission * body * out, transmission * out * out


@inlined
def prepare(rows: Any, first: int, D: float) -> None:
    """Fill in κ, e^(−y) and 1 − e^(−y) of a layer after its K and S, in all bands.

    Short loops one after the other: in one long loop a processor cannot begin the
    next bands before these are done.
    """
    for j in range(rows.shape[1]):
        rows[first + 2, j] = root(rows[first, j], rows[first + 1, j])
    for j in range(rows.shape[1]):
        y = depth(rows[first + 2, j], rows[first, j], rows[first + 1, j], D)
        rows[first + 3, j], rows[first + 4, j] = decay(y)


@inlined
def layer_of(rows: Any, first: int, j: int) -> Layer:
    """Return a prepared layer in one band, as :func:`layer` does."""
    return layer(
        rows[first, j],
        rows[first + 1, j],
        rows[first + 2, j],
        rows[first + 3, j],
        rows[first + 4, j],
    )


@inlined
def slopes_of(rows: Any, first: int, D: float, j: int) -> tuple[float, float]:
    """Return :func:`absorption_slopes` of a prepared layer in one band."""
    K, S, kappa = rows[first, j], rows[first + 1, j], rows[first + 2, j]
    y = depth(kappa, K, S, D)
    return absorption_slopes(K, S, kappa, y, rows[first + 3, j], rows[first + 4, j])


@compiled()
def layers(K: Any, S: Any, D: Any, R: Any, T: Any) -> None:
    """Write R and T of many layers; all arguments are (m,)."""
    for i in range(K.size):
        kappa = root(K[i], S[i])
        E, m = decay(depth(kappa, K[i], S[i], D[i]))
        R_Q, T_Q, _, _, Q = layer(K[i], S[i], kappa, E, m)
        R[i], T[i] = R_Q / Q, T_Q / Q


@compiled(types.void(EVALUATE, _MATRIX, _MATRIX, _VECTOR, _MATRIX))
def spectra(
    evaluate: Any, values: Any, table: Any, constants: Any, measured: Any
) -> None:
    """Write a model's spectra (m, n) of values (m, p); the table may be padded."""
    row = np.zeros(table.shape[1])
    scratch = np.zeros((SCRATCH, table.shape[1]))
    nothing = np.zeros((0, table.shape[1]))
    for i in range(values.shape[0]):
        evaluate(values[i], table, constants, scratch, row, nothing)
        for j in range(measured.shape[1]):
            measured[i, j] = row[j]
