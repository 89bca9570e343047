"""Functions that compiled loops can compute for several numbers at once.

Those of numba's own mathematics are called once a number. These have no branches and
no calls, so that a loop over them becomes vector instructions.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from skinviz._compile import inlined

DEEPEST = 708.39
"""e^−y beyond is below the smallest normal float: 0."""

_LOG2_E = 1 / math.log(2)
_LN2_HIGH, _LN2_LOW = 0.693147180369123816490, 1.90821492927058770002e-10
_SHIFT = 1.5 * 2.0**52  # adding it leaves the nearest whole number in the low bits
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11, _C12 = (
    1 / math.factorial(k) for k in range(2, 13)
)

# atan(x)/x in powers of x² for x up to tan(π/8), by mpmath's chebyfit; to 1.3e-18.
_A0, _A1, _A2, _A3, _A4, _A5 = (
    *(1.0, -0.33333333333333121163, 0.19999999999940891408),
    *(-0.14285714279250239667, 0.11111110744919395758, -0.090908968090564377814),
)
_A6, _A7, _A8, _A9, _A10, _A11 = (
    *(0.076920453307659118451, -0.066629518120618369597, 0.058468782857870010961),
    *(-0.050351024039430294125, 0.037965256099576568431, -0.017805395704537507381),
)


@intrinsic
def _power_of_two(typing_context: Any, shifted: Any) -> Any:
    """Return 2ⁿ from n + _SHIFT, by moving the low bits into the exponent."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        integer = ir.IntType(64)
        bits = builder.bitcast(arguments[0], integer)
        bits = builder.add(builder.shl(bits, integer(52)), integer(1023 << 52))
        return builder.bitcast(bits, ir.DoubleType())

    return types.float64(types.float64), build


@inlined
def decay(y: float) -> tuple[float, float]:
    """Return e^(−y) and 1 − e^(−y), both to the last digit or two; y ≥ −700."""
    x = y if y < DEEPEST else DEEPEST
    shifted = _SHIFT - x * _LOG2_E
    n = shifted - _SHIFT
    r = (-x - n * _LN2_HIGH) - n * _LN2_LOW
    r2 = r * r
    low = (_C2 + r * _C3) + r2 * (_C4 + r * _C5)
    high = (
        (_C6 + r * _C7)
        + r2 * (_C8 + r * _C9)
        + (r2 * r2) * ((_C10 + r * _C11) + r2 * _C12)
    )
    p = r + r2 * (low + (r2 * r2) * high)  # e^r − 1
    scale = _power_of_two(shifted)
    power = scale * p + scale
    return (power if y < DEEPEST else 0.0), (1 - scale) - scale * p


@inlined
def angle(sine: float, cosine: float) -> float:
    """Return the angle from its sine ≥ 0 and its cosine, in any unit: 0 to π.

    To the last digit or two, also of small angles; 0 where both are 0.
    """
    across = cosine if cosine >= 0 else -cosine
    # The tangent of half the angle, and of half of that: at most tan(π/8).
    half = sine / (math.sqrt(sine * sine + across * across) + across + 1e-300)
    x = half / (1 + math.sqrt(1 + half * half))
    u = x * x
    v = u * u
    low = (_A0 + u * _A1) + v * ((_A2 + u * _A3) + v * (_A4 + u * _A5))
    high = (_A6 + u * _A7) + v * ((_A8 + u * _A9) + v * (_A10 + u * _A11))
    turn = 4 * x * (low + (v * v) * v * high)
    return turn if cosine >= 0 else math.pi - turn
