"""The paper's layer and stack, eqs (2), (3), (5) and (6), at hundreds of digits.

The form is the textbook's, which cancels and overflows in floats: more digits
than the 32 that K/S can take away on either side are the cure.
"""

import numpy as np
from mpmath import mp, mpf

DIGITS = 150  # K/S spans 1e±32 and enters squared; 60 and more remain
SLOPE_DIGITS = 400  # a difference over STEP loses 120 digits
NOISE = mpf("1e-270")  # of a difference of such digits over such a step
STEP = "1e-120"  # far below the 1e-48 at which K may bend R


def layer(K, S, D):
    """Return R and T of a layer over black."""
    K, S, D = mpf(K), mpf(S), mpf(D)
    if D == 0 or K == S == 0:
        return mpf(0), mpf(1)
    if mp.inf == D:
        # sinh and cosh grow alike: R = 1/(a + b), times S above and below.
        return S / (K + S + mp.sqrt(K * (K + 2 * S))), mpf(0)
    if S == 0:
        return mpf(0), mp.exp(-K * D)
    if K == 0:
        return S * D / (1 + S * D), 1 / (1 + S * D)
    a = (S + K) / S
    b = mp.sqrt(a * a - 1)
    sinh, cosh = mp.sinh(b * S * D), mp.cosh(b * S * D)
    return sinh / (a * sinh + b * cosh), b / (a * sinh + b * cosh)


def layer_by_two_fluxes(K, S, D):
    """Return R and T from eq. (2) itself, as a matrix exponential.

    (I, J)' = M (I, J) with I(0) = 1 from above and J(D) = 0 from below.
    """
    M = mp.matrix([[-(S + mpf(K)), S], [-S, S + mpf(K)]])
    through = mp.expm(M * D)
    R = -through[1, 0] / through[1, 1]
    return R, through[0, 0] + through[0, 1] * R


def printed_transmittance(K, S, D):
    """Return T as eq. (3) prints it, with b coth(bSD) for b cosh(bSD)."""
    a = (mpf(S) + K) / S
    b = mp.sqrt(a * a - 1)
    y = b * S * D
    return b / (a * mp.sinh(y) + b * mp.coth(y))


def over(top, reflectance):
    """Return the reflectance of a layer (R, T) on something that reflects."""
    R, T = top
    if T == 0:
        return R
    return R + T**2 * reflectance / (1 - R * reflectance)


def stack(K, S, D, backing):
    """Return R_b of two layers, (top, bottom) in each argument, over a backing."""
    top, bottom = (layer(*args) for args in zip(K, S, D, strict=True))
    return over(top, over(bottom, mpf(backing)))


def on_top(first, second):
    """Return R and T of two layers (R, T), each the same from both sides."""
    (R1, T1), (R2, T2) = first, second
    gap = 1 - R1 * R2
    return R1 + T1**2 * R2 / gap, T1 * T2 / gap


def slope(function, x):
    """Return d function/dx, from above, as it is at x = 0; 0 where it is noise."""
    with mp.workdps(SLOPE_DIGITS):
        step = mpf(STEP)
        here, there = function(mpf(x)), function(mpf(x) + step)
        change = (there - here) / step
        return change if abs(change) > NOISE * abs(here) else mpf(0)


def layers(K, S, D):
    """Return R, T, 1 − R and 1 − R − T of many layers, rounded to floats at last."""
    with mp.workdps(DIGITS):
        found = [layer(*args) for args in zip(K, S, D, strict=True)]
        # Without absorption 1 − R − T is 0; its digits are those that ran out.
        kept = [int(k != 0) for k in K]
        return np.array(
            [
                [float(x) for x in (R, T, 1 - R, (1 - R - T) * some)]
                for (R, T), some in zip(found, kept, strict=True)
            ]
        ).T


def layers_slopes(K, S, D):
    """Return ∂R/∂K and ∂T/∂K (2, m) of many layers."""
    points = zip(K, S, D, strict=True)
    return np.array(
        [
            [
                float(slope(lambda k, s=s, d=d, i=i: layer(k, s, d)[i], k))
                for i in (0, 1)
            ]
            for k, s, d in points
        ]
    ).T


def stacks_slopes(K, S, D, backing):
    """Return the slopes (3, 2, m) of R_b, by K, S and D of the top and the bottom."""

    def changed(arguments, which, layer_, x):
        own = [list(pair) for pair in arguments]
        own[which][layer_] = x
        return stack(*own, backing)

    found = np.zeros((3, 2, len(K[0])))
    for i in range(len(K[0])):
        arguments = [[float(pair[0][i]), float(pair[1][i])] for pair in (K, S, D)]
        for which in range(3):
            for layer_ in range(2):
                at = arguments[which][layer_]
                if at != np.inf:
                    found[which, layer_, i] = slope(
                        lambda x, a=arguments, w=which, q=layer_: changed(a, w, q, x),
                        at,
                    )
    return found
