"""The lobes of all surface models at 40 digits, and their albedo over the hemisphere.

Lobes take the cosines as they are, in floats, and return the spread β D G/(N·V), the
argument of the exponential in it, and by how much its rounding is magnified.
"""

import numpy as np
from mpmath import mp, mpf

LEAST_NV = mpf("0.001")


def torrance_sparrow(seen, *, beta, gamma, masking):
    """Return Torrance–Sparrow's spread."""
    _, _, NH, SH, _ = seen
    power = mp.log(2) * (mp.atan2(SH, NH) / mpf(gamma)) ** 2
    return mpf(beta) * mp.exp(-power) * _masked(seen, masking), power, power


def cook_torrance(seen, *, specular_scale, roughness, masking):
    """Return π/4 D G/(N·V), D Beckmann's, of unit projected area."""
    _, _, NH, SH, _ = seen
    if NH <= 0:
        return mpf(0), mpf(0), mpf(0)
    m = mpf(roughness)
    power = (SH / (NH * m)) ** 2
    D = mp.exp(-power) / (mp.pi * m**2 * NH**4)
    return mpf(specular_scale) * mp.pi / 4 * D * _masked(seen, masking, m), power, power


def phong(seen, *, specular_scale, exponent):
    """Return π (N·L) times the BRDF (p + 2)/(2π) cos^p α, α from the mirror direction.

    1 − cos α is half the squared distance of V from the mirror direction R, R − V being
    2 ((N·L) N − (V·H) H).
    """
    NL, NV, _, SH, VH = seen
    drop = (NL - NV) ** 2 / 2 + 2 * (VH * SH) ** 2
    if drop >= 1:
        return mpf(0), mpf(0), mpf(0)
    p = mpf(exponent)
    power = -p * mp.log(1 - drop)
    return (
        mpf(specular_scale) * (p + 2) / 2 * mp.exp(-power) * NL,
        power,
        power + p / (1 - drop),
    )


def lambert(seen):
    """Return 0."""
    return mpf(0), mpf(0), mpf(0)


def spread(model, seen, **parameters):
    """Return a lobe at float cosines, its exponent and its magnification, in floats."""
    with mp.workdps(40):
        seen = [mpf(float(x)) for x in seen]
        if seen[0] <= 0:
            return 0.0, 0.0, 0.0
        return tuple(float(x) for x in model(seen, **parameters))


def _masked(seen, masking, m=None):
    """Return G/(N·V)."""
    NL, NV, NH, _, VH = seen
    nv = max(NV, LEAST_NV)
    if masking == "none":
        return 1 / nv
    if masking == "smith":
        return _walter(NL, m) * _walter(nv, m) / nv
    twice = 2 * max(NH, mpf(0))
    return min(mpf(1), twice * nv / VH, twice * NL / VH) / nv


def _walter(cosine, m):
    """Return G₁ as Walter et al. (2007) approximate it for Beckmann's facets."""
    if cosine >= 1:
        return mpf(1)
    a = cosine / (m * mp.sqrt(1 - cosine**2))
    if a >= mpf("1.6"):
        return mpf(1)
    return (mpf("3.535") * a + mpf("2.181") * a**2) / (
        1 + mpf("2.276") * a + mpf("2.577") * a**2
    )


def albedo(value, angle, n_polar=200, n_azimuth=120):
    """Return the share of light reflected from an angle of incidence.

    Integrated over the directions of leaving, in the squared sine of their angle: for
    lobes that are not narrow. ``value(N, L, V)`` is π f (N·L).
    """
    x, w = np.polynomial.legendre.leggauss(n_polar)
    square = (x + 1) / 2  # dω cos θ = d(sin² θ)/2 dφ
    sine, up = np.sqrt(square), np.sqrt(1 - square)
    turn = (np.arange(n_azimuth) + 0.5) * 2 * np.pi / n_azimuth
    V = np.stack(
        [
            np.outer(sine, np.cos(turn)),
            np.outer(sine, np.sin(turn)),
            np.outer(up, np.ones(n_azimuth)),
        ],
        axis=-1,
    )
    N = np.array([0.0, 0.0, 1.0])
    L = np.array([np.sin(angle), 0.0, np.cos(angle)])
    flux = value(N, L, V) * (w / 4)[:, None] * 2 * np.pi / n_azimuth
    return float(flux.sum() / (np.pi * np.cos(angle)))
