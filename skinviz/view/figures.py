"""Whole figures: hands beside their spectra, body sites side by side."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz._validate import one_of
from skinviz.rendering.render import Rendering
from skinviz.rendering.shade import VertexSpectrum
from skinviz.skin.skin_fit import SkinFit
from skinviz.view import panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_TIME_STAMPS = {".png": "Software", ".svg": "Date", ".pdf": "CreationDate"}
_STYLE: dict[Any, Any] = {"font.size": 9, "axes.linewidth": 0.7, "legend.fontsize": 8}


@dataclass(frozen=True)
class Site:
    """A measured body site and its fit."""

    name: str
    measured: Array
    fit: SkinFit


@dataclass(frozen=True, eq=False)
class MarkedPoint:
    """A point of a hand and the light that it sends.

    Attributes
    ----------
    point : (3,) ndarray
        [mm]
    spectrum : VertexSpectrum
        Its radiance.
    picture : str
        Title of the picture in which it is drawn; "" for all.
    """

    point: Array
    spectrum: VertexSpectrum
    picture: str = ""


def hands_figure(
    pictures: Mapping[str, Rendering],
    site: Site | None,
    marks: Sequence[MarkedPoint],
    caption: str,
) -> Figure:
    """Return hands under several lights beside the spectra behind them.

    Parameters
    ----------
    pictures : mapping of str to Rendering
        Title and picture, left to right; all of one view.
    site : Site or None
        The measured spectrum and its fit, where there is one.
    marks : sequence of MarkedPoint
        One, called P, or two, A and B; none are drawn without.
    caption : str
        Printed below: what it is and where the data come from.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = "P" if len(marks) == 1 else "AB"
    with mpl.rc_context(_STYLE):
        tall = site is not None and len(marks) > 1
        beside = site is not None or bool(marks)
        width = 13.2 if beside else min(max(7.0, 4.4 * len(pictures)), 13.2)
        figure = Figure(figsize=(width, 8.6 if tall else 6.6), dpi=150)
        hands = figure.add_gridspec(
            1,
            len(pictures),
            left=0.012,
            right=0.655 if beside else 0.988,
            top=0.93,
            bottom=0.095,
            wspace=0.02,
        )
        for column, (title, picture) in enumerate(pictures.items()):
            axes = figure.add_subplot(hands[0, column])
            axes.imshow(picture.rgb, interpolation="antialiased")
            axes.set_title(title, parse_math=False)
            axes.set_axis_off()
            for name, mark in zip(names, marks, strict=False):
                if mark.picture in ("", title):
                    _mark(axes, picture.view.project(mark.point), name)
        if beside:
            _spectra_beside(figure, site, dict(zip(names, marks, strict=False)))
        figure.text(
            0.012,
            0.028,
            caption,
            fontsize=7.5,
            color="0.35",
            va="center",
            parse_math=False,
        )
    return figure


def _mark(axes: Axes, place: Array, name: str) -> None:
    """Draw a ring and a letter at a place of a picture. [pixels]"""
    # imshow counts from the middles of pixels, a picture from their edges.
    at = (place[0] - 0.5, place[1] - 0.5)
    axes.plot(*at, "o", ms=9, mfc="none", mec="w", mew=1.6)
    axes.plot(*at, "o", ms=11, mfc="none", mec="k", mew=0.7)
    axes.annotate(
        name,
        at,
        xytext=(9, 7),
        textcoords="offset points",
        color="w",
        fontweight="bold",
    )


def _spectra_beside(
    figure: Figure, site: Site | None, marks: Mapping[str, MarkedPoint]
) -> None:
    """Draw the measured spectrum and the marks' radiance, one below the other."""
    heights = [] if site is None else [1.5, 0.8]
    for _ in marks:
        gap = 0.12 if len(marks) == 1 else 0.3
        heights += [gap, 1.2] if heights else [1.2]
    sides = figure.add_gridspec(
        len(heights),
        1,
        left=0.72,
        right=0.985,
        top=0.93,
        bottom=0.135,
        hspace=0.3,
        height_ratios=heights,
    )
    panels_drawn = [] if site is None else _site_beside(figure, sides, site)
    for i, (name, mark) in enumerate(marks.items()):
        row = len(heights) - 1 - 2 * (len(marks) - 1 - i)
        axes = figure.add_subplot(sides[row])
        panels.radiance_panel(axes, mark.spectrum)
        axes.set_title(f"radiance at {name}")
        panels_drawn.append(axes)
    figure.align_ylabels(panels_drawn)


