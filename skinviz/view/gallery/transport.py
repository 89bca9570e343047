"""How far Kubelka–Munk is from radiative transport in the same tissue."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.view.gallery.recipe import TRANSPORT, FigureRecipe, Material, Settings
from skinviz.view.page import Cells, lay_out
from skinviz.view.styles import line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CASES = {
    "body": "no surface, diffuse light",
    "body, beam": "no surface, a beam",
    "sphere": "n = 1.4, a beam (8°/diffuse)",
    "diffuse": "n = 1.4, diffuse light",
}
"""What was compared, in words."""

RULES = {
    "gate": "Gate: S = ¾ μs′",
    "star": "Star: ¾ μs′ − ¼ μa",
    "klier": "Klier: asymptotic",
    "meador_weaver": "Meador & Weaver: 1/√3",
    "toon": "Toon: hemispheric",
}
"""How transport coefficients became Kubelka and Munk's, in words."""


def data(_: Settings) -> Material:
    """Return the shipped comparison, averaged over body sites."""
    with files("skinviz.skin").joinpath("data/transport.csv").open("rb") as file:
        table = pd.read_csv(file)
    keys = ["case", "rule", "melanin"]
    grouped = table.groupby(keys, sort=False)
    means = grouped[["mean_dR", "mean_dE00"]].mean()
    largest = grouped[["max_dR", "max_dE00"]].max()
    skins = grouped["skins"].sum()
    caption = (
        "Mean ΔE00 (D65) of the two-layer model from adding–doubling, over blood 0–7 % "
        "and four body sites, along melanin, for each rule that gives K and S. Star's "
        "rule answers for lighter skins only. Under a real surface most of the error "
        "is the interface's, which supposes light beneath it to be diffuse at once. A "
        "fit hides much of it: docs/transport.md."
    )
    joined = pd.concat([skins, means, largest], axis=1).reset_index()
    return Material({"": joined}, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw a panel for each case, a curve for each rule."""
    page = lay_out(
        settings.width,
        [Cells(len(CASES), (1.7,))],
        title=RECIPE.title,
        legend=list(RULES.values()),
        caption=RECIPE.credit,
    )
    table = material.table
    top = 1.05 * np.nanmax(table["mean_dE00"])
    for axes, (case, words) in zip(page.panels(), CASES.items(), strict=True):
        _panel(axes, table[table["case"] == case])
        axes.set(title=words, ylim=(0, top))
    page.legend(page.panels()[0].lines, list(RULES.values()))
    return page.figure


def _panel(axes: Axes, own: pd.DataFrame) -> None:
    """Draw ΔE00 along melanin, a curve for each rule."""
    for k, rule in enumerate(RULES):
        part = own[own["rule"] == rule]
        style = line(k)(1)  # every point is marked
        axes.plot(100 * part["melanin"], part["mean_dE00"], **style)
    melanin = 100 * own["melanin"].unique()
    axes.set_xscale("log")
    axes.set_xticks(melanin, [f"{m:.0f}" for m in melanin])
    axes.minorticks_off()
    axes.set(xlabel="melanin in the epidermis (%)", ylabel="mean ΔE00")
    axes.grid(visible=True, color="0.92", lw=0.6)


RECIPE = FigureRecipe(
    name="transport",
    title="The model's error against radiative transport",
    sources=(TRANSPORT,),
    data=data,
    draw=draw,
)
