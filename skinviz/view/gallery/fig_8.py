"""Fig. 8: a hand under two illuminants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from skinviz.scene.scene import Skin
from skinviz.view.gallery.hand_page import draw_hands
from skinviz.view.gallery.hands import (
    MADE,
    grid_of,
    hand_scene,
    picture_size,
    rendered,
)
from skinviz.view.gallery.people import name_of, subject_fit
from skinviz.view.gallery.recipe import (
    COLOUR,
    COLUMN,
    EFFECTIVE,
    HAND,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIGHTS = ("D65", "A")
"""CIE illuminants, as in the paper."""

_SUBJECT, _SITE = "A", "back of hand"


def data(settings: Settings) -> Material:
    """Return a picture for each light."""
    skin = Skin.from_fit(subject_fit(_SUBJECT, _SITE))
    size = picture_size(settings, len(LIGHTS))
    scenes = {
        f"illuminant {light}": hand_scene(skin, size, illuminant=light)
        for light in LIGHTS
    }
    pictures, rows = rendered(scenes, settings)
    caption = (
        "Light and view along the normal of the hand's back. Skin: back of the hand of "
        f"subject {_SUBJECT}, {name_of(_SUBJECT)}. {MADE}"
    )
    return Material({"": pd.DataFrame(rows)}, caption, pictures)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw the pictures side by side."""
    names = grid_of(list(material.pictures), len(LIGHTS))
    return draw_hands(material, settings, RECIPE, names)


RECIPE = FigureRecipe(
    name="8",
    title="Fig. 8: a hand under two illuminants",
    sources=(ISSA, EFFECTIVE, HAND, COLOUR),
    data=data,
    draw=draw,
    width=COLUMN,
    suffixes=(".png",),
)