def _site_beside(figure: Figure, sides: Any, site: Site) -> list[Axes]:
    """Draw a measured spectrum, its fit and their difference."""
    first = figure.add_subplot(sides[0])
    panels.reflectance_panel(first, site.measured, site.fit)
    first.set_title(f"{site.name}: measured and fitted", parse_math=False)
    second = figure.add_subplot(sides[1])
    panels.residual_panel(second, site.measured, site.fit)
    second.set_title(
        f"SSE × 61/{int(site.fit.n_bands)} = "
        f"{float(site.fit.sse_61):.4f},   "
        f"RMSE {float(site.fit.rmse):.4f},   "
        rf"$\Delta E_{{00}}$ {float(site.fit.delta_e):.2f}",
        fontsize=8.5,
    )
    return [first, second]


def sites_figure(sites: Sequence[Site], title: str, caption: str) -> Figure:
    """Return one column a body site: spectra, residual and colour, as in fig. 7.

    Parameters
    ----------
    sites : sequence of Site
        Measured spectra and their fits.
    title, caption : str
        Printed above and below.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(_STYLE):
        width = 0.9 + 3.5 * len(sites)
        figure = Figure(figsize=(width, 6.6), dpi=150)
        grid = figure.add_gridspec(
            4,
            len(sites),
            left=0.85 / width,
            right=1 - 0.25 / width,
            top=0.87,
            bottom=0.09,
            hspace=0.25,
            wspace=0.28,
            height_ratios=(1.9, 0.9, 0.12, 0.4),  # the third is a gap
        )
        top = 1.35 * max(float(np.nanmax(site.measured)) for site in sites)
        spread = 1.15 * max(
            float(np.nanmax(np.abs(site.measured - site.fit.fitted))) for site in sites
        )
        for column, site in enumerate(sites):
            curves = figure.add_subplot(grid[0, column])
            panels.reflectance_panel(curves, site.measured, site.fit)
            curves.set_ylim(0, top)
            curves.set_title(site.name, parse_math=False)
            residual = figure.add_subplot(grid[1, column])
            panels.residual_panel(residual, site.measured, site.fit)
            residual.set_ylim(-spread, spread)
            residual.set_title(
                f"SSE × 61/{int(site.fit.n_bands)} = {float(site.fit.sse_61):.4f}",
                fontsize=8.5,
            )
            _swatches(figure.add_subplot(grid[3, column]), site)
        figure.suptitle(title, fontsize=11, y=0.965, parse_math=False)
        figure.text(
            0.1 / width,
            0.018,
            caption,
            fontsize=7.5,
            color="0.35",
            va="center",
            parse_math=False,
        )
    return figure


def save_figure(
    figure: Figure, path: str | os.PathLike[str], *, dots: float | None = None
) -> Path:
    """Write a figure as PNG, SVG or PDF, whole or not at all, with no time stamp.

    ``dots`` per inch of a PNG; the figure's own if not said.
    """
    import matplotlib as mpl

    file = Path(path)
    suffix = one_of(file.suffix.lower(), _TIME_STAMPS, "suffix of a figure")
    with whole_file(file) as partial, mpl.rc_context({"svg.hashsalt": "skinviz"}):
        figure.savefig(
            partial, metadata={_TIME_STAMPS[suffix]: None}, dpi=dots or "figure"
        )
    return file


def _swatches(axes: Axes, site: Site) -> None:
    """Draw the measured and the fitted colour edge to edge."""
    measured, fitted = panels.swatch_colours(site.fit, site.measured)
    axes.imshow([[measured, fitted]], aspect="auto", extent=(0, 2, 0, 1))
    axes.set_xticks([0.5, 1.5], ["measured", "fitted"])
    axes.set_yticks([])
    axes.tick_params(length=0)
    axes.set_title(
        rf"D65, $\Delta E_{{00}}$ {float(site.fit.delta_e):.2f}", fontsize=8.5
    )
