"""The people of the archive: colour, and melanin against blood, by group and site."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from skinviz.skin.coefficients import layer_thickness
from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model
from skinviz.spectra.archive_selection import people, select
from skinviz.spectra.archives import load_archive
from skinviz.spectra.colorimetry import spectrum_to_xyz, xyz_to_lab
from skinviz.study.people import typology_angle
from skinviz.study.tables import SITES
from skinviz.view.gallery.people import averaged, visible
from skinviz.view.gallery.recipe import (
    COLOUR,
    EFFECTIVE,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)
from skinviz.view.page import Cells, lay_out
from skinviz.view.styles import LINES

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CLASSES = (55, 41, 28, 10, -30)
"""Typology angles between very light, light, intermediate, tan, brown and dark. [°]"""

_TICKS = (2, 5, 10, 20)  # µm
_LEAST = 2e-4  # blood fraction at the edge of a logarithmic axis


def data(_: Settings) -> Material:
    """Return colour and fit of every person at each of the paper's sites."""
    table = pd.concat([_site(site) for site in SITES], ignore_index=True)
    n = table["person"].nunique()
    caption = (
        f"{n} people of the archive, each with one spectrum a site; duplicates are "
        "left out. Top: L* and b* under D65 with the classes of the individual "
        "typology angle. Bottom: melanin under an area of skin, which is all that a "
        "spectrum tells of it, against the blood fraction of the dermis; less than "
        f"{_LEAST:g} stands at the edge. Large marks are medians. Six of seven origins "
        "measured one group only: differences between groups are also differences "
        "between instruments."
    )
    return Material({"": table}, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw a cell for each site: colour above, pigments below."""
    table = material.table
    groups = sorted(table["group"].unique())
    page = lay_out(
        settings.width,
        [Cells(len(SITES), (1.7, 1.7), gap=0.52, least=1.6)],
        title=RECIPE.title,
        legend=groups,
        caption=RECIPE.credit,
    )
    for site, (colours, pigments) in zip(SITES, page.blocks[0], strict=True):
        own = table[table["site"] == site]
        handles = _scatter(colours, own, groups, ("b", "L"))
        _colour_axes(colours, table)
        colours.set_title(f"{site}, {len(own)} people")
        shown = own.assign(blood_fraction=own["blood_fraction"].clip(lower=_LEAST))
        _scatter(pigments, shown, groups, ("melanin_per_area_um", "blood_fraction"))
        _pigment_axes(pigments, table)
    page.legend(handles, groups)
    return page.figure


def _site(site: str) -> pd.DataFrame:
    """Return everyone at a site, one row a person."""
    own = select(averaged(), site=site)
    nm = own["wavelength"].to_numpy()
    seen = visible(nm)
    spectra, bands = own["reflectance"].to_numpy()[:, seen], nm[seen]
    whole = np.isfinite(spectra).all(axis=1)
    own, spectra = own.isel(record=np.flatnonzero(whole)), spectra[whole]
    white = spectrum_to_xyz(np.ones(bands.size), bands)
    lab = xyz_to_lab(spectrum_to_xyz(spectra, bands), white)
    model = skin_model(site=site, specular=load_archive("issa").attrs["specular"])
    fit = fit_skin(spectra, bands, model)
    weights = dict(zip(fit.parameters, np.moveaxis(fit.values, 1, 0), strict=True))
    labels = {
        key: own[key].to_numpy() for key in ("group", "origin", "sex", "age_group")
    }
    return pd.DataFrame(
        {
            "person": people(own),
            **labels,
            "site": site,
            **dict(zip("Lab", lab.T, strict=True)),
            "typology_angle_deg": typology_angle(spectra, bands),
            **weights,
            "melanin_per_area_um": 1000 * weights["w_m"] * layer_thickness(site)[0],
            "blood_fraction": fit.blood_fraction,
            "oxygen_saturation": fit.oxygen_saturation,
            "status": fit.status,
        }
    )


def _scatter(
    axes: Axes, own: pd.DataFrame, groups: list[str], keys: tuple[str, str]
) -> list[Artist]:
    """Draw a small mark a person and a large one a group."""
    handles: list[Artist] = []
    for group, style in zip(groups, LINES, strict=False):
        part = own[own["group"] == group]
        x, y = (part[key].to_numpy() for key in keys)
        marks: dict[str, Any] = {
            "marker": style.marker,
            "color": style.colour,
            "ls": "",
        }
        axes.plot(x, y, ms=1.8, mew=0, alpha=0.35, **marks)
        middle = [[np.median(v)] if v.size else [] for v in (x, y)]
        handles += axes.plot(
            *middle,
            ms=7,
            mec="w",
            mew=0.8,
            zorder=5,
            **marks,
        )
    return handles


def _colour_axes(axes: Axes, table: pd.DataFrame) -> None:
    """Give L* against b* its axes, and the classes of the typology angle."""
    axes.set(xlabel="b*", ylabel="L*")
    axes.set_xlim(0, 1.04 * table["b"].max())
    axes.set_ylim(0.9 * table["L"].min(), 1.04 * table["L"].max())
    (low, high), right = axes.get_ylim(), axes.get_xlim()[1]
    for angle in CLASSES:
        slope = np.tan(np.deg2rad(angle))
        end = min(right, ((high if angle > 0 else low) - 50) / slope)
        axes.plot([0, end], [50, 50 + slope * end], "-", color="0.6", lw=0.6)
        axes.annotate(
            f"{angle}°",
            (0.86 * end, 50 + 0.86 * slope * end),
            xytext=(2, -1 if angle > 0 else 1),
            textcoords="offset points",
            va="top" if angle > 0 else "bottom",
            fontsize=6,
            color="0.35",
        )


def _pigment_axes(axes: Axes, table: pd.DataFrame) -> None:
    """Give melanin against blood its axes, the same at all sites."""
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("melanin, w_m × D_e (µm)")
    axes.set_ylabel("blood fraction")
    axes.set_xticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
    axes.minorticks_off()
    melanin, blood = table["melanin_per_area_um"], table["blood_fraction"]
    axes.set_xlim(0.9 * melanin.min(), 1.1 * melanin.max())
    axes.set_ylim(0.9 * _LEAST, 1.2 * blood.max())
    axes.grid(visible=True, color="0.92", lw=0.6)


RECIPE = FigureRecipe(
    name="population",
    title="The people of the archive, by group and body site",
    sources=(ISSA, EFFECTIVE, COLOUR),
    data=data,
    draw=draw,
)
