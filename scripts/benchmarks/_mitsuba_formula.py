"""The two materials as formulas, written from the papers and not from either program.

All functions return π f cos θ_i: radiance over that of the perfect diffuser lit at
normal incidence, which is what PHYSICS.md section 7 calls Y/E. Vectors are unit
vectors away from the surface, (..., 3); one wavelength at a time.
"""

import numpy as np


def lambertian(N, L, reflectance):
    """Return the Lambertian surface's: its reflectance times N·L."""
    return reflectance * np.maximum(_dot(N, L), 0.0)


def half_and_half(N, L, V, *, reflectance, roughness, n):
    """Return half of a Lambertian surface's and half of a rough one's."""
    rough = beckmann_facets(N, L, V, roughness, n)
    return 0.5 * lambertian(N, L, reflectance) + 0.5 * rough


def beckmann_facets(N, L, V, roughness, n):
    """Return π F D G/(4 N·V): Cook and Torrance's BRDF times π N·L.

    D is Beckmann's, G Smith's for it in the rational form of Walter et al., Proc.
    EGSR 2007, eqs 20-27; F Fresnel's for unpolarised light. 0 unless both directions
    are on the normal's side.
    """
    H = L + V
    H = H / np.linalg.norm(H, axis=-1, keepdims=True)
    NL, NV, NH, VH = _dot(N, L), _dot(N, V), _dot(N, H), _dot(V, H)
    both = (NL > 0) & (NV > 0)
    NL, NV = np.where(both, NL, 1.0), np.where(both, NV, 1.0)
    tan2 = 1 / NH**2 - 1
    D = np.exp(-tan2 / roughness**2) / (np.pi * roughness**2 * NH**4)
    G = _smith(NL, roughness) * _smith(NV, roughness)
    return np.where(both, np.pi * _fresnel(VH, n) * D * G / (4 * NV), 0.0)


def _smith(cosine, roughness):
    """Return G1 of Walter et al., eq. 27."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a = cosine / (roughness * np.sqrt(np.maximum(1 - cosine**2, 0)))
        below = (3.535 * a + 2.181 * a**2) / (1 + 2.276 * a + 2.577 * a**2)
        return np.where(a < 1.6, below, 1.0)


def _fresnel(cosine, n):
    """Return the mean of the two polarisations' reflectances."""
    inside = np.sqrt(1 - (1 - cosine**2) / n**2)
    across = (cosine - n * inside) / (cosine + n * inside)
    along = (n * cosine - inside) / (n * cosine + inside)
    return (across**2 + along**2) / 2


def _dot(a, b):
    return (a * b).sum(axis=-1)
