"""Fig. 6: scattering of the skin's layers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from skinviz.view.gallery.coefficient_curves import curves, draw_curves
from skinviz.view.gallery.recipe import (
    COLOUR,
    EFFECTIVE,
    TEXTBOOK,
    FigureRecipe,
    Material,
    Settings,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LABELS = {"S_e_mm1": "epidermis", "S_d_mm1": "dermis"}


def data(_: Settings) -> Material:
    """Return S of the layers in both sets."""
    caption = (
        "Kubelka–Munk scattering of epidermis and dermis. “Effective” was tuned so "
        "that the model fits measured spectra, “textbook” has no fitted number: ¾ of "
        "the reduced scattering. The paper's own curves were never printed as numbers."
    )
    table = curves({"epidermis": "S_e_mm1", "dermis": "S_d_mm1"})
    return Material({"": table}, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw both sets."""
    return draw_curves(
        material.table,
        _LABELS,
        settings.width,
        title=RECIPE.title,
        caption=RECIPE.credit,
        ylabel="scattering S (mm⁻¹)",
    )


RECIPE = FigureRecipe(
    name="6",
    title="Fig. 6: scattering of epidermis and dermis",
    sources=(EFFECTIVE, TEXTBOOK, COLOUR),
    data=data,
    draw=draw,
)
