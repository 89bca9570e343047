"""Fig. 10: hands with several amounts of melanin and of oxyhaemoglobin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.scene.scene import Skin
from skinviz.skin.models import skin_model
from skinviz.view.gallery.hand_page import draw_hands
from skinviz.view.gallery.hands import (
    MADE,
    grid_of,
    hand_scene,
    picture_size,
    rendered,
)
from skinviz.view.gallery.people import everyone, method
from skinviz.view.gallery.recipe import (
    COLOUR,
    EFFECTIVE,
    HAND,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUANTILES = (0.02, 0.35, 0.8, 0.99)
"""Of everyone's weights, by which melanin grows downwards, oxyhaemoglobin across."""

_SITE = "back of hand"


def data(settings: Settings) -> Material:
    """Return a picture for each pair of weights."""
    people, own = everyone(), method()
    s = people.sites.index(_SITE)
    melanin = np.quantile(own.parameter("w_m")[:, s], QUANTILES)
    oxy = np.quantile(own.parameter("w_h")[:, s], QUANTILES)
    deoxy = float(np.median(own.parameter("w_dh")[:, s]))
    model = skin_model(site=_SITE, specular=people.specular)
    weights = {
        f"{i + 1}.{j + 1}": (w_m, w_h, deoxy)
        for i, w_m in enumerate(melanin)
        for j, w_h in enumerate(oxy)
    }
    size = picture_size(settings, len(QUANTILES))
    scenes = {
        name: hand_scene(Skin(model, np.array(own_weights)), size)
        for name, own_weights in weights.items()
    }
    pictures, rows = rendered(scenes, settings)
    table = pd.DataFrame(rows)
    for k, name in enumerate(own.parameters):
        table.insert(1 + k, name, [w[k] for w in weights.values()])
    told = ", ".join(f"{100 * q:g} %" for q in QUANTILES)
    caption = (
        f"Weights are the {told} quantiles of those of {len(people.names)} people at "
        f"the back of the hand; deoxyhaemoglobin is at its median. More melanin looks "
        "like a tan, more oxyhaemoglobin like inflamed skin; under much melanin it "
        f"hardly shows. Illuminant D65, 0/0. {MADE}"
    )
    return Material({"": table}, caption, pictures)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw melanin down and oxyhaemoglobin across."""
    n = len(QUANTILES)
    table = material.table
    return draw_hands(
        material,
        settings,
        RECIPE,
        grid_of(list(material.pictures), n),
        labels=False,
        row_labels=[f"melanin {w:.3f}" for w in table["w_m"][::n]],
        column_labels=[f"oxyhaemoglobin {w:.4f}" for w in table["w_h"][:n]],
    )


RECIPE = FigureRecipe(
    name="10",
    title="Fig. 10: hands with several amounts of melanin and oxyhaemoglobin",
    sources=(ISSA, EFFECTIVE, HAND, COLOUR),
    data=data,
    draw=draw,
    suffixes=(".png",),
)
