"""Fig. 9: a hand at several angles of light and view."""

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
    EFFECTIVE,
    HAND,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ANGLES = {"a": (0, 0), "b": (30, 0), "c": (60, 0), "d": (60, 60)}
"""Of illumination and viewing from the normal, as in the paper. [°]"""

_SUBJECT, _SITE = "A", "back of hand"


def data(settings: Settings) -> Material:
    """Return a picture for each pair of angles."""
    skin = Skin.from_fit(subject_fit(_SUBJECT, _SITE))
    size = picture_size(settings, len(ANGLES))
    scenes = {
        f"({letter})  {light}/{view}": hand_scene(skin, size, angles=(light, view))
        for letter, (light, view) in ANGLES.items()
    }
    pictures, rows = rendered(scenes, settings)
    caption = (
        "Angles of illumination and viewing from the normal of the hand's back, on "
        "opposite sides, under D65; in (d) the surface shines. Skin: back of the hand "
        f"of subject {_SUBJECT}, {name_of(_SUBJECT)}. {MADE}"
    )
    return Material({"": pd.DataFrame(rows)}, caption, pictures)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw the pictures side by side."""
    names = grid_of(list(material.pictures), len(ANGLES))
    return draw_hands(material, settings, RECIPE, names)


RECIPE = FigureRecipe(
    name="9",
    title="Fig. 9: a hand at several angles of illumination and viewing",
    sources=(ISSA, EFFECTIVE, HAND, COLOUR),
    data=data,
    draw=draw,
    suffixes=(".png",),
)
