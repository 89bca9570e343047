"""Fresnel's equations for s and p light by Snell's law, and their diffuse means."""

from mpmath import mp, mpf


def reflectance(cosine, n):
    """Return the unpolarised reflectance; n < 1 is light from the dense side."""
    cosine, n = mpf(cosine), mpf(n)
    under = 1 - (1 - cosine**2) / n**2
    if under <= 0:
        return mpf(1)
    refracted = mp.sqrt(under)
    s = (cosine - n * refracted) / (cosine + n * refracted)
    p = (n * cosine - refracted) / (n * cosine + refracted)
    return (s**2 + p**2) / 2


def diffuse(n):
    """Return the reflectance for diffuse light, 2 ∫ R(μ) μ dμ."""
    critical = mp.sqrt(1 - mpf(n) ** 2) if n < 1 else mpf(0)
    # μ² − critical² as the variable takes the root's infinite slope away.
    span = mp.sqrt(1 - critical**2)

    def integrand(u):
        return 2 * reflectance(mp.sqrt(u * u + critical**2), n) * u

    return critical**2 + mp.quad(integrand, mp.linspace(0, span, 5))
