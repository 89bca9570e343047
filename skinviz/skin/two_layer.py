"""The paper's model: two Kubelka–Munk layers over the hypodermis, three pigments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._compile import compiled
from skinviz.skin.kernels import (
    BOTTOM,
    CARRY,
    TOP,
    absorbing,
    carried,
    layer_of,
    prepare,
    slopes_of,
    stack,
    through_surface,
)
from skinviz.skin.kubelka_munk import kubelka_munk_layer
from skinviz.skin.model import SkinModel

Array = NDArray[np.float64]

MELANIN, OXY, DEOXY, EPIDERMIS, DERMIS = range(5)  # rows of the table


@compiled()
def evaluate(
    values: Any, table: Any, constants: Any, scratch: Any, measured: Any, jacobian: Any
) -> None:
    """Fill in the measured spectrum and its Jacobian, eqs (5)–(9)."""
    w_m, w_h, w_dh = values
    D_e, D_d, hypodermis, offset, transmission, internal = constants
    for j in range(measured.size):
        scratch[TOP, j] = w_m * table[MELANIN, j]
        scratch[TOP + 1, j] = table[EPIDERMIS, j]
        scratch[BOTTOM, j] = w_h * table[OXY, j] + w_dh * table[DEOXY, j]
        scratch[BOTTOM + 1, j] = table[DERMIS, j]
    prepare(scratch, TOP, D_e)
    prepare(scratch, BOTTOM, D_d)
    if jacobian.shape[0] == 0:
        for j in range(measured.size):
            top, bottom = layer_of(scratch, TOP, j), layer_of(scratch, BOTTOM, j)
            body = stack(top, bottom, hypodermis)[0]
            measured[j] = through_surface(body, offset, transmission, internal)[0]
        return
    for j in range(measured.size):
        top, bottom = layer_of(scratch, TOP, j), layer_of(scratch, BOTTOM, j)
        body, carry_e, carry_d = stack(top, bottom, hypodermis)
        measured[j], out = through_surface(body, offset, transmission, internal)
        v, factor = absorbing(scratch[TOP + 2, j], scratch[TOP + 3, j], carry_e)
        scratch[CARRY, j], scratch[CARRY + 1, j] = v, out * factor
        v, factor = absorbing(scratch[BOTTOM + 2, j], scratch[BOTTOM + 3, j], carry_d)
        scratch[CARRY + 2, j], scratch[CARRY + 3, j] = v, out * factor
    for j in range(measured.size):
        slopes = slopes_of(scratch, TOP, D_e, j)
        by_K = carried(slopes, scratch[CARRY, j], scratch[CARRY + 1, j])
        jacobian[0, j] = by_K * table[MELANIN, j]
    for j in range(measured.size):
        slopes = slopes_of(scratch, BOTTOM, D_d, j)
        by_K = carried(slopes, scratch[CARRY + 2, j], scratch[CARRY + 3, j])
        jacobian[1, j] = by_K * table[OXY, j]
        jacobian[2, j] = by_K * table[DEOXY, j]


@dataclass(frozen=True)
class TwoLayer(SkinModel):
    """Epidermis with melanin over dermis with blood over a white hypodermis.

    Attributes as :class:`SkinModel`.

    References
    ----------
    .. [1] Doi, Tanaka & Tominaga, J. Imaging Sci. Technol. 49:574 (2005),
       eqs (5)–(9).
    """

    name = "two-layer"
    evaluate = staticmethod(evaluate)

    def layers(self, values: ArrayLike, wavelengths: ArrayLike) -> tuple[Array, Array]:
        """Return R_e of the epidermis alone, and R_d of the dermis on the hypodermis.

        Parameters and errors as :meth:`reflectance`; returns (..., n) each. [1]
        """
        at = self.coefficients.at(wavelengths)
        w_m, w_h, w_dh = np.moveaxis(self.checked(values)[..., None], -2, 0)
        R_e, _ = kubelka_munk_layer(w_m * at.melanin, at.epidermis, self.thickness[0])
        blood = w_h * at.oxyhaemoglobin + w_dh * at.deoxyhaemoglobin
        R, T = kubelka_munk_layer(blood, at.dermis, self.thickness[1])
        return R_e, R + T**2 * self.hypodermis / (1 - R * self.hypodermis)
