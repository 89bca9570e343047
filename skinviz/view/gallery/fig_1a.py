"""Fig. 1(a): spectral reflectance of skin at several sites of the body."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.spectra.archive_selection import people
from skinviz.study.tables import SITES
from skinviz.view.gallery.people import (
    averaged,
    everyone,
    name_of,
    subjects,
    visible,
)
from skinviz.view.gallery.recipe import (
    COLOUR,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)
from skinviz.view.page import Cells, lay_out
from skinviz.view.spectra_panels import Band, band_of, bands_panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SUBJECT = "A"


def data(_: Settings) -> Material:
    """Return the spectra of one person, and means over everyone, by site."""
    archive = averaged()
    nm = archive["wavelength"].to_numpy()
    seen = visible(nm)
    spectra = archive["reflectance"].to_numpy()[:, seen]
    names, site_of = people(archive), archive["site"].to_numpy().astype(str)
    own = names == everyone().names[subjects()[_SUBJECT]]
    others = [s for s in dict.fromkeys(site_of[own]) if s not in SITES]
    rows = []
    for site in (*SITES, *others):
        here = site_of == site
        band = band_of(site, spectra[here])
        middle, high = band.middle, band.high
        rows.append(
            pd.DataFrame(
                {
                    "site": site,
                    "wavelength_nm": nm[seen],
                    f"subject_{_SUBJECT}": spectra[here & own][0],
                    "people": int(here.sum()),
                    "mean": middle,
                    "standard_deviation": np.nan if high is None else high - middle,
                }
            )
        )
    caption = (
        f"Left: subject {_SUBJECT}, {name_of(_SUBJECT)}, at every site that was "
        "measured. Right: mean ± standard deviation over everyone who was measured at "
        "the paper's four sites. The surface reflection is included (a sphere with its "
        "specular port closed); the paper's spectra exclude it."
    )
    return Material({"": pd.concat(rows, ignore_index=True)}, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw one person's sites, and everyone's."""
    table = material.table
    sites = {str(s): table[table["site"] == s] for s in table["site"].unique()}
    nm = table["wavelength_nm"].unique()
    page = lay_out(
        settings.width,
        [Cells(2, (2.3,))],
        title=RECIPE.title,
        legend=list(sites),
        caption=RECIPE.credit,
    )
    one, all_people = page.panels()
    bands = [
        Band(site, own[f"subject_{_SUBJECT}"].to_numpy()) for site, own in sites.items()
    ]
    page.legend(bands_panel(one, nm, bands), list(sites))
    one.set_title(f"one person, {len(sites)} sites")
    bands_panel(all_people, nm, [_spread(site, sites[site]) for site in SITES])
    counts = [sites[site]["people"].iloc[0] for site in SITES]
    all_people.set_title(f"{min(counts)} to {max(counts)} people")
    top = max(axes.get_ylim()[1] for axes in page.panels())
    for axes in page.panels():
        axes.set_ylim(0, top)
    return page.figure


def _spread(site: str, own: pd.DataFrame) -> Band:
    """Return mean ± standard deviation as a curve with its spread."""
    mean, away = own["mean"].to_numpy(), own["standard_deviation"].to_numpy()
    return Band(site, mean, mean - away, mean + away)


RECIPE = FigureRecipe(
    name="1a",
    title="Fig. 1a: reflectance of skin at several sites of the body",
    sources=(ISSA, COLOUR),
    data=data,
    draw=draw,
)
