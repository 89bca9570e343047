"""Skins of one colour under daylight and of two colours under other lights."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skinviz.spectra.adaptation import cat16_matrix
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab
from skinviz.view.gallery.boxes import BOXES, boxes_panel, quantiles_of
from skinviz.view.gallery.people import everyone, visible
from skinviz.view.gallery.recipe import (
    COLOUR,
    ISSA,
    FigureRecipe,
    Material,
    Settings,
)
from skinviz.view.page import Cells, Margins, in_cells, inches_of, lay_out
from skinviz.view.panels import wavelength_axis
from skinviz.view.spectra_panels import srgb_of
from skinviz.view.styles import LINES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MATCHED = "D65"
"""The light under which skins match."""

LIGHTS = ("A", "FL2", "FL11", "LED-B1", "LED-RGB1")
"""Others: a filament, a plain and a three-band fluorescent lamp, two white LEDs."""

MATCH = 0.5
"""ΔE00 up to which colours are said to match."""

_SRGB = ("srgb_r", "srgb_g", "srgb_b")
_SHOWN = 3  # pairs
_REACH = 2.0  # ΔE*ab beyond which no two skins are within MATCH of each other


def data(_: Settings) -> Material:
    """Return how far matching skins part, and the pairs that part most."""
    people = everyone()
    seen = visible(people.wavelengths)
    nm = people.wavelengths[seen]
    spectra = people.reflectance[..., seen].reshape(-1, nm.size)
    names = [f"{name} {site}" for name in people.names for site in people.sites]
    lab = {light: _lab(spectra, nm, light) for light in (MATCHED, *LIGHTS)}
    pairs = _matching(lab[MATCHED], np.arange(len(names)) // len(people.sites))
    apart = {
        light: delta_e_2000(own[pairs[:, 0]], own[pairs[:, 1]])
        for light, own in lab.items()
    }
    summary = pd.DataFrame(
        [{"light": light, **quantiles_of(own)} for light, own in apart.items()]
    )
    most = _most_apart(pairs, np.max([apart[light] for light in LIGHTS], axis=0))
    shown, curves = [], {"wavelength_nm": nm}
    for k, which in enumerate(most, 1):
        for side, record in zip("ab", pairs[which], strict=True):
            curves[f"{k}{side}"] = spectra[record]
            rows = [
                {
                    "pair": k,
                    "side": side,
                    "skin": names[record],
                    "light": light,
                    **dict(zip("Lab", own[record], strict=True)),
                    **_adapted(spectra[record], nm, light),
                    "delta_e_00": apart[light][which],
                }
                for light, own in lab.items()
            ]
            shown += rows
    caption = (
        f"{len(pairs)} pairs of skins of different people match under {MATCHED} (ΔE00 "
        f"≤ {MATCH:g}), of {len(names)} spectra. Left: how far they are apart under "
        f"other lights. {BOXES} The other panels show the {_SHOWN} pairs that part "
        "most, no skin twice, with both colours under each light as eyes used to it "
        "see them (CAT16), and their ΔE00. Part of such differences is of the "
        "instruments that measured them."
    )
    tables = {
        "": summary,
        "pairs": pd.DataFrame(shown),
        "spectra": pd.DataFrame(curves),
    }
    return Material(tables, caption)


def draw(material: Material, settings: Settings) -> Figure:
    """Draw the distribution, then a cell for each pair: spectra above colours."""
    page = lay_out(
        settings.width,
        [
            Cells(1 + _SHOWN, (1.5, 0.55), gap=0.52, least=1.5, margins=_AROUND),
        ],
        title=RECIPE.title,
        legend=["one skin of a pair", "the other"],
        caption=RECIPE.credit,
    )
    summary = material.table
    (boxes, unused), *cells = page.blocks[0]
    unused.set_axis_off()
    boxes_panel(boxes, summary, list(summary["light"]))
    boxes.set(title="all matching pairs", ylabel="ΔE00", ylim=(0, None))
    pairs, spectra = material.tables["pairs"], material.tables["spectra"]
    top = 1.05 * spectra.drop(columns="wavelength_nm").to_numpy().max()
    for k, (curves, colours) in enumerate(cells, 1):
        own = pairs[pairs["pair"] == k]
        for side, style in zip("ab", LINES, strict=False):
            curves.plot(
                spectra["wavelength_nm"], spectra[f"{k}{side}"], **style(len(spectra))
            )
        curves.set(title=f"pair {k}", ylabel="reflectance", ylim=(0, top))
        wavelength_axis(curves)
        _colours(colours, own)
    page.legend(curves.lines, ["one skin of a pair", "the other"])
    return page.figure


def _lab(spectra: Array, nm: Array, light: str) -> Array:
    """Return L*a*b* under a light, whose white is the white."""
    white = spectrum_to_xyz(np.ones(nm.size), nm, light)
    return xyz_to_lab(spectrum_to_xyz(spectra, nm, light), white)


def _adapted(spectrum: Array, nm: Array, light: str) -> dict[str, float]:
    """Return sRGB of a spectrum under a light, to which the eye has adapted."""
    white, daylight = (
        spectrum_to_xyz(np.ones(nm.size), nm, name) for name in (light, MATCHED)
    )
    xyz = spectrum_to_xyz(spectrum, nm, light) @ cat16_matrix(white, daylight).T
    return dict(zip(_SRGB, srgb_of(xyz).tolist(), strict=True))


def _matching(lab: Array, persons: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return pairs (k, 2) of different people whose colours match, in order."""
    from scipy.spatial import KDTree

    near = KDTree(lab).query_pairs(_REACH, output_type="ndarray")
    near = near[persons[near[:, 0]] != persons[near[:, 1]]]
    close = delta_e_2000(lab[near[:, 0]], lab[near[:, 1]]) <= MATCH
    found = near[close]
    return np.asarray(found[np.lexsort(found.T[::-1])])


def _most_apart(pairs: NDArray[np.int64], distance: Array) -> list[int]:
    """Return the pairs that are farthest apart, none of their skins twice."""
    chosen: list[int] = []
    used: set[int] = set()
    for k in np.argsort(-distance, kind="stable"):
        if not used & set(pairs[k].tolist()):
            chosen.append(int(k))
            used |= set(pairs[k].tolist())
        if len(chosen) == _SHOWN:
            break
    return chosen


def _colours(axes: Axes, own: pd.DataFrame) -> None:
    """Draw both colours of a pair, one above the other, under each light."""
    lights = list(own["light"].unique())
    sides = [own[own["side"] == side] for side in "ab"]
    rgb = np.stack([part[list(_SRGB)].to_numpy() for part in sides])
    axes.imshow(rgb, aspect="auto", extent=(0, len(lights), 0, 2))
    apart = sides[0]["delta_e_00"].to_numpy()
    ticks = np.arange(len(lights)) + 0.5
    told, size = in_cells(lights, inches_of(axes)[0], 6.5)
    axes.set_xticks(ticks, told, fontsize=size)
    for x, d in zip(ticks, apart, strict=True):
        axes.text(x, 1.5, f"{d:.1f}", ha="center", va="center", fontsize=6.5)
    axes.set_yticks([])
    axes.tick_params(length=0, pad=2)


_AROUND = Margins(bottom=0.36)

RECIPE = FigureRecipe(
    name="metamerism",
    title="Skins that match under daylight and not under other lights",
    sources=(ISSA, COLOUR),
    data=data,
    draw=draw,
)
