"""ΔE00 step by step as Sharma, Wu & Dalal (2005) print it, in mpmath, in degrees."""

from mpmath import mp, mpf

DIGITS = 50
ROUND = mpf("1e-40")  # hues exactly opposite differ from 180° by less than this


def _hue(a, b):
    """Return the hue in [0, 360), 0 for grey."""
    return mp.degrees(mp.atan2(b, a)) % 360 if a or b else mpf(0)


def _root(chroma):
    """Return √(C⁷/(C⁷ + 25⁷))."""
    return mp.sqrt(chroma**7 / (chroma**7 + mpf(25) ** 7))


def _hue_difference_and_mean(h1, h2):
    """Return h₂ − h₁ and the mean hue, eqs (10) and (14) for colours not grey."""
    apart, total = h2 - h1, h1 + h2
    if abs(apart) <= 180 + ROUND:
        return apart, total / 2
    apart += -360 if apart > 0 else 360
    return apart, (total + (360 if total < 360 else -360)) / 2


def delta_e_2000(lab, other):
    """Return the difference of two colours (L*, a*, b*)."""
    with mp.workdps(DIGITS):
        (L1, a1, b1), (L2, a2, b2) = ([mpf(float(x)) for x in c] for c in (lab, other))
        mean_chroma = (mp.hypot(a1, b1) + mp.hypot(a2, b2)) / 2
        stretch = 1 + (1 - _root(mean_chroma)) / 2
        a1, a2 = stretch * a1, stretch * a2
        C1, C2 = mp.hypot(a1, b1), mp.hypot(a2, b2)
        h1, h2 = _hue(a1, b1), _hue(a2, b2)
        if C1 * C2 == 0:
            apart, h = mpf(0), h1 + h2
        else:
            apart, h = _hue_difference_and_mean(h1, h2)
        dL, dC = L2 - L1, C2 - C1
        dH = 2 * mp.sqrt(C1 * C2) * mp.sin(mp.radians(apart / 2))
        L, C = (L1 + L2) / 2, (C1 + C2) / 2

        def cos(degrees):
            return mp.cos(mp.radians(degrees))

        T = (
            1
            - mpf("0.17") * cos(h - 30)
            + mpf("0.24") * cos(2 * h)
            + mpf("0.32") * cos(3 * h + 6)
            - mpf("0.20") * cos(4 * h - 63)
        )
        S_L = 1 + mpf("0.015") * (L - 50) ** 2 / mp.sqrt(20 + (L - 50) ** 2)
        S_C, S_H = 1 + mpf("0.045") * C, 1 + mpf("0.015") * C * T
        turn = 30 * mp.exp(-(((h - 275) / 25) ** 2))
        R_T = -2 * _root(C) * mp.sin(mp.radians(2 * turn))
        x, y, z = dL / S_L, dC / S_C, dH / S_H
        return float(mp.sqrt(x * x + y * y + z * z + R_T * y * z))
