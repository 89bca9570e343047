"""A figure of what ways to a picture cost and how far they are from the reference."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.tradeoff import Trade, front
from skinviz.rendering.ways import (
    GRID,
    ONE_KNOB,
    PLAIN_WAY,
    REFERENCE,
    TOLERANCE,
    UNIFORM,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_RC: dict[Any, Any] = {
    "font.size": 9,
    "axes.linewidth": 0.7,
    "legend.fontsize": 8,
    "svg.hashsalt": "skinviz",
}
_WIDTH, _PANEL = 13.2, 4.1  # inches: of the figure; height of a panel
_TITLE, _LINE = 0.22, 0.15  # inches: a line of the title, of the caption
_WORDS, _CAPTION = 0.095, 0.066  # inches: a letter of these
_PALE = 0.3  # opacity of what does not keep its edges

_KNOBS = (
    ("spectrum", "v", "#0072b2"),
    ("reflectance", "^", "#009e73"),
    ("arithmetic", "<", "#cc79a7"),
    ("bounce", ">", "#d55e00"),
    ("shadows", "s", "#56b4e9"),
    ("specular", "D", "#a37400"),
    ("shading", "p", "#e69f00"),
    ("sampling", "X", "#7a4fa3"),
)
_LIGHTEST, _DARKEST = 0.97, 0.05  # of the colours of tolerances
_FRONT = "0.35"


@dataclass(frozen=True)
class _Measure:
    """What a panel shows upwards: its words, the value, and what counts as none."""

    words: str
    value: Callable[[Trade], float]
    least: float
    told_least: str


def _filled(trade: Trade) -> float:
    """Return the 99th percentile."""
    return math.nan if trade.difference is None else trade.difference.filled


def _most(trade: Trade) -> float:
    """Return the maximum."""
    return math.nan if trade.difference is None else trade.difference.most_filled


def _spectral(trade: Trade) -> float:
    """Return the spectral error."""
    return math.nan if trade.spectral_rmse is None else trade.spectral_rmse


_MEASURES = (
    _Measure(
        r"$\Delta E_{00}$, 99th percentile of filled pixels", _filled, 1e-3, "< 0.001"
    ),
    _Measure(r"$\Delta E_{00}$, maximum of filled pixels", _most, 1e-3, "< 0.001"),
    _Measure("spectral RMSE (share of white)", _spectral, 1e-6, r"< $10^{-6}$"),
)


def tradeoff_figure(trades: Sequence[Trade], title: str, caption: str) -> Figure:
    """Return time against colour and spectral error, a panel each, log by log.

    Parameters
    ----------
    trades : sequence of Trade
        What was measured of one scene.
    title, caption : str
        Printed above and below, wrapped.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    had = [trade for trade in trades if trade.ms is not None]
    above = textwrap.wrap(title, int((_WIDTH - 0.2) / _WORDS))
    below = textwrap.wrap(caption, int((_WIDTH - 0.2) / _CAPTION))
    top, bottom = 0.3 + _TITLE * len(above), 0.72 + _LINE * len(below)
    height = top + _PANEL + bottom
    with mpl.rc_context(_RC):
        figure = Figure(figsize=(_WIDTH, height), dpi=150)
        grid = figure.add_gridspec(
            1,
            4,
            left=0.85 / _WIDTH,
            right=1 - 0.1 / _WIDTH,
            top=1 - top / height,
            bottom=bottom / height,
            wspace=0.36,
            width_ratios=(1, 1, 1, 0.66),
        )
        for column, measure in enumerate(_MEASURES):
            axes = figure.add_subplot(grid[0, column])
            _panel(axes, had, measure, allowed=column == 0)
        _legend(figure.add_subplot(grid[0, 3]), had)
        for lines, y, how in (
            (above, height - 0.12, {"fontsize": 11}),
            (below, 0.1 + _LINE * len(below), {"fontsize": 7.5, "color": "0.35"}),
        ):
            figure.text(
                0.1 / _WIDTH,
                y / height,
                "\n".join(lines),
                va="top",
                parse_math=False,
                **how,
            )
    return figure


