"""The two layers with more left free: scattering, melanin's slope, the surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._compile import compiled, inlined
from skinviz._validate import one_of
from skinviz._vector_math import decay
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import Coefficients
from skinviz.skin.interface import Interface
from skinviz.skin.kernels import (
    BOTTOM,
    CARRY,
    TOP,
    by_absorption,
    by_scattering,
    by_thickness,
    depth,
    layer_of,
    prepare,
    stack,
    through_surface,
)
from skinviz.skin.kubelka_munk import LARGEST
from skinviz.skin.model import PIGMENTS, Parameter, SkinModel

EXTRAS = (
    Parameter(
        *("scattering", "1", 0.2, 5.0, "factor of the scattering of both layers"),
        *(1.0, 0.3),
    ),
    Parameter(
        *("melanin_slope", "1", -2.0, 4.0, "added to the exponent of melanin's fall"),
        *(0.0, 0.75),
    ),
    Parameter(
        *("surface", "1", -0.02, 0.05, "added to the surface reflection"), *(0.0, 0.01)
    ),
    Parameter(
        *("epidermis", "1", 0.3, 3.0, "factor of the epidermis' thickness"), *(1.0, 0.3)
    ),
)
"""What may be free besides the pigments: unit, bounds, meaning, prior.

The deviations are the literature's spread: of reduced scattering between authors and
methods (0.29 in the logarithm), of melanin's exponent (3 to 4.75), of epidermal
thickness between people and methods; that of the surface is a sphere's calibration.
"""

FREE = ("scattering", "melanin_slope", "surface")
"""What is free unless said otherwise."""

MELANIN, OXY, DEOXY, EPIDERMIS, DERMIS, LOG_WAVELENGTH = range(6)  # rows of the table
_PLACES = 6  # the first constant that says where in the values an extra is, 0 if not
FALL, BY_TOP, BY_BOTTOM, BY_EXTRAS = range(CARRY, CARRY + 4)  # the last are four rows


@compiled()
def evaluate(
    values: Any, table: Any, constants: Any, scratch: Any, measured: Any, jacobian: Any
) -> None:
    """Fill in the measured spectrum and its Jacobian."""
    D_e, D_d, hypodermis, offset, transmission, internal = constants[:_PLACES]
    offset += _extra(values, constants, 2, 0.0)
    D_e *= _extra(values, constants, 3, 1.0)
    _fill(values, table, constants, scratch)
    prepare(scratch, TOP, D_e)
    prepare(scratch, BOTTOM, D_d)
    if jacobian.shape[0] == 0:
        for j in range(measured.size):
            top, bottom = layer_of(scratch, TOP, j), layer_of(scratch, BOTTOM, j)
            body = stack(top, bottom, hypodermis)[0]
            measured[j] = through_surface(body, offset, transmission, internal)[0]
        return
    _slopes(table, constants, D_e, offset, scratch, measured)
    for j in range(measured.size):
        jacobian[0, j] = scratch[BY_TOP, j] * table[MELANIN, j] * scratch[FALL, j]
        jacobian[1, j] = scratch[BY_BOTTOM, j] * table[OXY, j]
        jacobian[2, j] = scratch[BY_BOTTOM, j] * table[DEOXY, j]
    for k in range(4):
        place = int(constants[_PLACES + k])
        if place > 0:
            for j in range(measured.size):
                jacobian[place, j] = scratch[BY_EXTRAS + k, j]


@inlined
def _fill(values: Any, table: Any, constants: Any, scratch: Any) -> None:
    """Fill in K and S of both layers, and melanin's further fall."""
    scattering = _extra(values, constants, 0, 1.0)
    slope = _extra(values, constants, 1, 0.0)
    for j in range(table.shape[1]):
        scratch[FALL, j] = decay(slope * table[LOG_WAVELENGTH, j])[0]
    for j in range(table.shape[1]):
        scratch[TOP, j] = values[0] * table[MELANIN, j] * scratch[FALL, j]
        scratch[TOP + 1, j] = scattering * table[EPIDERMIS, j]
    for j in range(table.shape[1]):
        scratch[BOTTOM, j] = values[1] * table[OXY, j] + values[2] * table[DEOXY, j]
        scratch[BOTTOM + 1, j] = scattering * table[DERMIS, j]


