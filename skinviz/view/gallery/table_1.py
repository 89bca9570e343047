"""Table I: thickness of the skin's layers."""

from __future__ import annotations

from skinviz.study import paper_tables
from skinviz.view.gallery.recipe import THICKNESS, FigureRecipe, Material, Settings
from skinviz.view.gallery.text import as_text


def data(_: Settings) -> Material:
    """Return the table."""
    caption = (
        "Epidermis and dermis at the paper's body sites, in mm. “Outer arm” and “inner "
        "arm” are the paper's outside and inside of the arm."
    )
    return Material({"": paper_tables.table_1()}, caption)


RECIPE = FigureRecipe(
    name="table-1",
    title="Table I: thickness of the layers of skin",
    sources=(THICKNESS,),
    data=data,
    tell=lambda material: as_text(material.table),
)