def _panel(
    axes: Axes, trades: Sequence[Trade], measure: _Measure, *, allowed: bool
) -> None:
    """Draw one measure of all ways over their times."""
    ms = np.array([trade.ms for trade in trades], dtype=np.float64)
    values = np.array([measure.value(trade) for trade in trades])
    floor = measure.least / 2
    shown = np.where(values < measure.least, floor, values)
    axes.set_xscale("log")
    axes.set_yscale("log")
    planned = [t.way.planning + ms[i] for i, t in enumerate(trades)]
    known = values[np.isfinite(values)]
    highest = max(known.max(initial=0.0), 10 * measure.least)
    if known.size == 0:
        axes.text(0.5, 0.5, "cannot be had", transform=axes.transAxes, ha="center")
    if allowed:
        highest = max(highest, *(t.way.tolerance or 0.0 for t in trades))
    axes.set_xlim(*_widened(float(ms.min()), float(max(planned))))
    axes.set_ylim(floor / 1.6, 1.7 * highest)
    axes.axhspan(floor / 1.6, measure.least, color="0.93", lw=0, zorder=0)
    _ticks(axes, measure)
    _draw_front(axes, trades, ms, values, shown)
    _draw_uniform(axes, trades, ms, shown)
    for i, trade in enumerate(trades):
        if trade.way.group == TOLERANCE:
            _draw_planned(axes, trades, i, shown[i], allowed=allowed)
        else:
            axes.plot(ms[i], shown[i], **_style(trade), clip_on=False)
    axes.set_xlabel("time of a picture (ms)")
    axes.set_ylabel(measure.words, labelpad=2)
    axes.grid(visible=True, which="major", color="0.92", lw=0.6)
    axes.set_axisbelow(True)


def _draw_front(
    axes: Axes, trades: Sequence[Trade], ms: Array, values: Array, shown: Array
) -> None:
    """Draw the stairs below which no way is that keeps its edges."""
    kept = np.array([trade.edges_kept for trade in trades])
    on_it = np.flatnonzero(front(np.where(kept, ms, np.nan), values))
    on_it = on_it[np.argsort(ms[on_it])]
    if on_it.size == 0:
        return
    x = np.append(ms[on_it], axes.get_xlim()[1])
    y = np.append(shown[on_it], shown[on_it[-1:]])
    axes.step(x, y, where="post", color=_FRONT, lw=1.0, zorder=1.5)


def _draw_uniform(axes: Axes, trades: Sequence[Trade], ms: Array, shown: Array) -> None:
    """Join the pictures that have as many rays in each pixel."""
    which = [i for i, t in enumerate(trades) if t.way.group in (UNIFORM, REFERENCE)]
    which.sort(key=lambda i: trades[i].way.plan.samples)
    axes.plot(ms[which], shown[which], ":", color="0.2", lw=0.9, zorder=1.4)


def _draw_planned(
    axes: Axes, trades: Sequence[Trade], i: int, y: float, *, allowed: bool
) -> None:
    """Draw a plan's choice, what planning it took, and what it was allowed."""
    trade = trades[i]
    colour, ms = _colours(trades)[trade.way.tolerance], float(trade.ms or 0.0)
    both = [ms, ms + trade.way.planning]
    axes.plot(both, [y, y], "-|", markevery=[1], ms=6, color=colour, lw=0.9, zorder=3)
    if allowed and trade.way.tolerance is not None:
        axes.plot(
            [ms, ms], [y, trade.way.tolerance], "-", color=colour, lw=1.2, zorder=3
        )
        axes.plot(ms, trade.way.tolerance, "_", color=colour, ms=9, mew=2, zorder=3)
    # Of plans that are the same, the tighter tolerance lies within the looser.
    alike = [t for t in trades if t.way.group == TOLERANCE and t.ms == trade.ms]
    rank = [t.way.tolerance for t in alike].index(trade.way.tolerance)
    axes.plot(
        *(ms, y, "o"),
        ms=7.5 + 2.6 * rank,
        mfc=colour,
        mec="k",
        mew=0.7,
        zorder=6 - 0.1 * rank,
        clip_on=False,
    )


def _style(trade: Trade) -> dict[str, Any]:
    """Return how a way is drawn that was not planned."""
    pale = 1.0 if trade.edges_kept else _PALE
    group = trade.way.group
    if group == ONE_KNOB:
        return {**_knob_style(trade.way.name.split(":", 1)[0]), "alpha": pale}
    return {**_OTHERS[group], "alpha": pale}


_OTHERS: dict[str, dict[str, Any]] = {
    REFERENCE: {"marker": "*", "ms": 13, "mfc": "k", "mec": "w", "ls": "", "zorder": 5},
    PLAIN_WAY: {"marker": "P", "ms": 9, "mfc": "k", "mec": "w", "ls": "", "zorder": 5},
    UNIFORM: {"marker": "s", "ms": 5, "mfc": "w", "mec": "k", "ls": "", "zorder": 4},
    GRID: {"marker": "o", "ms": 3, "mfc": "0.55", "mec": "none", "ls": "", "zorder": 2},
}


