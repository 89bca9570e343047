"""How sure the weights are, and what that does to colours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model
from skinviz.skin.skin_fit import SkinFit
from skinviz.study.colour_error import colour_error
from skinviz.study.tables import SITES
from skinviz.view.gallery.boxes import BOXES, boxes_panel, quantiles_of
from skinviz.view.gallery.people import everyone
from skinviz.view.gallery.recipe import (
    COLOUR,
    EFFECTIVE,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)
from skinviz.view.page import Cells, Margins, lay_out

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = {
    "w_m": ("melanin w_m", "half interval"),
    "w_h": ("oxyhaemoglobin w_h", "half interval"),
    "w_dh": ("deoxyhaemoglobin w_dh", "half interval"),
    "saturation": ("oxygen saturation", "width of interval"),
    "colour": ("colour from the covariance", "95 % of ΔE00"),
    "misfit": ("measured against fitted", "ΔE00"),
}
"""What is shown: titles and axes."""

_WEIGHTS = ("w_m", "w_h", "w_dh")
_BETWEEN = "standard deviation between people"


def data(settings: Settings) -> Material:
    """Return quantiles over everyone, by site, of how wide the intervals are."""
    people = everyone()
    rows, persons = [], []
    for i, site in enumerate(SITES):
        model = skin_model(site=site, specular=people.specular)
        fit = fit_skin(people.reflectance[:, i], people.wavelengths, model)
        values = _values(fit, settings.seed + i)
        deviation = np.std(fit.values, axis=0, ddof=1)
        spread = dict(zip(fit.parameters, deviation, strict=True))
        persons.append(pd.DataFrame({"person": people.names, "site": site, **values}))
        for name, own in values.items():
            rows.append(
                {
                    "quantity": name,
                    "site": site,
                    **quantiles_of(own),
                    "between_people": spread.get(name, np.nan),
                }
            )
    caption = (
        f"Fits of the two-layer model to {len(people.names)} people, intervals of 95 % "
        "from the residuals. Top: half the width of a weight's interval; a cross marks "
        "the standard deviation between people, for scale. Bottom: the width of the "
        "interval of the oxygen saturation, the colour error that the covariance "
        "implies (95 % of 1000 draws under D65 lie within it), and the colour "
        f"difference that the fit itself leaves. {BOXES} All intervals take the model, "
        "the coefficients and the thickness as true."
    )
    return Material(
        {"": pd.DataFrame(rows), "people": pd.concat(persons, ignore_index=True)},
        caption,
    )


def draw(material: Material, settings: Settings) -> Figure:
    """Draw a panel for each quantity, a box for each site."""
    page = lay_out(
        settings.width,
        [Cells(len(PANELS), (1.35,), least=1.4, most=3, margins=Margins(bottom=0.42))],
        title=RECIPE.title,
        legend=[_BETWEEN],
        caption=RECIPE.credit,
    )
    table = material.table
    for axes, (name, (title, words)) in zip(page.panels(), PANELS.items(), strict=True):
        own = table[table["quantity"] == name]
        boxes_panel(axes, own, list(own["site"]))
        if name in _WEIGHTS:
            axes.plot(range(len(own)), own["between_people"], "kx", ms=5, mew=1.2)
        axes.set(title=title, ylabel=words)
        axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
    page.legend(page.panels()[0].lines[-1:], [_BETWEEN])
    return page.figure


def _values(fit: SkinFit, seed: int) -> dict[str, np.ndarray]:
    """Return of each spectrum how wide its intervals are, and its colour errors."""
    width = np.diff(fit.interval, axis=-1)[..., 0] / 2
    saturation = np.diff(fit.oxygen_saturation_interval, axis=-1)[..., 0]
    return {
        **dict(zip(fit.parameters, width.T, strict=True)),
        "saturation": saturation,
        "colour": colour_error(fit, seed=seed).delta_e,
        "misfit": fit.delta_e,
    }


RECIPE = FigureRecipe(
    name="uncertainty",
    title="How sure the weights are, and what that does to colours",
    sources=(ISSA, EFFECTIVE, COLOUR),
    data=data,
    draw=draw,
)
