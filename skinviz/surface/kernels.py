"""Compiled surface reflection: blocks of points, of which only cosines are known."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from skinviz._compile import compiled, inlined
from skinviz._vector_math import angle, decay, loss_log
from skinviz.surface.masking import SMALLEST_COSINE

_VECTOR, _MATRIX = types.float64[::1], types.float64[:, ::1]
_SIGNATURE = types.void(_VECTOR, _VECTOR, _VECTOR, _VECTOR, _VECTOR, _VECTOR, _VECTOR)
LOBE = types.FunctionType(_SIGNATURE)
"""A lobe: (N·L, N·V, N·H, |N × H|, V·H, constants, out), the last filled in.

``out`` is the geometry's factor D G/(N·V), without Fresnel's: 0 where N·L ≤ 0.
"""

BLOCK = 512
"""Most points that a lobe is given at once."""

_LEAST = 1e-300  # 0/0 at grazing incidence on n = 1 is 0
_EDGE = 1e-30  # cosine of facets that stand on edge
_UNMASKED = 1e300  # facets that hide nothing, as a bound on G/(N·V)


@inlined
def fresnel(mu: Any, n: Any) -> Any:
    """Return Fresnel's reflectance of unpolarised light at a cosine."""
    excess = (n - 1) * (n + 1)
    total = np.sqrt(excess + mu * mu) + mu
    gap = excess / (total + _LEAST)
    ratio = gap / (total + _LEAST)
    p_over_s = (mu * total - 1) / (mu * gap + 1)
    return ratio * ratio * (1 + p_over_s * p_over_s) / 2


@inlined
def v_cavity(NL: Any, nv: Any, NH: Any, VH: Any, least: Any) -> Any:
    """Return G/(N·V) of facets in pairs, or 1/(N·V) where ``least`` is huge."""
    facing = NH if NH > 0 else 0.0
    across = 2 * facing / (VH if VH > 1e-12 else 1e-12)
    inverse = 1 / nv
    view = across if across > least else least
    light = across * NL * inverse
    light = light if light > least else least
    most = view if view < light else light
    return inverse if inverse < most else most


@compiled(_SIGNATURE)
def torrance_sparrow(
    NL: Any, NV: Any, NH: Any, SH: Any, VH: Any, constants: Any, out: Any
) -> None:
    """Write β D G/(N·V); ``constants`` are β, √ln 2/γ and whether facets mask."""
    beta, steepness = constants[0], constants[1]
    least = 0.0 if constants[2] != 0 else _UNMASKED
    for i in range(out.size):
        nv = NV[i] if NV[i] > SMALLEST_COSINE else SMALLEST_COSINE
        tilt = angle(SH[i], NH[i]) * steepness
        spread = v_cavity(NL[i], nv, NH[i], VH[i], least)
        lit = beta * decay(tilt * tilt)[0] * spread
        out[i] = lit if NL[i] > 0 else 0.0


@inlined
def _smith(cosine: Any, inverse_slope: Any) -> Any:
    """Return Walter's G₁ of Beckmann's facets; see ``masking.smith``."""
    square = 1 - cosine * cosine
    sine = np.sqrt(square if square > 0 else 0.0)
    a = cosine * inverse_slope / (sine + _LEAST)
    a = a if a < 1.6 else 1.6
    seen = a * (3.535 + 2.181 * a) / (1 + a * (2.276 + 2.577 * a))
    return seen if a < 1.6 else 1.0


@inlined
def _beckmann(SH: Any, NH: Any, inverse_slope: Any) -> Any:
    """Return exp(−tan²θ/m²)/cos⁴θ; 0 for facets that face away."""
    c = NH if NH > _EDGE else _EDGE
    inverse = 1 / c
    slope = SH * inverse * inverse_slope
    square = inverse * inverse
    D = decay(slope * slope)[0] * (square * square)
    return D if NH > 0 else 0.0


@compiled(_SIGNATURE)
def cook_torrance(
    NL: Any, NV: Any, NH: Any, SH: Any, VH: Any, constants: Any, out: Any
) -> None:
    """Write β D G/(N·V); ``constants`` are β/(π m²), 1/m and the kind of masking.

    0 is V-cavities, 1 is Smith's, 2 none.
    """
    height, inverse_slope, masking = constants[0], constants[1], constants[2]
    if masking == 1:
        for i in range(out.size):
            nl = NL[i] if NL[i] > 0 else 0.0
            nv = NV[i] if NV[i] > SMALLEST_COSINE else SMALLEST_COSINE
            G = _smith(nl, inverse_slope) * _smith(nv, inverse_slope)
            lit = height * _beckmann(SH[i], NH[i], inverse_slope) * (G / nv)
            out[i] = lit if NL[i] > 0 else 0.0
        return
    least = 0.0 if masking == 0 else _UNMASKED
    for i in range(out.size):
        nv = NV[i] if NV[i] > SMALLEST_COSINE else SMALLEST_COSINE
        spread = v_cavity(NL[i], nv, NH[i], VH[i], least)
        lit = height * _beckmann(SH[i], NH[i], inverse_slope) * spread
        out[i] = lit if NL[i] > 0 else 0.0


@compiled(_SIGNATURE)
def phong(
    NL: Any, NV: Any, NH: Any, SH: Any, VH: Any, constants: Any, out: Any
) -> None:
    """Write β cos^p α N·L; ``constants`` are β and p."""
    beta, exponent = constants[0], constants[1]
    for i in range(out.size):
        apart, across = NL[i] - NV[i], VH[i] * SH[i]
        drop = 0.5 * apart * apart + 2 * across * across  # 1 − cos α
        lit = beta * decay(exponent * loss_log(drop))[0] * NL[i]
        lit = lit if drop < 1 else 0.0
        out[i] = lit if NL[i] > 0 else 0.0


@compiled(_SIGNATURE)
def lambert(
    NL: Any, NV: Any, NH: Any, SH: Any, VH: Any, constants: Any, out: Any
) -> None:
    """Write 0: there is no specular reflection."""
    for i in range(out.size):
        out[i] = 0.0


@compiled(types.void(LOBE, _MATRIX, _VECTOR, _VECTOR, _VECTOR))
def specular(lobe: Any, cosines: Any, constants: Any, n: Any, out: Any) -> None:
    """Write a lobe times Fresnel's reflectance at points; ``cosines`` are (5, m)."""
    for start in range(0, out.size, BLOCK):
        stop = min(start + BLOCK, out.size)
        lobe(
            cosines[0, start:stop],
            cosines[1, start:stop],
            cosines[2, start:stop],
            cosines[3, start:stop],
            cosines[4, start:stop],
            constants,
            out[start:stop],
        )
        for i in range(start, stop):
            out[i] *= fresnel(cosines[4, i], n[i])
