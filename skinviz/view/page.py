"""Figures laid out in inches: words keep their size, panels share what is left.

From the top: title, legend, blocks of panels, caption. The width is given, the height
follows. Margins and letters are fixed, so that nothing overlaps at any width; where
panels would become too narrow, there are fewer in a row.

What does not belong here: what panels show (``panels`` and its neighbours).
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from skinviz._validate import in_range

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLE: dict[Any, Any] = {
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8,
    "axes.linewidth": 0.7,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "svg.hashsalt": "skinviz",  # the same figure, the same file
}
"""Matplotlib's settings for all that is drawn on a page: use ``rc_context``."""

NARROWEST, WIDEST = 1.9, 40.0
"""Widths that a page may have. [inches]"""

EDGE = 0.08
"""Air around a page. [inches]"""

DOTS = 150
"""Dots per inch on the screen; files say their own."""

_TITLE, _TITLE_LETTER = 0.185, 0.078  # inches: a line; mean width of a letter
_CAPTION, _CAPTION_LETTER = 0.13, 0.055
_ROW, _LEGEND_LETTER, _HANDLE = 0.175, 0.06, 0.62  # inches: of the legend
_OF_THE_FONT = 1.164  # its own distance of lines, in sizes
_EM = 0.62  # mean width of a letter, in sizes
_NARROW = 0.4  # inches: a panel is never narrower


@dataclass(frozen=True)
class Margins:
    """Room around a cell for its words. [inches]"""

    left: float = 0.6
    right: float = 0.14
    top: float = 0.26
    bottom: float = 0.5


