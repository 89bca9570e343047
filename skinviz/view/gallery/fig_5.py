"""Fig. 5: absorption of the skin's pigments."""

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

_COLUMNS = {
    "melanin": "K_m_mm1",
    "oxyhaemoglobin": "K_h_mm1",
    "deoxyhaemoglobin": "K_dh_mm1",
}
_LABELS = {
    "K_m_mm1": "melanin, of pure melanosome",
    "K_h_mm1": "oxyhaemoglobin, of whole blood",
    "K_dh_mm1": "deoxyhaemoglobin, of whole blood",
}


def data(_: Settings) -> Material:
    """Return K of the pigments in both sets."""
    caption = (
        "Kubelka–Munk absorption of pure pigments, which the weights of a fit "
        "multiply. The paper's own curves were never printed as numbers; these take "
        "their place. Blood is the same in both sets."
    )
    return Material({"": curves(_COLUMNS)}, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw both sets."""
    return draw_curves(
        material.table,
        _LABELS,
        settings.width,
        title=RECIPE.title,
        caption=RECIPE.credit,
        ylabel="absorption K (mm⁻¹)",
    )


RECIPE = FigureRecipe(
    name="5",
    title="Fig. 5: absorption of the pigments",
    sources=(EFFECTIVE, TEXTBOOK, COLOUR),
    data=data,
    draw=draw,
)
