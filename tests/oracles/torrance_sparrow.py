"""Eq. (10)'s specular term to the letter, and its integrals by other rules."""

from itertools import pairwise

import numpy as np
from mpmath import mp, mpf
from scipy.integrate import quad

from oracles import fresnel


def evaluate(N, L, V, *, gamma, n, beta, masked):
    """Return β D F G/(N·V) for unit vectors lit and seen from above."""
    with mp.workdps(40):
        N, L, V = (mp.matrix([mpf(float(x)) for x in v]) for v in (N, L, V))
        N, L, V = (v / mp.norm(v) for v in (N, L, V))
        H = (L + V) / mp.norm(L + V)
        NL, NV, NH, VH = (_dot(*pair) for pair in ((N, L), (N, V), (N, H), (V, H)))
        angle = mp.atan2(mp.norm(_cross(N, H)), NH)
        D = mp.exp(-mp.log(2) * (angle / mpf(float(gamma))) ** 2)
        G = min(mpf(1), 2 * NH * NV / VH, 2 * NH * NL / VH) if masked else mpf(1)
        return float(mpf(float(beta)) * D * fresnel.reflectance(VH, n) * G / NV)


def physical_beta(gamma):
    """Return π/(4 ∫ D cos θ dω) over the hemisphere, by adaptive quadrature."""

    def integrand(theta):
        D = np.exp2(-((theta / gamma) ** 2))
        return D * np.cos(theta) * np.sin(theta)

    # D is below 1e-27 beyond; pieces of γ keep the rule from missing a narrow lobe.
    ends = np.minimum(gamma * np.array([0, 1, 2, 4, 9.5]), np.pi / 2)
    pieces = [
        quad(integrand, low, high, epsabs=0, epsrel=1e-12)[0]
        for low, high in pairwise(np.unique(ends))
    ]
    return np.pi / (4 * 2 * np.pi * sum(pieces))


def albedo(value, angle, gamma, n_polar=200, n_azimuth=120):
    """Return the share of light reflected from an angle of incidence.

    Integrated over halfway vectors, dω_V = 4 (V·H) dω_H, in units of γ, so that
    even the narrowest lobe is seen by all nodes. ``value(N, L, V)`` is π f (N·L).
    """
    N = np.array([0.0, 0.0, 1.0])
    L = np.array([np.sin(angle), 0.0, np.cos(angle)])
    end = min(np.pi / 2, 9 * gamma)
    x, w = np.polynomial.legendre.leggauss(n_polar)
    theta = (x + 1) / 2 * end
    azimuth = (np.arange(n_azimuth) + 0.5) * 2 * np.pi / n_azimuth
    H = np.stack(
        [
            np.outer(np.sin(theta), np.cos(azimuth)),
            np.outer(np.sin(theta), np.sin(azimuth)),
            np.outer(np.cos(theta), np.ones(n_azimuth)),
        ],
        axis=-1,
    )
    LH = H @ L
    V = 2 * LH[..., None] * H - L
    area = (w * end / 2 * np.sin(theta))[:, None] * 2 * np.pi / n_azimuth
    seen = (V[..., 2] > 0) & (LH > 0)
    flux = np.where(seen, value(N, L, V) * V[..., 2] * 4 * LH * area, 0.0)
    return float(flux.sum() / (np.pi * np.cos(angle)))


def _dot(a, b):
    """Return the scalar product."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def _cross(a, b):
    """Return the vector product."""
    return mp.matrix(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )
