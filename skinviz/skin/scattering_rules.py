"""Rules that turn transport coefficients into Kubelka–Munk's, by author.

Tissue tables hold what radiative transport knows: absorption μ_a, scattering μ_s and
the mean cosine g of one scattering, of which only μ_s′ = μ_s (1 − g) matters to
diffuse light. Kubelka–Munk has K and S, which are no properties of matter: they also
depend on how the light is spread over directions, and each rule below assumes another
spread. None is right everywhere; how far each is off in skin is measured in
``docs/transport.md``.

Here are only rules for diffuse light whose formula follows from its stated assumption,
which the tests repeat. Empirical rules for collimated light are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]


_LN2 = np.log(2.0)
_WEAK = 1e-15  # below it Klier's rule is its own limit within rounding
_NEAR = 0.2  # below it y coth y − 1 cancels and the series is exact
_SERIES = (-1382 / 638512875, 2 / 93555, -1 / 4725, 2 / 945, -1 / 45, 1 / 3)
_SLOPES = tuple(2 * n * c for n, c in zip(range(6, 0, -1), _SERIES, strict=True))
"""y coth y − 1 and its derivative, in powers of y², highest first."""


class KubelkaMunk(NamedTuple):
    """Kubelka–Munk's coefficients of a medium, of one shape.

    Attributes
    ----------
    K, S : ndarray
        Absorption and back-scattering. [mm⁻¹]
    """

    K: Array
    S: Array


def gate(mu_a: ArrayLike, mu_s_prime: ArrayLike) -> KubelkaMunk:
    """Diffusion theory where scattering dominates: K = 2 μ_a, S = ¾ μ_s′.

    The rule of the shipped ``"textbook"`` coefficients, and the commonest. Derived
    for μ_a much less than μ_s′; defined everywhere.

    Parameters
    ----------
    mu_a : array_like
        Absorption coefficient. [mm⁻¹], ≥ 0
    mu_s_prime : array_like
        Reduced scattering coefficient; broadcasts with ``mu_a``. [mm⁻¹], ≥ 0

    Returns
    -------
    K, S : ndarray of float64
        [mm⁻¹]

    Raises
    ------
    ArgumentError
        If a coefficient is negative or not finite, or the shapes do not broadcast.

    References
    ----------
    .. [1] L. F. Gate, Appl. Opt. 13:236 (1974).
    .. [2] S. N. Thennadil, J. Opt. Soc. Am. A 25:1480 (2008), who finds the same for
       diffuse incidence.

    Examples
    --------
    >>> K, S = gate(0.1, 4.0)
    >>> float(K), float(S)
    (0.2, 3.0)
    """
    a, s = _coefficients(mu_a, mu_s_prime)
    return KubelkaMunk(2 * a, 0.75 * s)


def star(mu_a: ArrayLike, mu_s_prime: ArrayLike) -> KubelkaMunk:
    """Diffusion theory in full: K = 2 μ_a, S = ¾ μ_s′ − ¼ μ_a.

    With it Kubelka–Munk *is* the diffusion approximation with Marshak's boundary:
    radiance linear in the cosine. Also Eddington's two-stream scheme [2]_.

    Parameters as :func:`gate`; returns (K, S). [mm⁻¹]

    Raises
    ------
    ArgumentError
        As :func:`gate`; and if μ_a > 3 μ_s′ somewhere, where S would be negative.

    References
    ----------
    .. [1] W. M. Star, J. P. A. Marijnissen and M. J. C. van Gemert, Phys. Med. Biol.
       33:437 (1988).
    .. [2] W. E. Meador and W. R. Weaver, J. Atmos. Sci. 37:630 (1980), Table 1.
    """
    a, s = _coefficients(mu_a, mu_s_prime)
    outside = a > 3 * s
    if outside.any():
        first = tuple(int(i) for i in np.argwhere(outside)[0])
        raise ArgumentError(
            f"Star's rule needs mu_a ≤ 3 mu_s_prime, or S is negative; at {first} "
            f"mu_a is {a[first]:g} and mu_s_prime {s[first]:g}; use another rule"
        )
    return KubelkaMunk(2 * a, 0.75 * s - 0.25 * a)


def meador_weaver(mu_a: ArrayLike, mu_s_prime: ArrayLike) -> KubelkaMunk:
    """Two streams at the cosine 1/√3: K = √3 μ_a, S = (√3/2) μ_s′.

    The quadrature scheme, first of the discrete ordinates: light that runs closer to
    the normal than a diffuse flux does. Defined everywhere.

    Parameters and errors as :func:`gate`; returns (K, S). [mm⁻¹]

    References
    ----------
    .. [1] W. E. Meador and W. R. Weaver, J. Atmos. Sci. 37:630 (1980), Table 1.
    """
    a, s = _coefficients(mu_a, mu_s_prime)
    return KubelkaMunk(np.sqrt(3.0) * a, np.sqrt(0.75) * s)


def toon(mu_a: ArrayLike, mu_s_prime: ArrayLike) -> KubelkaMunk:
    """Radiance constant over each hemisphere: K = 2 μ_a, S = μ_s′.

    The hemispheric mean scheme: exact for a thin layer in diffuse light, too much
    back-scattering in a thick one. Defined everywhere.

    Parameters and errors as :func:`gate`; returns (K, S). [mm⁻¹]

    References
    ----------
    .. [1] O. B. Toon, C. P. McKay, T. P. Ackerman and K. Santhanam, J. Geophys. Res.
       94:16287 (1989), Table 1.
    """
    a, s = _coefficients(mu_a, mu_s_prime)
    return KubelkaMunk(2 * a, np.array(s))


def klier(mu_a: ArrayLike, mu_s_prime: ArrayLike) -> KubelkaMunk:
    """Kubelka–Munk made to agree with transport deep inside a thick medium.

    Both the attenuation and the ratio of the two fluxes are those of the asymptotic
    radiance 1/(1 − kν) of isotropic scattering; μ_s′ stands for its coefficient
    (similarity). Little absorption gives :func:`gate`; without scattering K = μ_a.
    Wrong near surfaces and in layers too thin for the asymptotic spread.

    Parameters and errors as :func:`gate`; returns (K, S). [mm⁻¹]

    Notes
    -----
    With x = μ_a/μ_s′, μ_t′ = μ_a + μ_s′ and k = tanh y, the dispersion relation is
    y coth y − 1 = x. The fluxes F₊ = −k − ln(1 − k) and F₋ = k − ln(1 + k) have the
    difference 2kx and the sum 2 ln cosh y, whence K = μ_t′ k² x/ln cosh y and
    S = μ_t′ F₊F₋/(2x ln cosh y).

    References
    ----------
    .. [1] K. Klier, J. Opt. Soc. Am. 62:882 (1972).
    """
    a, s = _coefficients(mu_a, mu_s_prime)
    between = (a > 0) & (a > _WEAK * s) & (a * _WEAK < s)
    x = np.divide(a, s, out=np.ones_like(a), where=between)
    y = _dispersion(x)
    k, small = np.tanh(y), y < 1
    log_cosh = y - _LN2 + np.log1p(np.exp(-2 * y))
    mean = np.where(small, np.log1p(np.sinh(np.minimum(y, 1)) ** 2) / 2, log_cosh)
    # F₋/2: either form would cancel where the other is used.
    backward = np.where(small, mean - k * x, k - _LN2 + np.log1p(np.exp(-2 * y)))
    K = k * k * (x / mean)
    S = backward / x * (mean + k * x) / (2 * mean)
    little = a <= _WEAK * s
    return KubelkaMunk(
        np.where(between, (a + s) * K, np.where(little, 2 * a, a)),
        np.where(between, (a + s) * S, np.where(little, 0.75, 1 - _LN2) * s),
    )


SCATTERING_RULES: Mapping[str, Callable[[ArrayLike, ArrayLike], KubelkaMunk]] = (
    MappingProxyType(
        {rule.__name__: rule for rule in (gate, star, klier, meador_weaver, toon)}
    )
)
"""The rules by name, each a function of ``mu_a`` and ``mu_s_prime``."""


def _dispersion(x: Array) -> Array:
    """Return y > 0 with y coth y − 1 = x > 0, by Newton's rule from above."""
    y = np.sqrt(x) * np.sqrt(3 + x)
    for _ in range(8):  # convex and rising: it falls to the root and stays there
        low, high = np.minimum(y, _NEAR), np.maximum(y, _NEAR)
        decay, gap = np.exp(-2 * high), -np.expm1(-2 * high)
        coth, csch2 = (1 + decay) / gap, 4 * decay / gap**2
        near = y < _NEAR
        value = np.where(near, low**2 * np.polyval(_SERIES, low**2), high * coth - 1)
        slope = np.where(near, low * np.polyval(_SLOPES, low**2), coth - high * csch2)
        y = y - (value - x) / slope
    return np.asarray(y)


def _coefficients(mu_a: ArrayLike, mu_s_prime: ArrayLike) -> tuple[Array, Array]:
    """Return both coefficients, checked and broadcast."""
    arrays = as_numbers(mu_a, "mu_a"), as_numbers(mu_s_prime, "mu_s_prime")
    for array, name in zip(arrays, ("mu_a", "mu_s_prime"), strict=True):
        bad = ~(np.isfinite(array) & (array >= 0))
        if bad.any():
            raise ArgumentError(
                f"{name} must be finite and ≥ 0 mm⁻¹; got {array[bad].ravel()[0]:g}"
            )
    try:
        a, s = np.broadcast_arrays(*arrays)
    except ValueError as error:
        raise ArgumentError(
            f"mu_a {arrays[0].shape} and mu_s_prime {arrays[1].shape} do not broadcast "
            "together"
        ) from error
    return a, s
