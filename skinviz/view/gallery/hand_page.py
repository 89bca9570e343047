"""How figures of hands are drawn: pictures in rows, their colour underneath."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from skinviz.view.gallery.recipe import FigureRecipe, Material, Settings
from skinviz.view.hands_grid import Hand, grid_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_hands(
    material: Material,
    settings: Settings,
    recipe: FigureRecipe,
    names: Sequence[Sequence[str]],
    *,
    labels: bool = True,
    row_labels: Sequence[str] = (),
    column_labels: Sequence[str] = (),
    difference: str = "",
) -> Figure:
    """Return the pictures of some names in rows, each with its median L*a*b* below.

    The figure's own table has a row for each picture. ``labels`` says whether names
    stand above the pictures; ``difference`` is a column of ΔE00 to be written too.
    """
    rows = material.table.set_index("picture")

    def hand(name: str) -> Hand:
        own = rows.loc[name]
        told = [f"L* {own['L']:.1f}  a* {own['a']:.1f}  b* {own['b']:.1f}"]
        if difference:
            told.append(f"ΔE00 {own[difference]:.1f}")
        label = name if labels else ""
        return Hand(material.pictures[name], label, notes=told)

    return grid_figure(
        [[hand(name) for name in row] for row in names],
        settings.width,
        pixel=float(rows["pixel_mm"].iloc[0]),
        row_labels=row_labels,
        column_labels=column_labels,
        title=recipe.title,
        caption=recipe.credit,
    )