@inlined
def _extra(values: Any, constants: Any, k: int, usual: float) -> float:
    """Return an extra parameter, or what it usually is where it is not free."""
    place = int(constants[_PLACES + k])
    return values[place] if place > 0 else usual


@inlined
def _slopes(
    table: Any, constants: Any, D_e: float, offset: float, scratch: Any, measured: Any
) -> None:
    """Fill in what is measured, and its slopes by each layer's K and by each extra."""
    D_d, hypodermis, _, transmission, internal = constants[1:_PLACES]
    for j in range(measured.size):
        top, bottom = layer_of(scratch, TOP, j), layer_of(scratch, BOTTOM, j)
        body, carry_e, carry_d = stack(top, bottom, hypodermis)
        measured[j], out = through_surface(body, offset, transmission, internal)
        K, S, kappa = scratch[TOP, j], scratch[TOP + 1, j], scratch[TOP + 2, j]
        E, m = scratch[TOP + 3, j], scratch[TOP + 4, j]
        y = depth(kappa, K, S, D_e)
        by_K = out * by_absorption(K, S, kappa, y, E, m, carry_e)
        by_S = by_scattering(K, S, kappa, y, E, m, carry_e) * table[EPIDERMIS, j]
        by_D = out * by_thickness(K, S, kappa, E, carry_e)
        scratch[BY_TOP, j] = by_K
        scratch[BY_EXTRAS + 1, j] = -by_K * K * table[LOG_WAVELENGTH, j]
        scratch[BY_EXTRAS + 2, j] = 1.0
        scratch[BY_EXTRAS + 3, j] = by_D * min(constants[0], LARGEST)
        K, S, kappa = scratch[BOTTOM, j], scratch[BOTTOM + 1, j], scratch[BOTTOM + 2, j]
        E, m = scratch[BOTTOM + 3, j], scratch[BOTTOM + 4, j]
        y = depth(kappa, K, S, D_d)
        scratch[BY_BOTTOM, j] = out * by_absorption(K, S, kappa, y, E, m, carry_d)
        by_S += by_scattering(K, S, kappa, y, E, m, carry_d) * table[DERMIS, j]
        scratch[BY_EXTRAS, j] = out * by_S


@dataclass(frozen=True)
class Extended(SkinModel):
    """The paper's two layers with some of what it fixes left free, under priors.

    Attributes
    ----------
    free : tuple of str
        Names of :data:`EXTRAS`, each once. The others as :class:`SkinModel`.

    Notes
    -----
    ``epidermis`` and w_m trade for each other but for the little that the epidermis
    scatters: free, it adds to w_m's uncertainty what is not known of the thickness.
    """

    free: tuple[str, ...] = FREE

    name = "extended"
    evaluate = staticmethod(evaluate)

    def __post_init__(self) -> None:
        """Refuse what :class:`SkinModel` does, and names unknown or given twice."""
        super().__post_init__()
        names = [parameter.name for parameter in EXTRAS]
        free = tuple(one_of(name, names, "free parameter") for name in self.free)
        if len(set(free)) < len(free):
            raise ArgumentError(f"free parameters must be named once; got {free}")
        object.__setattr__(self, "free", free)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The pigments, then what is free."""
        extras = {parameter.name: parameter for parameter in EXTRAS}
        return (*PIGMENTS, *(extras[name] for name in self.free))

    @property
    def description(self) -> dict[str, Any]:
        """As every model's, with what is free."""
        return {**super().description, "free": list(self.free)}

    @cached_property
    def starts(self) -> NDArray[np.float64]:
        """The pigments' starts, the rest as expected."""
        pigments = super().starts
        rest = [p.expected for p in self.parameters[len(PIGMENTS) :]]
        return np.column_stack([pigments, np.tile(rest, (len(pigments), 1))])

    def _table(self, at: Coefficients) -> NDArray[np.float64]:
        """Return K of the pigments, S of the tissues and ln(λ/500 nm)."""
        return np.stack([*super()._table(at), np.log(at.wavelengths / 500.0)])

    def _constants(self, surface: Interface | None) -> tuple[float, ...]:
        """Return the usual numbers and where in the values each extra stands."""
        seen = [p.name for p in self.parameters]
        if surface is None:
            seen = [name if name != "surface" else "" for name in seen]
        places = (float(seen.index(p.name)) if p.name in seen else 0.0 for p in EXTRAS)
        return (*super()._constants(surface), *places)
