"""How much of the facets is hidden: G/(N·V) as plain array functions, for plots.

The compiled lobes hold the same formulas; tests compare them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SMALLEST_COSINE = 1e-3
"""N·V to which a normal that faces away from the viewer is bent."""

_LEAST_FACING = 1e-12  # light from exactly behind the viewer's back has no H


def unmasked(cosines: Array) -> Array:
    """Return 1/(N·V) of ``cosines`` (5, ...): nothing is hidden."""
    NL, NV, _, _, _ = cosines
    return np.where(NL > 0, 1 / np.maximum(NV, SMALLEST_COSINE), 0.0)


def v_cavity(cosines: Array) -> Array:
    """Return G/(N·V) of facets in pairs, symmetric grooves [1]_.

    References
    ----------
    .. [1] K. E. Torrance and E. M. Sparrow, J. Opt. Soc. Am. 57:1105 (1967).
    """
    NL, NV, NH, _, VH = cosines
    nv = np.maximum(NV, SMALLEST_COSINE)
    across = 2 * np.maximum(NH, 0.0) / np.maximum(VH, _LEAST_FACING)
    hidden = np.minimum(np.minimum(1 / nv, across), across * NL / nv)
    return np.where(NL > 0, hidden, 0.0)


def smith(cosines: Array, slope: float) -> Array:
    """Return G₁(L) G₁(V)/(N·V) of Beckmann's facets of rms slope m/√2 [1]_.

    In Walter's rational approximation [2]_, 0.35 % at most from Smith's integral.

    References
    ----------
    .. [1] B. G. Smith, IEEE Trans. Antennas Propag. 15:668 (1967).
    .. [2] Walter, Marschner, Li & Torrance, Eurographics Symposium on Rendering
       (2007), section 5.2.
    """
    NL, NV, _, _, _ = cosines
    nv = np.maximum(NV, SMALLEST_COSINE)
    seen = _seen(np.maximum(NL, 0.0), slope) * _seen(nv, slope) / nv
    return np.where(NL > 0, seen, 0.0)


def _seen(cosine: Array, slope: float) -> Array:
    """Return G₁: the share of facets that are seen from a direction."""
    sine = np.sqrt(np.maximum(1 - cosine * cosine, 0.0))
    a = np.full(np.shape(cosine), 1.6)
    np.divide(cosine, slope * sine, out=a, where=cosine < 1.6 * slope * sine)
    return np.where(a < 1.6, a * (3.535 + 2.181 * a) / (1 + a * (2.276 + 2.577 * a)), 1)
