"""Distributions as boxes from their quantiles: what is drawn is what a table holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from skinviz.view.page import in_cells, inches_of
from skinviz.view.styles import line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

QUANTILES = {"q05": 0.05, "q25": 0.25, "median": 0.5, "q75": 0.75, "q95": 0.95}
"""Ends of the whiskers, of the box, and its middle."""

BOXES = "Boxes hold the middle half, whiskers 90 %."
"""Said where they are drawn."""


def quantiles_of(values: ArrayLike) -> dict[str, float]:
    """Return how many values there are and their quantiles; NaN is left out."""
    own = np.asarray(values, dtype=np.float64)
    own = own[~np.isnan(own)]
    if not own.size:
        return {"n": 0, **dict.fromkeys(QUANTILES, np.nan)}
    found = np.quantile(own, list(QUANTILES.values()), method="lower")
    return {"n": own.size, **dict(zip(QUANTILES, map(float, found), strict=True))}


def boxes_panel(axes: Axes, rows: pd.DataFrame, labels: Sequence[str]) -> None:
    """Draw a box for each row, labelled underneath."""
    stats = [
        {
            "whislo": row["q05"],
            "q1": row["q25"],
            "med": row["median"],
            "q3": row["q75"],
            "whishi": row["q95"],
        }
        for _, row in rows.iterrows()
    ]
    drawn = axes.bxp(
        stats,
        positions=range(len(stats)),
        widths=0.6,
        showfliers=False,
        patch_artist=True,
        medianprops={"color": "k", "lw": 1.2},
        whiskerprops={"lw": 0.8},
        capprops={"lw": 0.8},
    )
    for k, box in enumerate(drawn["boxes"]):
        box.set(facecolor=line(k).colour, alpha=0.45, edgecolor="k", lw=0.8)
    told, size = in_cells(labels, inches_of(axes)[0], 7.5)
    axes.set_xticks(range(len(labels)), told, fontsize=size)
    axes.tick_params(axis="x", pad=2, length=2)
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.grid(visible=True, axis="y", color="0.92", lw=0.6)
    axes.set_axisbelow(True)
