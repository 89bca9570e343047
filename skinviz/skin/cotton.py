"""The paper's "previous method": an absorbing epidermis over a Kubelka–Munk dermis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._compile import compiled
from skinviz._vector_math import decay
from skinviz.skin.coefficients import Coefficients
from skinviz.skin.kernels import (
    BOTTOM,
    CARRY,
    absorbing,
    carried,
    depth,
    layer_of,
    over_backing,
    prepare,
    slopes_of,
    through_surface,
)
from skinviz.skin.kubelka_munk import LARGEST
from skinviz.skin.model import SkinModel

MELANIN, OXY, DEOXY, TISSUE, DERMIS = range(5)  # rows of the table


@compiled()
def evaluate(
    values: Any, table: Any, constants: Any, scratch: Any, measured: Any, jacobian: Any
) -> None:
    """Fill in the measured spectrum and its Jacobian."""
    w_m, w_h, w_dh = values
    D_e, D_d, hypodermis, offset, transmission, internal = constants
    for j in range(measured.size):
        blood = w_h * table[OXY, j] + w_dh * table[DEOXY, j]
        scratch[BOTTOM, j] = blood + table[TISSUE, j]
        scratch[BOTTOM + 1, j] = table[DERMIS, j]
        K = w_m * table[MELANIN, j]
        scratch[CARRY, j] = decay(depth(K, K, 0.0, D_e))[0]  # there and back
    prepare(scratch, BOTTOM, D_d)
    for j in range(measured.size):
        dermis = layer_of(scratch, BOTTOM, j)
        base, _, carry = over_backing(dermis, hypodermis)
        body = scratch[CARRY, j] * base
        measured[j], out = through_surface(body, offset, transmission, internal)
        v, factor = absorbing(scratch[BOTTOM + 2, j], scratch[BOTTOM + 3, j], carry)
        scratch[CARRY + 1, j] = out * body
        scratch[CARRY + 2, j] = v
        scratch[CARRY + 3, j] = out * scratch[CARRY, j] * factor
    if jacobian.shape[0] == 0:
        return
    for j in range(measured.size):
        jacobian[0, j] = -table[MELANIN, j] * min(D_e, LARGEST) * scratch[CARRY + 1, j]
        slopes = slopes_of(scratch, BOTTOM, D_d, j)
        by_K = carried(slopes, scratch[CARRY + 2, j], scratch[CARRY + 3, j])
        jacobian[1, j] = by_K * table[OXY, j]
        jacobian[2, j] = by_K * table[DEOXY, j]


@dataclass(frozen=True)
class Cotton(SkinModel):
    """Melanin by Bouguer's law over a dermis with blood and bloodless tissue.

    R_b = exp(−w_m K_m D_e) R_dt, the light crossing the epidermis twice with μ = K_m/2
    and no scattering there; K_d = w_h K_h + w_dh K_dh + 2 μ of bloodless tissue.

    Attributes as :class:`SkinModel`.

    References
    ----------
    .. [1] S. D. Cotton & E. Claridge, Proc. SPIE 2708:814 (1996).
    .. [2] Doi, Tanaka & Tominaga, J. Imaging Sci. Technol. 49:574 (2005), Table III.
    """

    name = "cotton"
    evaluate = staticmethod(evaluate)

    def _table(self, at: Coefficients) -> NDArray[np.float64]:
        """Return K of the pigments and of bloodless tissue, and S of the dermis."""
        tissue = 2 * bloodless_absorption(at.wavelengths)
        return np.stack(
            [at.melanin, at.oxyhaemoglobin, at.deoxyhaemoglobin, tissue, at.dermis]
        )


def bloodless_absorption(wavelengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return μ_a of skin without blood and melanin. [mm⁻¹]

    References
    ----------
    .. [1] S. L. Jacques, Skin optics summary, Oregon Medical Laser Center (1998), after
       I. S. Saidi: 0.244 + 85.3 exp(−(λ − 154)/66.2) cm⁻¹.
    """
    return 0.0244 + 8.53 * np.exp(-(wavelengths - 154.0) / 66.2)
