"""How two cells of a comparison differ, tested as their units suggest."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from skinviz.spectra.colorimetry import delta_e_2000
from skinviz.study.colour_error import difference_interval
from skinviz.study.comparison import Cell, ColourDifference, Contrast
from skinviz.study.quantities import Quantity, measured_lab
from skinviz.study.statistics import (
    Difference,
    difference_within,
    holm,
    paired_difference,
    unpaired_difference,
)

Array = NDArray[np.float64]


def contrasts_of(
    first: Cell, second: Cell, by: str, quantities: Sequence[Quantity]
) -> list[Contrast]:
    """Return how the quantities of two cells differ."""
    test = _test_of(first, second, by)
    return [
        Contrast(
            first.stratum,
            first.level,
            second.level,
            quantity,
            test(first.values[:, k], second.values[:, k]),
        )
        for k, quantity in enumerate(quantities)
    ]


def _test_of(
    first: Cell, second: Cell, by: str
) -> Callable[[Array, Array], Difference]:
    """Return how two cells' numbers are to be tested, as their units suggest."""
    if by == "subject":  # a repeat's number pairs nothing
        return unpaired_difference
    places = {unit: i for i, unit in enumerate(second.units)}
    both = [(i, places[u]) for i, u in enumerate(first.units) if u in places]
    if 2 * len(both) >= min(len(first.units), len(second.units)):
        one, two = np.array(both).T
        return lambda a, b: paired_difference(a[one], b[two])
    one = np.array([i for i, u in enumerate(first.units) if u not in places])
    shared = {j for _, j in both}
    two = np.array([j for j in range(len(second.units)) if j not in shared])
    origins = np.array(first.origins)[one], np.array(second.origins)[two]
    if np.unique(np.concatenate(origins)).size == 1:
        return lambda a, b: unpaired_difference(a[one], b[two])
    return lambda a, b: difference_within(a[one], b[two], *origins)


def corrected(contrasts: Sequence[Contrast]) -> tuple[Contrast, ...]:
    """Return contrasts with p-values corrected for all of them."""
    raw = [c.difference.p for c in contrasts]
    p = holm([np.nan if value is None else value for value in raw])
    return tuple(
        dataclasses.replace(c, p_holm=float(value) if np.isfinite(value) else None)
        for c, value in zip(contrasts, p, strict=True)
    )


def colour_difference(first: Cell, second: Cell) -> ColourDifference:
    """Return how far apart the colours of two cells' mean spectra are."""
    apart = delta_e_2000(measured_lab(first.fit), measured_lab(second.fit))
    fitted = delta_e_2000(first.colour.lab, second.colour.lab)
    low, high = difference_interval(first.colour, second.colour)
    return ColourDifference(
        first.stratum,
        first.level,
        second.level,
        float(apart),
        float(fitted),
        float(low),
        float(high),
    )
