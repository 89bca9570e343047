"""A panel of colour differences between each two of some skins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from skinviz.study.comparison import ColourDifference
from skinviz.view.page import Cells, Margins, fitting_size, inches_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LETTER = 0.062  # inches: width of a letter beside the panel
_WIDE, _TALL, _LEAST = 0.5, 0.36, 2.0  # inches: a cell; a panel's width
_LARGEST = 7.5  # points
_LEVEL = 4, 13  # columns, and letters of names, that are written level at most
_DARK = 0.55  # of the colour scale, from where words are white


def matrix_cells(n: int, names: Sequence[str]) -> Cells:
    """Return room for n panels, with the names at their left and below."""
    words = 0.12 + _LETTER * max(map(len, names))
    below = words if _upright(names) else 0.2
    return Cells(
        n,
        (_TALL * len(names),),
        least=max(_LEAST, _WIDE * len(names)),
        margins=Margins(left=words, right=0.15, top=0.3, bottom=below + 0.08),
    )


def delta_e_matrix(
    axes: Axes,
    differences: Sequence[ColourDifference],
    levels: Sequence[str],
    names: Sequence[str],
) -> None:
    """Draw ΔE00 of each pair: measured above the diagonal, fitted below it.

    Parameters
    ----------
    axes : Axes
        From :func:`matrix_cells`.
    differences : sequence of ColourDifference
        Of one stratum.
    levels, names : sequence of str
        The rows, which are the columns too, and what is written beside them.
    """
    n = len(levels)
    values = np.full((n, n), np.nan)
    words = [["" for _ in levels] for _ in levels]
    for own in differences:
        i, j = sorted((levels.index(own.first), levels.index(own.second)))
        values[i, j], words[i][j] = own.delta_e, f"{own.delta_e:.2f}"
        values[j, i] = own.fitted
        if np.isfinite(own.fitted):
            words[j][i] = f"{own.fitted:.2f}"
            if np.isfinite([own.low, own.high]).all():
                words[j][i] += f"\n{own.low:.2f}–{own.high:.2f}"
    shown = np.ma.masked_invalid(values)
    top = max(float(shown.max()) if shown.count() else 1.0, 1.0)
    axes.imshow(shown, cmap="Blues", vmin=0, vmax=1.25 * top, aspect="auto")
    width, _ = inches_of(axes)
    size = fitting_size(["0" * 13], width / n, _LARGEST)
    for i, row in enumerate(words):
        for j, text in enumerate(row):
            dark = np.isfinite(values[i, j]) and values[i, j] > _DARK * 1.25 * top
            axes.text(
                j,
                i,
                text,
                ha="center",
                va="center",
                fontsize=size,
                color="w" if dark else "k",
            )
    upright = _upright(names)
    axes.set_xticks(
        range(n),
        names,
        rotation=90 if upright else 0,
        fontsize=_LARGEST if upright else fitting_size(names, width / n, _LARGEST),
        parse_math=False,
    )
    axes.set_yticks(range(n), names, parse_math=False)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def _upright(names: Sequence[str]) -> bool:
    """Return whether the names of columns are too many or too long to lie level."""
    columns, letters = _LEVEL
    return len(names) > columns or max(map(len, names)) > letters
