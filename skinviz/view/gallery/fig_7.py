"""Fig. 7: measured spectra of four body sites and what two models make of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.study.tables import SITES
from skinviz.view.gallery.people import everyone, name_of, subject_fit, subject_spectrum
from skinviz.view.gallery.recipe import (
    COLOUR,
    EFFECTIVE,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)
from skinviz.view.page import Cells, Margins, align_ylabels, lay_out
from skinviz.view.panels import wavelength_axis
from skinviz.view.spectra_panels import ROW, Swatch, srgb_of, swatch_rows
from skinviz.view.styles import Line

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES = {
    "two-layer": ("proposed", Line("#D55E00", "-", "")),
    "measured": ("measured", Line("#000000", (0, (4, 1.6)), "")),
    "cotton": ("Cotton & Claridge", Line("#0072B2", (0, (1, 1.2)), "")),
}
"""The curves with the paper's dashes: solid, broken and dotted."""

_MODELS = ("two-layer", "cotton")
_SUBJECT = "A"


def data(_: Settings) -> Material:
    """Return measured and fitted spectra by site, and how well each model fits."""
    spectra, fits = [], []
    for site in SITES:
        own = {model: subject_fit(_SUBJECT, site, model) for model in _MODELS}
        nm = own["two-layer"].wavelengths
        inside = np.isin(everyone().wavelengths, nm)
        measured = subject_spectrum(_SUBJECT, site)[inside]
        curves = {model: fit.fitted for model, fit in own.items()}
        spectra.append(
            pd.DataFrame(
                {"site": site, "wavelength_nm": nm, "measured": measured, **curves}
            )
        )
        xyz = {"measured": own["two-layer"].xyz[0]}
        xyz |= {model: fit.xyz[1] for model, fit in own.items()}
        for name, colour in xyz.items():
            fit = own.get(name)
            fits.append(
                {
                    "site": site,
                    "curve": name,
                    **dict(zip("XYZ", colour, strict=True)),
                    "sse_61": np.nan if fit is None else float(fit.sse_61),
                    "delta_e_00": np.nan if fit is None else float(fit.delta_e),
                }
            )
    caption = (
        f"Subject {_SUBJECT}, {name_of(_SUBJECT)}. Solid: two Kubelka–Munk layers, the "
        "paper's proposal. Broken: measured, surface reflection included. Dotted: "
        "Cotton and Claridge's model, the paper's “previous method”. Below: measured "
        "minus fitted, and the colours under D65 with the sum of squares scaled to 61 "
        "bands."
    )
    return Material({"": pd.concat(spectra), "fits": pd.DataFrame(fits)}, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw a cell for each site: curves, residuals, colours."""
    labels = [label for label, _ in LINES.values()]
    page = lay_out(
        settings.width,
        [
            Cells(
                len(SITES),
                (1.7, 0.6, 3 * ROW),
                gap=(0.1, 0.52),
                least=1.65,
                margins=Margins(left=0.72, bottom=0.1),
            )
        ],
        title=RECIPE.title,
        legend=labels,
        caption=RECIPE.credit,
    )
    table, fits = material.tables[""], material.tables["fits"]
    top = 1.05 * table[["measured", *_MODELS]].to_numpy().max()
    apart = table[[*_MODELS]].to_numpy() - table[["measured"]].to_numpy()
    spread = 1.1 * np.abs(apart).max()
    for site, (curves, residuals, colours) in zip(SITES, page.blocks[0], strict=True):
        own = table[table["site"] == site]
        handles = _curves(curves, own)
        curves.set(title=site, ylim=(0, top))
        _residuals(residuals, own)
        residuals.set_ylim(-spread, spread)
        align_ylabels([curves, residuals], 0.54)
        swatch_rows(colours, _swatches(fits[fits["site"] == site]))
    page.legend(handles, labels)
    return page.figure


def _curves(axes: Axes, own: pd.DataFrame) -> list[Artist]:
    """Draw the three spectra of a site."""
    handles: list[Artist] = []
    for name, (_, style) in LINES.items():
        handles += axes.plot(own["wavelength_nm"], own[name], **style(len(own)))
    axes.set_ylabel("reflectance")
    wavelength_axis(axes, labelled=False)
    return handles


def _residuals(axes: Axes, own: pd.DataFrame) -> None:
    """Draw measured minus fitted of both models."""
    axes.axhline(0, lw=0.7, color="0.6")
    for name in _MODELS:
        rest = own["measured"] - own[name]
        axes.plot(own["wavelength_nm"], rest, **LINES[name][1](len(own)))
    axes.set_ylabel("residual")
    wavelength_axis(axes)


def _swatches(fits: pd.DataFrame) -> list[Swatch]:
    """Return the colours of a site."""
    shown = []
    for name, row in fits.set_index("curve").iterrows():
        told = f"SSE61 {row['sse_61']:.4f}, ΔE00 {row['delta_e_00']:.2f}"
        note = "" if np.isnan(row["sse_61"]) else told
        colour = srgb_of(row[["X", "Y", "Z"]].to_numpy(dtype=np.float64))
        shown.append(Swatch(LINES[str(name)][0], colour, note=note))
    return shown


RECIPE = FigureRecipe(
    name="7",
    title="Fig. 7: measured and fitted reflectance of four body sites",
    sources=(ISSA, EFFECTIVE, COLOUR),
    data=data,
    draw=draw,
)
