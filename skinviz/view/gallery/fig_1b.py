"""Fig. 1(b): the back of a hand under light from several angles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS
from skinviz.surface.torrance_sparrow import TorranceSparrow
from skinviz.view.gallery.people import name_of, subject_fit
from skinviz.view.gallery.recipe import (
    COLOUR,
    COLUMN,
    EFFECTIVE,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)
from skinviz.view.page import Cells, Margins, lay_out
from skinviz.view.spectra_panels import Band, bands_panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ANGLES = (0, 15, 30, 45, 60, 75)
"""Of the light from the normal, along which is viewed. [°]"""

_SUBJECT, _SITE = "A", "back of hand"


def data(_: Settings) -> Material:
    """Return the radiance factor at each angle, and what it is the sum of."""
    fit = subject_fit(_SUBJECT, _SITE)
    surface = TorranceSparrow()
    body = fit.model.diffuse(fit.values, PAPER_WAVELENGTHS)
    theta = np.deg2rad(ANGLES)
    light = np.stack([np.sin(theta), np.zeros(theta.size), np.cos(theta)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    # A radiance factor compares with white lit from the same angle.
    specular = surface.evaluate(up, light, up) / np.cos(theta)
    rows = [
        pd.DataFrame(
            {
                "illumination_deg": angle,
                "viewing_deg": 0,
                "wavelength_nm": PAPER_WAVELENGTHS,
                "radiance_factor": body + own,
                "diffuse": body,
                "specular": own,
            }
        )
        for angle, own in zip(ANGLES, specular, strict=True)
    ]
    caption = (
        "Radiance factor of the back of the hand, seen along its normal. Computed: the "
        f"archive has no such measurements. The body is the fit to subject {_SUBJECT}, "
        f"{name_of(_SUBJECT)}; the surface is {surface.description}. As in the paper "
        "the specular part is largest at 0°; it is the same at all wavelengths, and "
        "how fast it falls is set by gamma."
    )
    return Material({"": pd.concat(rows, ignore_index=True)}, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw a curve for each angle."""
    labels = [f"{angle}°" for angle in ANGLES]
    page = lay_out(
        settings.width,
        [Cells(1, (2.3,), margins=Margins(top=0.06))],
        title=RECIPE.title,
        legend=labels,
        caption=RECIPE.credit,
    )
    (axes,) = page.panels()
    table = material.table
    bands = [
        Band(f"{angle}°", own["radiance_factor"].to_numpy())
        for angle, own in table.groupby("illumination_deg")
    ]
    nm = table["wavelength_nm"].unique()
    page.legend(bands_panel(axes, nm, bands, ylabel="radiance factor"), labels)
    axes.set_ylim(0, 1.05 * table["radiance_factor"].max())
    return page.figure


RECIPE = FigureRecipe(
    name="1b",
    title="Fig. 1b: the back of a hand under light from several angles",
    sources=(ISSA, EFFECTIVE, COLOUR),
    data=data,
    draw=draw,
    width=COLUMN,
)
