"""The paper's model, eqs (5)–(9), twice: in mpmath and, for speed, in plain floats."""

import numpy as np
from mpmath import mp, mpf

from oracles import fresnel
from oracles import kubelka_munk as km


def absorptions(weights, pigments):
    """Return K of epidermis and dermis, eq. (9); pigments are (K_m, K_h, K_dh)."""
    w_m, w_h, w_dh = (mpf(float(w)) for w in weights)
    K_m, K_h, K_dh = (mpf(float(k)) for k in pigments)
    return w_m * K_m, w_h * K_h + w_dh * K_dh


def reflectance(weights, pigments, S, D, hypodermis=1.0):
    """Return R_b at one wavelength."""
    return km.stack(absorptions(weights, pigments), S, D, hypodermis)


def saunderson(body, n="1.4"):
    """Return what a sphere with its specular port closed reads."""
    outside = fresnel.reflectance(1, mpf(n))
    inside = fresnel.diffuse(1 / mpf(n))
    return outside + (1 - outside) * (1 - inside) * body / (1 - inside * body)


def slope(i, weights, pigments, S, D):
    """Return ∂R_b/∂ weight i at one wavelength."""

    def changed(w):
        mixed = [*weights[:i], w, *weights[i + 1 :]]
        terms = [mpf(x) * mpf(k) for x, k in zip(mixed, pigments, strict=True)]
        return km.stack((terms[0], terms[1] + terms[2]), S, D, 1)

    return km.slope(changed, weights[i])


def plain(weights, table, D, interface):
    """Return the measured spectrum in floats, the equations as printed.

    weights (3,); table (5, n) is K_m, K_h, K_dh, S_e, S_d; interface is (offset,
    transmission, internal). Right only where pigment is neither absent nor opaque.
    """
    K = (weights[0] * table[0], weights[1] * table[1] + weights[2] * table[2])
    (R_e, T_e), (R_d, T_d) = (
        _layer(np.maximum(k, 1e-9), s, d)
        for k, s, d in zip(K, table[3:], D, strict=True)
    )
    R_dt = R_d + T_d**2 / (1 - R_d)
    body = R_e + T_e**2 * R_dt / (1 - R_e * R_dt)
    offset, transmission, internal = interface
    return offset + transmission * body / (1 - internal * body)


def _layer(K, S, D):
    """Return eq. (3) in floats, with its misprint mended."""
    a = (S + K) / S
    b = np.sqrt(a**2 - 1)
    sinh, cosh = np.sinh(b * S * D), np.cosh(b * S * D)
    bottom = a * sinh + b * cosh
    return sinh / bottom, b / bottom


def mp_digits():
    """Return the working precision for values; slopes set their own."""
    return mp.workdps(km.DIGITS)
