"""What browsers may ask for: each request checked, then a new state."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl, urlencode

from skinviz._validate import in_range
from skinviz.view.viewer.address import from_query
from skinviz.view.viewer.answering import checked
from skinviz.view.viewer.controls import with_preset
from skinviz.view.viewer.readings import mark_at
from skinviz.view.viewer.state import Mark
from skinviz.view.viewer.turning import shifted, turned, zoomed

if TYPE_CHECKING:
    from skinviz.view.viewer.app import Viewer

_LARGEST = 4096  # pixels, of a picture's side
_SMALLEST = 64


def listen_to_requests(viewer: Viewer, server: Any) -> None:
    """Answer what browsers ask for."""
    for name, answer in _TRIGGERS.items():
        server.trigger(name)(checked(viewer, answer))


def _link(viewer: Viewer, query: str) -> None:
    """Show what a link says, but for what is the page's own."""
    pairs = parse_qsl(str(query).lstrip("?"), keep_blank_values=True)
    own = urlencode([(key, value) for key, value in pairs if key not in _PAGE_KEYS])
    if own:
        viewer.change(lambda _: from_query(own, viewer.opened.initial))


def _drag(viewer: Viewer, kind: str, across: float, along: float) -> None:
    """Turn or shift the view by shares of the picture's width and height."""
    x, y = in_range(across, -4, 4, "drag"), in_range(along, -4, 4, "drag")
    if kind == "turn":
        viewer.change(lambda state: turned(state, x, y))
    elif kind == "shift" and viewer.shown is not None:
        view, tiles = viewer.shown.held.sight.view, viewer.shown.tiles
        width, height = tiles.whole
        viewer.change(
            lambda state: shifted(
                state, x * width * view.pixel, -y * height * view.pixel
            )
        )


def _zoom(viewer: Viewer, steps: float) -> None:
    """Come nearer, or go back."""
    step = in_range(steps, -20, 20, "zoom")
    viewer.change(lambda state: zoomed(state, step))


def _pick(viewer: Viewer, across: float, along: float, second: bool) -> None:
    """Mark the point at a place of the picture, in shares of its size."""
    shown = viewer.shown
    if shown is None:
        return
    width, height = shown.tiles.whole
    column = in_range(across, 0, 1, "place") * width
    row = in_range(along, 0, 1, "place") * height
    _mark(viewer, mark_at(shown, column, row), second)


def _mark_middle(viewer: Viewer, second: bool) -> None:
    """Mark the point in the middle of the active hand's picture, without a mouse."""
    shown = viewer.shown
    if shown is None:
        return
    left, top = shown.tiles.corner(shown.state.active)
    width, height = shown.tiles.size
    _mark(viewer, mark_at(shown, left + width / 2, top + height / 2), second)


def _mark(viewer: Viewer, mark: Mark | None, second: bool) -> None:
    """Mark a point, if there is one."""
    if mark is not None:
        viewer.change(
            lambda state: state.marking(mark, bool(second)).replace(active=mark.look)
        )


def _unmark(viewer: Viewer) -> None:
    """Take the marks away."""
    viewer.change(lambda state: state.replace(points=()))


def _preset(viewer: Viewer, name: str) -> None:
    """Put light and viewer at angles that the paper has."""
    viewer.change(lambda state: with_preset(state, name))


def _fitted(viewer: Viewer) -> None:
    """Give the active hand the weights of its fit again."""
    viewer.change(lambda state: state.with_look(weights=()))


def _framed(viewer: Viewer) -> None:
    """Show the whole hand again."""
    initial = viewer.opened.initial
    viewer.change(
        lambda state: state.replace(
            view=initial.view, zoom=initial.zoom, shift=initial.shift
        )
    )


def _reset(viewer: Viewer) -> None:
    """Show what was shown first."""
    viewer.change(lambda _: viewer.opened.initial)


def _resize(viewer: Viewer, width: float, height: float) -> None:
    """Draw pictures of the size that the page has room for. [pixels]"""
    wide = in_range(width, 0, 1e5, "width"), in_range(height, 0, 1e5, "height")
    viewer.resize(*(min(max(round(side), _SMALLEST), _LARGEST) for side in wide))


async def _save_scene(viewer: Viewer, name: str) -> str | None:
    """Write a scene file; return the command that draws it anew."""
    return await viewer.save_scene(name)


async def _save_figure(viewer: Viewer, name: str) -> None:
    """Write a figure."""
    await viewer.save_figure(name)


_PAGE_KEYS = ("secret", "ui", "reconnect", "sessionURL", "application")

_TRIGGERS: dict[str, Callable[..., Any]] = {
    "link": _link,
    "drag": _drag,
    "zoom": _zoom,
    "pick": _pick,
    "mark_middle": _mark_middle,
    "unmark": _unmark,
    "preset": _preset,
    "fitted": _fitted,
    "framed": _framed,
    "reset": _reset,
    "resize": _resize,
    "undo": lambda viewer: viewer.undo(),
    "redo": lambda viewer: viewer.redo(),
    "save_scene": _save_scene,
    "save_figure": _save_figure,
}
"""What the page may ask for, by name."""
