"""The modified Lambert–Beer law: absorbance as a sum of pigments and a constant."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._compile import compiled
from skinviz._vector_math import decay
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import Coefficients
from skinviz.skin.kernels import through_surface
from skinviz.skin.model import PIGMENTS, Parameter, SkinModel

OFFSET = Parameter("offset", "1", 0.0, 50.0, "absorbance that no pigment explains")
"""What scattering loses in all bands alike, in natural logarithms."""

_USUAL_OFFSETS = (0.2, 0.5, 0.9)


@compiled()
def evaluate(
    values: Any, table: Any, constants: Any, scratch: Any, measured: Any, jacobian: Any
) -> None:
    """Fill in the measured spectrum and its Jacobian."""
    hypodermis, offset, transmission, internal = constants[2:]
    for j in range(measured.size):
        absorbance = values[3]
        for a in range(3):
            absorbance += values[a] * table[a, j]
        scratch[0, j] = hypodermis * decay(absorbance)[0]
    for j in range(measured.size):
        measured[j], out = through_surface(
            scratch[0, j], offset, transmission, internal
        )
        scratch[1, j] = -out * scratch[0, j]
    for a in range(jacobian.shape[0]):
        for j in range(measured.size):
            jacobian[a, j] = scratch[1, j] * (table[a, j] if a < 3 else 1.0)


@dataclass(frozen=True)
class LambertBeer(SkinModel):
    """−ln R_b = w_m K_m D_e + (w_h K_h + w_dh K_dh) D_d + offset.

    The light goes through each layer there and back with μ = K/2. Attributes as
    :class:`SkinModel`; the thicknesses must be finite. It is usually fitted to −ln R by
    linear least squares; here to R, as the other models, so that their errors compare.

    References
    ----------
    .. [1] J. B. Dawson et al., Phys. Med. Biol. 25:695 (1980).
    .. [2] N. Tsumura, H. Haneishi & Y. Miyake, J. Opt. Soc. Am. A 16:2169 (1999).
    """

    name = "lambert-beer"
    evaluate = staticmethod(evaluate)

    def __post_init__(self) -> None:
        """Refuse what :class:`SkinModel` does, and layers without end."""
        super().__post_init__()
        if not np.isfinite(self.thickness).all():
            raise ArgumentError(
                "the lambert-beer model needs finite thicknesses: its absorbance grows "
                f"with them; got {self.thickness}"
            )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The pigments and the constant."""
        return (*PIGMENTS, OFFSET)

    @cached_property
    def starts(self) -> NDArray[np.float64]:
        """The pigments' starts, with several constants."""
        every = product(super().starts[::3], _USUAL_OFFSETS)
        return np.array([(*pigments, offset) for pigments, offset in every])

    def _table(self, at: Coefficients) -> NDArray[np.float64]:
        """Return what a unit of each pigment absorbs there and back (3, n)."""
        epidermis, dermis = self.thickness
        return np.stack(
            [
                at.melanin * epidermis,
                at.oxyhaemoglobin * dermis,
                at.deoxyhaemoglobin * dermis,
            ]
        )