@dataclass(frozen=True)
class Cells:
    """A block of equal cells, each a stack of panels; cells that do not fit wrap.

    Attributes
    ----------
    n : int
        How many cells.
    heights : tuple of float
        Of a cell's panels, from the top. [inches]; negative: in panel widths
    gap : float or tuple of float
        Between the panels of a cell, the same or each. [inches]
    least : float
        Width of a panel under which there are fewer cells in a row. [inches]
    margins : Margins
        Around each cell.
    most : int, optional
        Cells in a row; as many as fit if not said.
    indent : float
        Room left free at the left of the block. [inches]
    """

    n: int
    heights: tuple[float, ...] = (2.0,)
    gap: float | tuple[float, ...] = 0.12
    least: float = 1.9
    margins: Margins = Margins()
    most: int | None = None
    indent: float = 0.0

    @property
    def gaps(self) -> tuple[float, ...]:
        """What is left free under each panel of a cell but the last. [inches]"""
        if isinstance(self.gap, tuple):
            return self.gap
        return (self.gap,) * (len(self.heights) - 1)

    def columns(self, room: float) -> int:
        """Return how many cells stand side by side in some inches."""
        cell = self.least + self.margins.left + self.margins.right
        fitting = max(int((room - self.indent + 1e-9) / cell), 1)
        columns = min(fitting, self.most or self.n, self.n)
        # Rows of like length look better than full ones and a rest.
        return -(-self.n // -(-self.n // columns))

    def sizes(self, room: float) -> tuple[float, tuple[float, ...]]:
        """Return the width and the heights of a cell's panels in some inches."""
        cell = (room - self.indent) / self.columns(room)
        own = cell - self.margins.left - self.margins.right
        width = max(own, _NARROW)
        return width, tuple(h if h >= 0 else -h * width for h in self.heights)

    def height(self, room: float) -> float:
        """Return the height of the block in some inches of width."""
        rows = -(-self.n // self.columns(room))
        stack = sum(self.sizes(room)[1]) + sum(self.gaps)
        return rows * (self.margins.top + stack + self.margins.bottom)

    def boxes(self, room: float) -> Iterator[list[tuple[float, float, float, float]]]:
        """Yield each cell's boxes: left, top, width and height from the block's."""
        columns, (width, heights) = self.columns(room), self.sizes(room)
        rows = -(-self.n // columns)
        for i in range(self.n):
            row, column = divmod(i, columns)
            cell = (room - self.indent) / columns
            left = self.indent + column * cell + self.margins.left
            top = row * self.height(room) / rows + self.margins.top
            stack = []
            for tall, free in zip(heights, (*self.gaps, 0.0), strict=True):
                stack.append((left, top, width, tall))
                top += tall + free
            yield stack


@dataclass(frozen=True, eq=False)
class Page:
    """A figure whose panels are laid out.

    Attributes
    ----------
    figure : Figure
        With title and caption.
    blocks : tuple of tuple of tuple of Axes
        Of each block, its cells, and their panels from the top.
    legend_at : (float, float)
        Upper left corner of the legend. [share of the figure]
    legend_columns : int
        How many entries of the legend fit side by side.
    """

    figure: Figure
    blocks: tuple[tuple[tuple[Axes, ...], ...], ...]
    legend_at: tuple[float, float]
    legend_columns: int

    def panels(self, block: int = 0, panel: int = 0) -> list[Axes]:
        """Return one panel of every cell of a block."""
        return [cell[panel] for cell in self.blocks[block]]

    def legend(self, handles: Sequence[Artist], labels: Sequence[str]) -> None:
        """Draw the legend that room was left for."""
        self.figure.legend(
            handles,
            labels,
            ncols=self.legend_columns,
            loc="upper left",
            bbox_to_anchor=self.legend_at,
            frameon=False,
            borderpad=0,
            borderaxespad=0,
            handlelength=3.2,
            labelspacing=0.4,
            columnspacing=1.0,
        )


def lay_out(
    width: float,
    blocks: Sequence[Cells],
    *,
    title: str = "",
    legend: Sequence[str] = (),
    caption: str = "",
) -> Page:
    """Return a figure with title and caption, and empty panels.

    Call it, and draw, within ``matplotlib.rc_context(STYLE)``.

    Parameters
    ----------
    width : float
        Of the figure. [inches], 1.9 to 40
    blocks : sequence of Cells
        From the top.
    title, caption : str
        Printed above and below, wrapped; line breaks are kept.
    legend : sequence of str
        The labels for which to leave room under the title.
    """
    from matplotlib.figure import Figure

    in_range(width, NARROWEST, WIDEST, "the width of a figure", "inches")
    room = width - 2 * EDGE
    above = _wrapped(title, room, _TITLE_LETTER)
    below = _wrapped(caption, room, _CAPTION_LETTER)
    columns = _legend_columns(legend, room)
    tops = [EDGE + (_TITLE * len(above) + 0.05 if above else 0)]
    tops.append(tops[-1] + (_ROW * -(-len(legend) // columns) + 0.06 if legend else 0))
    for block in blocks:
        tops.append(tops[-1] + block.height(room))
    height = tops[-1] + _CAPTION * len(below) + EDGE
    figure = Figure(figsize=(width, height), dpi=DOTS)

    def axes_at(left: float, top: float, wide: float, tall: float) -> Axes:
        low = 1 - (top + tall) / height
        box = ((EDGE + left) / width, low, wide / width, tall / height)
        return figure.add_axes(box)

    made = tuple(
        tuple(
            tuple(axes_at(x, start + y, w, h) for x, y, w, h in stack)
            for stack in block.boxes(room)
        )
        for block, start in zip(blocks, tops[1:], strict=False)
    )
    write(figure, above, (EDGE, EDGE), _TITLE, fontsize=10)
    write(figure, below, (EDGE, tops[-1]), _CAPTION, fontsize=7, color="0.35")
    legend_at = (EDGE / width, 1 - tops[0] / height)
    return Page(figure, made, legend_at, columns)


def write(
    figure: Figure,
    lines: Sequence[str],
    at: tuple[float, float],
    line: float,
    *,
    fontsize: float,
    **how: Any,
) -> None:
    """Write lines, their upper left corner some inches from the figure's."""
    if lines:
        width, height = figure.get_size_inches()
        figure.text(
            at[0] / width,
            1 - at[1] / height,
            "\n".join(lines),
            va="top",
            parse_math=False,
            fontsize=fontsize,
            linespacing=line * 72 / fontsize / _OF_THE_FONT,
            **how,
        )


def align_ylabels(panels: Sequence[Axes], distance: float = 0.46) -> None:
    """Set the labels of upward axes some inches to the left of their panels."""
    for axes in panels:
        axes.yaxis.set_label_coords(-distance / inches_of(axes)[0], 0.5)


def inches_of(axes: Axes) -> tuple[float, float]:
    """Return the width and height of axes in inches."""
    box, across = axes.get_position(), axes.figure.dpi_scale_trans.inverted()
    width, height = across.transform(axes.figure.bbox.size)
    return float(box.width * width), float(box.height * height)


def fitting_size(lines: Sequence[str], width: float, largest: float) -> float:
    """Return the letters' size [points] at which lines fit into some inches."""
    letters = max(map(len, lines), default=0)
    return min(largest, width * 72 / (_EM * max(letters, 1)))


def in_cells(
    labels: Sequence[str], width: float, size: float
) -> tuple[list[str], float]:
    """Return labels wrapped so that they stand side by side, and their letters' size.

    Parameters
    ----------
    labels : sequence of str
        One line each.
    width : float
        That they share. [inches]
    size : float
        Of letters, at most. [points]
    """
    room = 0.94 * width / len(labels)
    letters = max(int(room * 72 / (_EM * size)), 7)
    told = ["\n".join(textwrap.wrap(label, letters)) for label in labels]
    lines = [line for label in told for line in label.splitlines()]
    return told, fitting_size(lines, room, size)


def _legend_columns(labels: Sequence[str], room: float) -> int:
    """Return how many entries of a legend fit side by side."""
    entry = _HANDLE + _LEGEND_LETTER * max(map(len, labels), default=0)
    return min(max(int(room / entry), 1), max(len(labels), 1))


def _wrapped(text: str, width: float, letter: float) -> list[str]:
    """Return the lines of a text in some inches, its own breaks kept."""
    letters = max(int(width / letter), 12)
    return [line for part in text.splitlines() for line in textwrap.wrap(part, letters)]
