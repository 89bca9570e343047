"""Table III: how far fitted spectra are from measured ones."""

from __future__ import annotations

from itertools import product

from skinviz.skin.models import skin_models
from skinviz.study import paper_tables
from skinviz.study.tables import COEFFICIENTS
from skinviz.view.gallery.people import WHO, everyone, method, subjects
from skinviz.view.gallery.recipe import (
    EFFECTIVE,
    ISSA,
    TEXTBOOK,
    FigureRecipe,
    Material,
    Settings,
)
from skinviz.view.gallery.text import as_text


def data(_: Settings) -> Material:
    """Return the errors of every model and coefficient set."""
    people = everyone()
    methods = [method(*own[::-1]) for own in product(COEFFICIENTS, skin_models())]
    caption = (
        f"{WHO} Errors are sums of squared differences over 31 bands, times 61/31. "
        "“Average” is over A, B and C, “mean” over everyone who was measured at all "
        "four sites. “two-layer” is the paper's proposal, “cotton” its previous method."
    )
    table = paper_tables.table_3(people, subjects(), methods)
    return Material({"": table}, caption)


RECIPE = FigureRecipe(
    name="table-3",
    title="Table III: errors of fitted spectra",
    sources=(ISSA, EFFECTIVE, TEXTBOOK),
    data=data,
    tell=lambda material: as_text(material.table),
)
