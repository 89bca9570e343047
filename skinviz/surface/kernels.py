"""Compiled surface reflection: blocks of points, of which only cosines are known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types

from skinviz._compile import compiled, inlined
from skinviz._vector_math import angle, decay

_VECTOR = types.float64[::1]
_SIGNATURE = types.void(_VECTOR, _VECTOR, _VECTOR, _VECTOR, _VECTOR, _VECTOR, _VECTOR)
LOBE = types.FunctionType(_SIGNATURE)
"""A lobe: (N·L, N·V, N·H, |N × H|, V·H, constants, out), the last filled in."""

_LN2 = math.log(2)
_LEAST = 1e-300  # 0/0 at grazing incidence on n = 1 is 0


@inlined
def fresnel(mu: Any, n: Any) -> Any:
    """Return Fresnel's reflectance of unpolarised light at a cosine."""
    excess = (n - 1) * (n + 1)
    total = np.sqrt(excess + mu * mu) + mu
    gap = excess / (total + _LEAST)
    ratio = gap / (total + _LEAST)
    p_over_s = (mu * total - 1) / (mu * gap + 1)
    return ratio * ratio * (1 + p_over_s * p_over_s) / 2


@compiled(_SIGNATURE)
def torrance_sparrow(
    NL: Any, NV: Any, NH: Any, SH: Any, VH: Any, constants: Any, out: Any
) -> None:
    """Write β D G/(N·V); ``constants`` are β, γ and whether facets mask each other."""
    beta, gamma, masked = constants[0], constants[1], constants[2]
    for i in range(out.size):
        nv = max(NV[i], 1e-3)
        turn = angle(SH[i], NH[i]) / gamma
        spread = 1 / nv
        if masked != 0:
            doubled = 2 * max(NH[i], 0.0) / max(VH[i], 1e-12)
            spread = min(spread, doubled, doubled * NL[i] / nv)
        facets, _ = decay(_LN2 * turn * turn)
        lit = beta * facets * spread
        out[i] = lit if NL[i] > 0 else 0.0
