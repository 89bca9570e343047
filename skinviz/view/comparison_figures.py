"""Figures of a comparison: mean spectra, weights with their intervals, colours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.study.comparison import Cell, Comparison
from skinviz.study.quantities import Quantity
from skinviz.view.comparison_colours import colours_figure
from skinviz.view.comparison_levels import WIDTH, drawn, shortened, shown, title_of
from skinviz.view.page import STYLE, Cells, Margins, Page, lay_out
from skinviz.view.spectra_panels import (
    band_of,
    bands_panel,
)
from skinviz.view.styles import line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_NAMED = 0.062  # inches: width of a letter beside an axis
_BAR = 0.13  # inches: height of a stratum's line in a panel of means
_DOTTED = 24  # units that are drawn one by one


def comparison_figures(
    comparison: Comparison, caption: str, width: float = WIDTH
) -> dict[str, Figure]:
    """Return the figures of a comparison by name.

    Parameters
    ----------
    comparison : Comparison
        Of which the first ``MOST_SHOWN`` levels are drawn.
    caption : str
        Under each figure: where the data come from.
    width : float
        Of each figure. [inches]

    Returns
    -------
    figures : dict of str to Figure
        ``"spectra"``, ``"weights"`` and ``"colours"``.
    """
    makers: Mapping[str, Callable[..., Figure]] = {
        "spectra": spectra_figure,
        "weights": weights_figure,
        "colours": colours_figure,
    }
    return {name: make(comparison, caption, width) for name, make in makers.items()}


def spectra_figure(
    comparison: Comparison, caption: str = "", width: float = WIDTH
) -> Figure:
    """Return the mean spectrum of each level and its spread, a panel a stratum."""
    import matplotlib as mpl

    strata, levels = comparison.strata, shown(comparison)
    bands = comparison.study.spectra["wavelength"].values
    what = f"{comparison.unit}s"
    words = (
        f"Mean over {what}, shaded: ± one standard deviation between {what}; n is how "
        f"many {what}. {caption}"
    )
    with mpl.rc_context(STYLE):
        page = lay_out(
            width,
            [Cells(len(strata), (2.3,), least=2.3)],
            title=f"Spectra by {comparison.by}",
            legend=[shortened(level) for level in levels],
            caption=words,
        )
        highest = 0.0
        for stratum, axes in zip(strata, page.panels(), strict=True):
            for cell in drawn(comparison, stratum):
                name = f"{cell.level} (n = {len(cell.units)})"
                bands_panel(
                    axes,
                    bands,
                    [band_of(name, cell.spectra)],
                    first=levels.index(cell.level),
                )
            axes.set_title(title_of(stratum), parse_math=False)
            highest = max(highest, axes.dataLim.y1)
            _say_counts(axes, drawn(comparison, stratum))
        for axes in page.panels():
            axes.set_ylim(0, 1.04 * highest)
        _legend(page, levels)
    return page.figure


def weights_figure(
    comparison: Comparison, caption: str = "", width: float = WIDTH
) -> Figure:
    """Return the mean of each quantity by level with its interval, strata side by side.

    A panel a quantity; a line a stratum.
    """
    import matplotlib as mpl

    strata, levels = comparison.strata, shown(comparison)
    named = [shortened(level) for level in levels]
    margins = Margins(left=0.12 + _NAMED * max(map(len, named)), bottom=0.46)
    tall = 0.12 + len(levels) * max(_BAR * (len(strata) + 0.6), 0.2)
    names = [title_of(stratum) for stratum in strata] if len(strata) > 1 else []
    words = (
        f"Marks: mean over {comparison.unit}s with its 95 % t interval, which needs "
        f"two. Dots: the {comparison.unit}s, or of more than {_DOTTED} a thin line "
        f"from the 10 % to the 90 % quantile. {caption}"
    )
    with mpl.rc_context(STYLE):
        page = lay_out(
            width,
            [Cells(len(comparison.quantities), (tall,), least=1.7, margins=margins)],
            title=f"Fitted weights and colour by {comparison.by}",
            legend=[shortened(name) for name in names],
            caption=words,
        )
        for k, axes in enumerate(page.panels()):
            for s, stratum in enumerate(strata):
                offset = (s - (len(strata) - 1) / 2) / (len(strata) + 0.6)
                for cell in drawn(comparison, stratum):
                    _draw_mean(axes, cell, k, levels.index(cell.level) + offset, s)
            axes.set_yticks(range(len(levels)), named, parse_math=False)
            axes.set_ylim(len(levels) - 0.45, -0.55)
            axes.tick_params(axis="y", length=0)
            axes.grid(visible=True, axis="x", color="0.92", lw=0.6)
            axes.set_axisbelow(True)
            axes.locator_params(axis="x", nbins=4)
            axes.set_title(comparison.quantities[k].words, parse_math=False, size=7.5)
            axes.set_xlabel(_labelled(comparison.quantities[k]), labelpad=2)
        if names:
            _legend(page, names)
    return page.figure


def _draw_mean(axes: Axes, cell: Cell, k: int, at: float, style: int) -> None:
    """Draw one quantity of a cell: its units, their mean and the interval."""
    own, mean = line(style), cell.means[k]
    if mean.mean is None:
        return
    values = cell.values[np.isfinite(cell.values[:, k]), k]
    if values.size <= _DOTTED:
        level = np.full(values.size, at)
        axes.plot(values, level, ".", ms=2.5, color=own.colour, alpha=0.35)
    else:
        middle = np.quantile(values, (0.1, 0.9))
        axes.plot(middle, [at, at], "-", color=own.colour, lw=0.7, alpha=0.5)
    if mean.low is not None and mean.high is not None:
        axes.plot([mean.low, mean.high], [at, at], "-", color=own.colour, lw=2.2)
    axes.plot(
        mean.mean, at, own.marker, ms=4.0, mfc="w", mec=own.colour, mew=1.1, zorder=3
    )


def _say_counts(axes: Axes, cells: Sequence[Cell]) -> None:
    """Write how many units each curve is the mean of."""
    counts = [len(cell.units) for cell in cells]
    least, most = min(counts), max(counts)
    told = f"n = {least}" if least == most else f"n = {least}–{most}"
    axes.text(0.03, 0.96, told, transform=axes.transAxes, va="top", size=7)


def _legend(page: Page, names: Sequence[str]) -> None:
    """Draw the legend of the first styles."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            color=line(k).colour,
            linestyle=line(k).dashes,
            marker=line(k).marker,
            markersize=3.5,
            linewidth=1.2,
        )
        for k in range(len(names))
    ]
    page.legend(handles, [shortened(name) for name in names])
    for text in page.figure.legends[-1].get_texts():
        text.set_parse_math(False)  # a name may have a $


def _labelled(quantity: Quantity) -> str:
    """Return a quantity's name with its unit."""
    name = "w_m·D_e" if quantity.name == "w_m_depth" else quantity.name
    if not name.startswith("w_"):
        name = name.replace("_", " ")
    return name if quantity.unit == "1" else f"{name} ({quantity.unit})"
