"""A hand under lights of one white: metameric illuminants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.scene.scene import Skin
from skinviz.spectra.colorimetry import (
    colour_matching_functions,
    delta_e_2000,
    xyz_weights,
)
from skinviz.spectra.illuminants import (
    Illuminant,
    as_illuminant,
    illuminant_spd,
    line_lamp,
)
from skinviz.view.gallery.hand_page import draw_hands
from skinviz.view.gallery.hands import MADE, hand_scene, picture_size, rendered
from skinviz.view.gallery.people import WHO, subject_fit
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

TRIPLES = ((450.0, 540.0, 610.0), (470.0, 560.0, 660.0))
"""Wavelengths of lamps of three lines. [nm]"""

SUBJECTS = ("A", "C")
"""Of light and of dark skin."""

_SITE = "back of hand"
_FINE = np.arange(380.0, 781.0)


def lights() -> dict[str, Illuminant]:
    """Return D65, the fluorescent lamp that imitates it, and lines of its white."""
    return {
        "D65": as_illuminant("D65"),
        "FL7": as_illuminant("FL7"),
        **{"/".join(f"{nm:g}" for nm in own): white_lines(own) for own in TRIPLES},
    }


def white_lines(wavelengths: tuple[float, float, float]) -> Illuminant:
    """Return a lamp of three lines [nm] whose white is that of D65.

    Its powers solve three equations, for X, Y and Z; all must come out positive.
    """
    white = xyz_weights(_FINE, illuminant_spd("D65", _FINE)).sum(axis=0)
    power = np.linalg.solve(colour_matching_functions(wavelengths).T, white)
    return line_lamp(np.column_stack([wavelengths, power]))


def data(settings: Settings) -> Material:
    """Return a picture for each skin and light, and how far lights move colours."""
    lamps = lights()
    size = picture_size(settings, len(lamps))
    scenes = {
        f"{subject}, {name}": hand_scene(
            Skin.from_fit(subject_fit(subject, _SITE)), size, illuminant=lamp
        )
        for subject in SUBJECTS
        for name, lamp in lamps.items()
    }
    pictures, rows = rendered(scenes, settings)
    table = pd.DataFrame(rows)
    lab = table[["L", "a", "b"]].to_numpy().reshape(len(SUBJECTS), len(lamps), 3)
    table["delta_e_00_from_D65"] = delta_e_2000(lab, lab[:, :1]).ravel()
    caption = (
        "All lights have the white of daylight D65: FL7, a fluorescent lamp, nearly, "
        "the lamps of three spectral lines (nm) exactly. White paper looks the same "
        "under them, skin does not: ΔE00 is that of its median colour from the one "
        f"under D65. Light and view along the normal of the hand's back. {WHO} {MADE}"
    )
    return Material({"": table}, caption, pictures)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw skins down and lights across."""
    names = list(lights())
    return draw_hands(
        material,
        settings,
        RECIPE,
        [[f"{subject}, {name}" for name in names] for subject in SUBJECTS],
        labels=False,
        row_labels=[f"subject {subject}" for subject in SUBJECTS],
        column_labels=[name if name[0] != "4" else f"{name} nm" for name in names],
        difference="delta_e_00_from_D65",
    )


RECIPE = FigureRecipe(
    name="metameric-lights",
    title="A hand under lights of one white",
    sources=(ISSA, EFFECTIVE, HAND, COLOUR),
    data=data,
    draw=draw,
    suffixes=(".png",),
)