def _knob_style(name: str) -> dict[str, Any]:
    """Return how ways are drawn that differ in one knob."""
    markers = {knob: (marker, colour) for knob, marker, colour in _KNOBS}
    marker, colour = markers.get(name, ("h", "0.4"))
    return {"marker": marker, "ms": 5.5, "mfc": colour, "mec": "w", "mew": 0.4} | {
        "ls": "",
        "zorder": 3,
    }


def _colours(trades: Sequence[Trade]) -> dict[float | None, Any]:
    """Return a colour for each tolerance, from dark (tight) to light (loose)."""
    from matplotlib import colormaps

    tolerances = sorted({t.way.tolerance for t in trades if t.way.tolerance})
    shades = np.linspace(_DARKEST, _LIGHTEST, max(len(tolerances), 2))
    colours = colormaps["viridis"](shades)
    return dict(zip(tolerances, colours, strict=False))


def _legend(axes: Axes, trades: Sequence[Trade]) -> None:
    """Say what the marks are, beside the panels."""
    from matplotlib.lines import Line2D

    def mark(words: str, **style: Any) -> Artist:
        return Line2D([], [], label=words, **style)

    axes.set_axis_off()
    groups = {trade.way.group for trade in trades}
    knobs = {t.way.name.split(":", 1)[0] for t in trades if t.way.group == ONE_KNOB}
    marks = [mark("Pareto front, edges kept", color=_FRONT, lw=1.0)]
    for group, words in (
        (REFERENCE, "the reference"),
        (PLAIN_WAY, "the plain way"),
        (UNIFORM, "1, 2, 4, 8 rays a pixel"),
        (GRID, "rays × contrast"),
    ):
        if group in groups:
            marks.append(mark(words, **_OTHERS[group]))
    marks += [
        mark(f"one knob cheaper: {knob}", **_knob_style(knob))
        for knob, *_ in _KNOBS
        if knob in knobs
    ]
    marks += [
        mark(
            rf"plan for $\Delta E_{{00}}$ {tolerance:g}",
            marker="o",
            ms=8,
            mfc=colour,
            mec="k",
            mew=0.7,
            ls="",
        )
        for tolerance, colour in _colours(trades).items()
    ]
    if TOLERANCE in groups:
        marks.append(mark("its planning on top", color="0.35", marker="|", lw=0.9))
        marks.append(
            mark("what it was allowed", color="0.35", marker="_", ls="", mew=2)
        )
    pale = {**_OTHERS[UNIFORM], "alpha": _PALE}
    marks.append(mark("pale: edges not kept", **pale))
    axes.legend(
        handles=marks,
        loc="upper left",
        bbox_to_anchor=(-0.2, 1.02),
        frameon=False,
        labelspacing=0.55,
        handlelength=1.6,
    )


def _widened(low: float, high: float) -> tuple[float, float]:
    """Return limits around times, at least a factor of ten apart."""
    low, high = low / 1.35, high * 1.35
    wider = max(1.0, math.sqrt(10 * low / high))
    return low / wider, high * wider


def _ticks(axes: Axes, measure: _Measure) -> None:
    """Put few round numbers on both axes, and a word where there is no error."""
    x = _round_numbers(*axes.get_xlim(), most=6)
    axes.set_xticks(x, [_told(tick) for tick in x])
    low, high = measure.least, axes.get_ylim()[1]
    y = [tick for tick in _round_numbers(low, high, most=8) if tick > 1.5 * low]
    labels = [_told(tick) for tick in y]
    axes.set_yticks([measure.least / 2, *y], [measure.told_least, *labels])
    axes.minorticks_off()


def _told(tick: float) -> str:
    """Return a round number in words, a long one as a power of ten."""
    if 1e-3 <= tick < 1e5:
        return f"{tick:g}"
    digit, power = f"{tick:.0e}".split("e")
    times = "" if digit == "1" else rf"{digit}\cdot"
    return f"${times}10^{{{int(power)}}}$"


def _round_numbers(low: float, high: float, most: int) -> list[float]:
    """Return at most so many numbers that are round, evenly spread by their ratio."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    ticks: list[float] = []
    for digits, step in (((1, 2, 5), 1), ((1, 3), 1), *(((1,), k) for k in (1, 2, 3))):
        ticks = [
            digit * 10.0**power
            for power in range(first, last + 1, step)
            for digit in digits
        ]
        ticks = [tick for tick in ticks if low <= tick <= high]
        if len(ticks) <= most:
            break
    return ticks
