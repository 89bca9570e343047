"""Hands side by side: one view, one scale, one exposure."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.errors import ArgumentError
from skinviz.rendering.geometry import geometry_of
from skinviz.rendering.render import Rendering, render
from skinviz.scene.scene import Scene
from skinviz.view.page import STYLE, Cells, Margins, fitting_size, inches_of, lay_out

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_LINE = 0.13  # inches: height of a line of notes
_SWATCH = 0.17  # inches
_LABEL = 0.2  # inches: of a hand, a row, a column


@dataclass(frozen=True, eq=False)
class Hand:
    """A picture of a hand and what is written around it.

    Attributes
    ----------
    picture : (height, width, 3) ndarray of uint8
        sRGB.
    label : str
        Above it.
    swatches : sequence of (3,) ndarray
        Colours under it, edge to edge; sRGB, 0 to 1.
    notes : sequence of str
        Lines under that.
    """

    picture: NDArray[np.uint8]
    label: str = ""
    swatches: Sequence[Array] = ()
    notes: Sequence[str] = ()


def render_linked(
    scenes: Sequence[Scene],
    *,
    exposure: float | None = None,
    tolerance: float = 1.0,
    advance: Callable[[int], None] | None = None,
) -> list[Rendering]:
    """Return pictures of scenes under one exposure and at one scale.

    Every picture gets the size, the exposure and the observer of the first scene, and
    the mm per pixel of the one that shows most. What lights and displays they have is
    theirs.

    Parameters
    ----------
    scenes : sequence of Scene
        At least one. Scenes that share a mesh share its preparation.
    exposure : float, optional
        For all; the first scene's if not said. [1]
    tolerance : float
        See :func:`skinviz.plan`. [ΔE00]
    advance : callable, optional
        Told 1 for each picture that is done.

    Raises
    ------
    ArgumentError
        If there is no scene.
    """
    if not scenes:
        raise ArgumentError("there is no scene to render; give at least one")
    first = scenes[0]
    shared = first.exposure if exposure is None else exposure
    in_range(shared, 1e-30, 1e30, "exposure")
    size = first.camera.size
    geometries = {id(s.mesh): geometry_of(s.mesh) for s in _of_each_mesh(scenes)}
    same = [_with_camera(scene, size=size) for scene in scenes]
    height = max(
        s.camera.view(geometries[id(s.mesh)].in_mm).pixel * size[1] for s in same
    )
    pictures = []
    for scene in same:
        own = _with_camera(scene, size=size, height=height).replace(
            exposure=shared, observer=first.observer
        )
        geometry = geometries[id(scene.mesh)]
        pictures.append(render(own, tolerance=tolerance, geometry=geometry))
        if advance is not None:
            advance(1)
    return pictures


def grid_figure(
    hands: Sequence[Sequence[Hand | None]],
    width: float,
    *,
    pixel: float,
    row_labels: Sequence[str] = (),
    column_labels: Sequence[str] = (),
    title: str = "",
    caption: str = "",
) -> Figure:
    """Return a figure of hands in rows and columns, with a scale bar.

    Parameters
    ----------
    hands : sequence of sequence of Hand
        Rows of equal length, pictures of equal size; None where there is none.
    width : float
        Of the figure. [inches]
    pixel : float
        Side of a pixel, the same in all pictures. [mm]
    row_labels, column_labels : sequence of str
        At the left of each row, above each column.
    title, caption : str
        Printed above and below, wrapped.

    Raises
    ------
    ArgumentError
        If rows or pictures differ in size, or labels in number.
    """
    import matplotlib as mpl

    height, wide = _checked(hands, row_labels, column_labels)
    shown = [hand for row in hands for hand in row if hand is not None]
    label = _LABEL if any(hand.label for hand in shown) else 0.02
    lines = max(len(hand.notes) for hand in shown)
    swatch = (_SWATCH,) if any(len(hand.swatches) for hand in shown) else ()
    blocks = [
        Cells(
            len(row),
            (-height / wide, *swatch),
            gap=0.03,
            least=0.1,
            margins=Margins(
                left=0.02,
                right=0.02,
                top=label + (_LABEL if column_labels and i == 0 else 0.0),
                bottom=0.05 + _LINE * lines,
            ),
            indent=_LABEL if row_labels else 0.0,
        )
        for i, row in enumerate(hands)
    ]
    with mpl.rc_context(STYLE):
        page = lay_out(width, blocks, title=title, caption=caption)
        for row, cells in zip(hands, page.blocks, strict=True):
            for hand, cell in zip(row, cells, strict=True):
                _draw(cell, hand)
        for words, (axes, *_) in zip(column_labels, page.blocks[0], strict=False):
            _write(axes, words, (0.5, 1), (0, 72 * label + 1), va="bottom", size=8.5)
        for words, (cell, *_) in zip(row_labels, page.blocks, strict=False):
            _write(cell[0], words, (0, 0.5), (-4, 0), rotation=90, ha="right", size=8.5)
        first = next(
            cell[0] for cells in page.blocks for cell in cells if cell[0].images
        )
        _scale_bar(first, pixel, wide, height)
    return page.figure


def _checked(
    hands: Sequence[Sequence[Hand | None]],
    row_labels: Sequence[str],
    column_labels: Sequence[str],
) -> tuple[int, int]:
    """Return the height and width that all pictures have, or say what differs."""
    shapes = {h.picture.shape[:2] for row in hands for h in row if h is not None}
    if len(shapes) != 1:
        raise ArgumentError(
            f"a figure needs pictures of one size; got {sorted(shapes) or 'none'}"
        )
    if len({len(row) for row in hands}) != 1:
        raise ArgumentError("rows of hands must be of equal length; fill up with None")
    for labels, n, what in (
        (row_labels, len(hands), "row_labels"),
        (column_labels, len(hands[0]), "column_labels"),
    ):
        if labels and len(labels) != n:
            raise ArgumentError(f"{what} must be {n} or none; got {len(labels)}")
    return next(iter(shapes))


def _draw(cell: Sequence[Axes], hand: Hand | None) -> None:
    """Draw a hand, its swatches and notes."""
    for axes in cell:
        axes.set_axis_off()
    if hand is None:
        return
    axes = cell[0]
    axes.imshow(hand.picture, interpolation="antialiased", aspect="auto")
    _write(axes, hand.label, (0.5, 1), (0, 2), va="bottom", size=8)
    if len(hand.swatches):
        colours = np.asarray(hand.swatches, dtype=np.float64)[None]
        cell[1].imshow(colours, aspect="auto", interpolation="nearest")
    _write(cell[-1], "\n".join(hand.notes), (0.5, 0), (0, -2), va="top", size=7)


def _write(
    axes: Axes,
    words: str,
    at: tuple[float, float],
    offset: tuple[float, float],
    *,
    size: float,
    rotation: float = 0,
    ha: Any = "center",
    va: Any = "center",
) -> None:
    """Write beside axes, in letters small enough for their width or height."""
    width, height = inches_of(axes)
    room = height if rotation else width
    axes.annotate(
        words,
        at,
        xytext=offset,
        xycoords="axes fraction",
        textcoords="offset points",
        rotation=rotation,
        ha=ha,
        va=va,
        fontsize=fitting_size(words.splitlines(), room, size),
        parse_math=False,
        annotation_clip=False,
    )


def _scale_bar(axes: Axes, pixel: float, width: int, height: int) -> None:
    """Draw a bar of a round length, at most a third of the picture."""
    longest = width * pixel / 3
    unit = 10 ** np.floor(np.log10(longest))
    length = unit * max(k for k in (1, 2, 5) if k * unit <= longest * (1 + 1e-9))
    left, low = 0.05 * width, 0.965 * height
    axes.plot([left, left + length / pixel], [low, low], "-", color="w", lw=1.6)
    axes.text(
        left,
        low - 0.012 * height,
        f"{length:g} mm",
        color="w",
        va="bottom",
        fontsize=min(6.5, fitting_size(["0" * 8], inches_of(axes)[0] / 2, 6.5)),
    )


def _of_each_mesh(scenes: Sequence[Scene]) -> list[Scene]:
    """Return one scene for each mesh."""
    return list({id(scene.mesh): scene for scene in scenes}.values())


def _with_camera(scene: Scene, **changes: Any) -> Scene:
    """Return the scene with another camera."""
    return scene.replace(camera=dataclasses.replace(scene.camera, **changes))
