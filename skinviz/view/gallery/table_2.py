"""Table II: the pigments' weights, and whether sites stand in the paper's order."""

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
    """Return weights, the orders of sites, and tests of the orders."""
    people, chosen = everyone(), subjects()
    methods = [method(*own[::-1]) for own in product(COEFFICIENTS, skin_models())]
    n = len(people.names)
    caption = (
        f"{WHO} Intervals are of 95 %. Sizes cannot be compared with the paper's, "
        "whose curves were never printed: orders between sites can.\n\nOrders: the "
        "share of pairs of sites that stand in the paper's order, ties counting "
        "half.\n\nClaims: the orders that the paper's Table II shows, each site "
        f"against each other one within {n} people; Wilcoxon's signed-rank test, "
        "two-sided, corrected for all contrasts of a method (Holm). The difference is "
        "Hodges and Lehmann's with 95 % interval, the effect the rank-biserial "
        "correlation. Only w_m × D_e can be told from a spectrum: where w_m and w_m × "
        "D_e disagree, the order is that of the thicknesses of Table I."
    )
    return Material(
        {
            "": paper_tables.table_2(people, chosen, methods),
            "orders": paper_tables.orders(chosen, methods),
            "claims": paper_tables.claims(people, methods),
        },
        caption,
    )


def tell(material: Material) -> str:
    """Return the weights in the paper's layout, a block a method, and the tests."""
    blocks = [
        *paper_tables.in_papers_layout(material.table).items(),
        ("orders", material.tables["orders"]),
        ("claims", material.tables["claims"]),
    ]
    return "\n".join(f"{title}\n\n{as_text(table)}" for title, table in blocks)


RECIPE = FigureRecipe(
    name="table-2",
    title="Table II: pigment weights by body site",
    sources=(ISSA, EFFECTIVE, TEXTBOOK),
    data=data,
    tell=tell,
)
