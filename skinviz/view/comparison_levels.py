"""What of a comparison is drawn, and how its levels and strata are named."""

from __future__ import annotations

import numpy as np

from skinviz.study.comparison import Cell, Comparison, Stratum

MOST_SHOWN = 12
"""Levels that a figure shows; the tables have all."""

WIDTH = 9.0
"""Of a figure, by default. [inches]"""

_LONGEST = 28  # letters of a level that are written beside an axis


def shown(comparison: Comparison) -> tuple[str, ...]:
    """Return the levels that are drawn."""
    return comparison.levels[:MOST_SHOWN]


def drawn(comparison: Comparison, stratum: Stratum) -> tuple[Cell, ...]:
    """Return the cells of a stratum that are drawn."""
    levels = shown(comparison)
    return tuple(cell for cell in comparison.row(stratum) if cell.level in levels)


def title_of(stratum: Stratum) -> str:
    """Return a stratum as a title, nothing if there is but one."""
    return str(stratum) if stratum.site or stratum.condition else ""


def shortened(text: str) -> str:
    """Return a name that fits beside an axis."""
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def error_text(cell: Cell) -> str:
    """Return within what ΔE00 a cell's fitted colour is known, "" if it is not."""
    error = float(cell.colour.delta_e)
    if not np.isfinite(error):
        return ""
    return f"± {error:.2f} ΔE00" if error >= 0.01 else "± < 0.01 ΔE00"
