"""A state's pictures as the page takes them, with all that is told beside them."""

from __future__ import annotations

import base64
import threading
import time
from typing import Any

from skinviz.view.viewer.address import to_query
from skinviz.view.viewer.pictures import Darkroom, Shown, jpeg, png
from skinviz.view.viewer.shown import Size
from skinviz.view.viewer.state import ViewState
from skinviz.view.viewer.told import plan_told, told_of

_QUICK_PIXELS = 500_000  # of pictures of what moves
_TURNING_PIXELS = 200_000  # where rays have to be cast anew


def quick_frame(
    darkroom: Darkroom, state: ViewState, size: Size, before: Shown | None
) -> tuple[Shown, dict[str, Any]]:
    """Return a state's quick picture, and the page's variables with it.

    ``before`` is what was shown last: a hand that turns is drawn in fewer pixels.
    """
    started = time.perf_counter()
    shown = darkroom.quick(state, _at_most(size, _most_pixels(before, state)))
    told = told_of(shown, darkroom.opened.samples)
    picture = _link("jpeg", jpeg(shown.picture))
    width, height = size
    return shown, {
        **told,
        "picture": picture,
        "aspect": f"{width} / {height}",
        "query": to_query(state, darkroom.opened.initial),
        "quick_ms": round(1e3 * (time.perf_counter() - started), 1),
    }


class OutdatedError(Exception):
    """What is drawn is no longer wanted."""


def still_frame(
    darkroom: Darkroom, state: ViewState, size: Size, outdated: threading.Event
) -> dict[str, Any]:
    """Return the variables of a state's still picture and its plan.

    Raises
    ------
    OutdatedError
        If ``outdated`` is set meanwhile: the processors are wanted for what is new.
    """

    def go_on(_: int) -> None:
        if outdated.is_set():
            raise OutdatedError

    go_on(0)
    still = darkroom.still(state, size, go_on)
    return {
        "picture": _link("png", png(still.picture)),
        **plan_told(still, state.tolerance),
    }


def _most_pixels(shown: Shown | None, state: ViewState) -> int:
    """Return how many pixels a quick picture may have, fewer if the hand turns."""
    if shown is None:
        return _QUICK_PIXELS
    before = (shown.state.view, shown.state.zoom, shown.state.shift)
    stays = before == (state.view, state.zoom, state.shift)
    return _QUICK_PIXELS if stays else _TURNING_PIXELS


def _at_most(size: tuple[int, int], pixels: int) -> tuple[int, int]:
    """Return a size of the same shape with no more pixels."""
    scale = min(1.0, (pixels / (size[0] * size[1])) ** 0.5)
    return max(1, round(size[0] * scale)), max(1, round(size[1] * scale))


def _link(kind: str, content: bytes) -> str:
    """Return a picture's file as a link that holds it."""
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
