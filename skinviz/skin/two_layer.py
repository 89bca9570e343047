"""The paper's model: two Kubelka–Munk layers over the hypodermis, three pigments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.coefficients import Coefficients
from skinviz.skin.kubelka_munk import layer_fluxes, stack_reflectance, stack_slopes
from skinviz.skin.model import SkinModel

Array = NDArray[np.float64]
Pair = tuple[Array, Array]


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

    def _body(self, values: Array, at: Coefficients) -> Array:
        """Return R_b (..., n), eq. (5)."""
        top, bottom = (
            layer_fluxes(k, s, np.asarray(depth, dtype=np.float64))
            for k, s, depth in zip(*_layers(values, at), self.thickness, strict=True)
        )
        return stack_reflectance(top, bottom, self.hypodermis)

    def _body_slopes(self, values: Array, at: Coefficients) -> tuple[Array, Array]:
        """Return R_b (m, n) and its derivatives (m, n, 3)."""
        body, by_top, by_bottom = stack_slopes(
            *_layers(values, at), self.thickness, self.hypodermis
        )
        slopes = (
            by_top * at.melanin,
            by_bottom * at.oxyhaemoglobin,
            by_bottom * at.deoxyhaemoglobin,
        )
        return body, np.stack(slopes, axis=-1)


def _layers(values: Array, at: Coefficients) -> tuple[Pair, Pair]:
    """Return (K_et, K_dt) and (S_e, S_d) of eq. (9)."""
    w_m, w_h, w_dh = (values[..., i, None] for i in range(3))
    epidermis = w_m * at.melanin
    dermis = w_h * at.oxyhaemoglobin + w_dh * at.deoxyhaemoglobin
    return (epidermis, dermis), (at.epidermis, at.dermis)
