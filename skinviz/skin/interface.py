"""What the surface adds to a measurement: from body reflectance to what was seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.spectra.measurement import EXCLUDED, INCLUDED, as_specular

Array = NDArray[np.float64]

SKIN_INDEX = 1.4
"""Refractive index of skin against air."""


@dataclass(frozen=True)
class Interface:
    """The surface between air and skin, as one measurement geometry sees it.

    measured = offset + transmission · R_b / (1 − internal · R_b)

    Attributes
    ----------
    offset : float
        Surface reflection that the measurement includes. [1]
    transmission : float
        Light let in times light let out. [1]
    internal : float
        Share of the emerging light turned back inside. [1]
    """

    offset: float
    transmission: float
    internal: float

    def diffuse(self, reflectance: Array) -> Array:
        """Return the part that has been inside the skin. [1]"""
        return self.transmission * reflectance / (1 - self.internal * reflectance)

    def measured(self, reflectance: Array) -> Array:
        """Return what the instrument reads for a body reflectance. [1]"""
        return self.offset + self.diffuse(reflectance)

    def slope(self, reflectance: Array) -> Array:
        """Return d measured / d R_b. [1]"""
        return self.transmission / (1 - self.internal * reflectance) ** 2


BARE = Interface(0.0, 1.0, 0.0)
"""No surface: what is measured is R_b."""


def interface(specular: str | float) -> Interface:
    """Return the interface for how the surface reflection was measured.

    Parameters
    ----------
    specular : {"excluded", "included"} or float
        ``"excluded"``: 45/0 and the like, measured = R_b. ``"included"``: a sphere
        with its specular port closed, Saunderson's form [1]_ with n = 1.4. A
        number: a constant surface reflection added to R_b.

    Returns
    -------
    interface : Interface
        The three numbers of the form above.

    Raises
    ------
    ArgumentError
        If it is another word, or a number outside [0, 0.5].

    References
    ----------
    .. [1] J. L. Saunderson, J. Opt. Soc. Am. 32:727 (1942).
    """
    how = as_specular(specular)
    if how == EXCLUDED:
        return BARE
    if how == INCLUDED:
        outside = ((SKIN_INDEX - 1) / (SKIN_INDEX + 1)) ** 2
        inside = diffuse_internal_reflectance(SKIN_INDEX)
        return Interface(outside, (1 - outside) * (1 - inside), inside)
    return Interface(float(how), 1.0, 0.0)


def diffuse_internal_reflectance(n: float) -> float:
    """Return the Fresnel reflectance for diffuse light from inside, index n > 1.

    From Walsh's closed form for diffuse light from outside and the exchange
    relation 1 − R_in = (1 − R_out)/n² [1]_.

    References
    ----------
    .. [1] S. Q. Duntley, J. Opt. Soc. Am. 32:61 (1942).
    """
    a, b = n * n - 1, n * n + 1
    outside = (
        0.5
        + (n - 1) * (3 * n + 1) / (6 * (n + 1) ** 2)
        + n**2 * a**2 / b**3 * np.log((n - 1) / (n + 1))
        - 2 * n**3 * (n**2 + 2 * n - 1) / (b * (n**4 - 1))
        + 8 * n**4 * (n**4 + 1) / (b * (n**4 - 1) ** 2) * np.log(n)
    )
    return float(1 - (1 - outside) / n**2)
