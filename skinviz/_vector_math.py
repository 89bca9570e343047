"""Functions that numba calls once a number, in forms that a loop makes vectors of.

What belongs here is arithmetic without branches and without calls, accurate to the
last digit or two; what it is used for is the callers' physics.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from skinviz._compile import inlined

_LOG2_E = 1 / math.log(2)
_LN2_HIGH, _LN2_LOW = 0.693147180369123816490, 1.90821492927058770002e-10
_SHIFT = 1.5 * 2.0**52  # adding it leaves the nearest whole number in the low bits

DEEPEST = 708.39
"""e^−y beyond is below the smallest normal float: 0."""

C2, C3, C4, C5, C6, C7, C8, C9, C10, C11, C12 = (
    1 / math.factorial(k) for k in range(2, 13)
)

_PI, _HALF_PI, _QUARTER_PI = math.pi, math.pi / 2, math.pi / 4
_TAN_EIGHTH = math.sqrt(2) - 1  # tan(π/8)
_LEAST = 1e-300  # 0/0 is 0: the angle of no direction at all

# (arctan t − t)/t³ in powers of t², |t| ≤ tan(π/8): Chebyshev's fit, 5e-18 of t.
T0, T1, T2, T3, T4, T5, T6, T7, T8, T9, T10 = (
    *(-0.3333333333333333, 0.19999999999995516, -0.14285714284665682),
    *(0.11111111015187018, -0.0909090457530649, 0.07692183125376892),
    *(-0.06664510525508936, 0.05858140904866328, -0.050854078345894844),
    *(0.03923044778479309, -0.019175404711104935),
)

# (artanh t − t)/t³ in powers of t², |t| ≤ 0.1716: Chebyshev's fit, 5e-18 of t.
L0, L1, L2, L3, L4, L5, L6 = (
    *(0.3333333333333335, 0.19999999999949722, 0.14285714313001635),
    *(0.11111105565129939, 0.09091444727837474, 0.07665855309105386),
    *(0.07308292712444311,),
)
_SQRT2, _ROOT_HALF = math.sqrt(2), math.sqrt(0.5)
_SMALLEST_REST = 2.0**-53  # of 1 − x in floats, but 0
_WHOLE = 2.0**52  # a float whose low bits hold a whole number


@intrinsic
def _power_of_two(typing_context: Any, shifted: Any) -> Any:
    """Return 2ⁿ from n + _SHIFT, by moving the low bits into the exponent."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        integer = ir.IntType(64)
        bits = builder.bitcast(arguments[0], integer)
        bits = builder.add(builder.shl(bits, integer(52)), integer(1023 << 52))
        return builder.bitcast(bits, ir.DoubleType())

    return types.float64(types.float64), build


@intrinsic
def _exponent(typing_context: Any, x: Any) -> Any:
    """Return the exponent of a normal float > 0, plus 1023, plus _WHOLE."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        integer = ir.IntType(64)
        bits = builder.lshr(builder.bitcast(arguments[0], integer), integer(52))
        whole = builder.or_(bits, integer(0x4330000000000000))
        return builder.bitcast(whole, ir.DoubleType())

    return types.float64(types.float64), build


@intrinsic
def _mantissa(typing_context: Any, x: Any) -> Any:
    """Return a normal float > 0 divided by two to its exponent: 1 to 2."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        integer = ir.IntType(64)
        bits = builder.bitcast(arguments[0], integer)
        bits = builder.and_(bits, integer(0x000FFFFFFFFFFFFF))
        bits = builder.or_(bits, integer(0x3FF0000000000000))
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
    low = (C2 + r * C3) + r2 * (C4 + r * C5)
    high = (C6 + r * C7) + r2 * (C8 + r * C9) + (r2 * r2) * ((C10 + r * C11) + r2 * C12)
    p = r + r2 * (low + (r2 * r2) * high)  # e^r − 1
    scale = _power_of_two(shifted)
    power = scale * p + scale
    return (power if y < DEEPEST else 0.0), (1 - scale) - scale * p


@inlined
def angle(sine: float, cosine: float) -> float:
    """Return the angle in [0, π] whose sine, ≥ 0, and cosine have this ratio.

    To the last digit or two where it is small as well. The quotient is the tangent of
    what is beyond the nearest of 0, π/4, π/2, 3π/4 and π, at most π/8.
    """
    size = abs(cosine)
    small = sine if sine <= size else size
    large = size if sine <= size else sine
    middle = small > _TAN_EIGHTH * large
    over = small - large if middle else small
    under = small + large if middle else large
    t = over / (under + _LEAST)
    t2 = t * t
    t4 = t2 * t2
    t8 = t4 * t4
    low = (T0 + t2 * T1) + t4 * (T2 + t2 * T3)
    mid = (T4 + t2 * T5) + t4 * (T6 + t2 * T7)
    high = (T8 + t2 * T9) + t4 * T10
    beyond = t + t * t2 * (low + t8 * mid + (t8 * t8) * high)
    near = (_QUARTER_PI if middle else 0.0) + beyond  # from the nearer axis
    acute = near if sine <= size else _HALF_PI - near
    return acute if cosine >= 0 else _PI - acute


@inlined
def logarithm(x: float) -> float:
    """Return ln x of a normal float > 0 to the last digit or two, also near 1."""
    m, e = _mantissa(x), _exponent(x) - (_WHOLE + 1023)
    half = m > _SQRT2
    m = 0.5 * m if half else m
    e = e + 1 if half else e
    t = (m - 1) / (m + 1)
    t2 = t * t
    t4 = t2 * t2
    series = (L0 + t2 * L1) + t4 * ((L2 + t2 * L3) + t4 * ((L4 + t2 * L5) + t4 * L6))
    return e * _LN2_HIGH + (2 * (t + t * t2 * series) + e * _LN2_LOW)


@inlined
def loss_log(loss: float) -> float:
    """Return −ln(1 − loss) ≥ 0 to the last digit or two, also of small losses.

    ``loss`` ≥ 0; from 1 on the result is that of the nearest float below.
    """
    rest = 1 - loss
    rest = rest if rest > _SMALLEST_REST else _SMALLEST_REST
    m, e = _mantissa(rest), _exponent(rest) - (_WHOLE + 1023)
    half = m > _SQRT2
    m = 0.5 * m if half else m
    e = e + 1 if half else e
    near = rest > _ROOT_HALF  # then e is 0
    t = (-loss if near else m - 1) / (m + 1)
    t2 = t * t
    t4 = t2 * t2
    series = (L0 + t2 * L1) + t4 * ((L2 + t2 * L3) + t4 * ((L4 + t2 * L5) + t4 * L6))
    return -e * _LN2_HIGH - (2 * (t + t * t2 * series) + e * _LN2_LOW)
