"""``show``: a scene to look at, wherever Python runs."""

from __future__ import annotations

import asyncio
import sys
from functools import partial
from typing import TYPE_CHECKING, Any

from skinviz.view.viewer.opened import open_scene
from skinviz.view.viewer.server import Opening, Running, serve, start

if TYPE_CHECKING:
    from skinviz.scene.scene import Scene

_HEIGHT = 720  # pixels, of a frame in a notebook


def show(scene: Scene) -> Any:
    """Open the viewer with a scene.

    In a notebook the viewer appears below the cell and lives as long as the kernel.
    Elsewhere it opens in the browser, and the call ends with Ctrl-C.

    Parameters
    ----------
    scene : Scene
        What is to be shown.

    Returns
    -------
    frame : IPython.display.IFrame or None
        In a notebook, where it is the cell's value.

    Raises
    ------
    SkinvizError
        If the scene cannot be shown.
    """
    opening = partial(open_scene, scene)
    if not in_notebook():
        asyncio.run(serve(opening, announce=_announce))
        return None
    from IPython.display import IFrame

    running = start(framed=True)
    showing = asyncio.ensure_future(_show(running, opening))
    showing.add_done_callback(lambda done: done.exception())  # the page tells it
    return IFrame(running.url, "100%", _HEIGHT)


async def _show(running: Running, opening: Opening) -> None:
    """Show a scene once the page can be asked for."""
    await running.answering()
    await running.show(opening)


def in_notebook() -> bool:
    """Return whether Python runs in the kernel of a notebook."""
    shell = sys.modules.get("IPython")
    own = shell.get_ipython() if shell is not None else None
    return own is not None and hasattr(own, "kernel")


def _announce(url: str) -> None:
    """Write where the viewer is."""
    sys.stdout.write(f"viewer at {url}\npress Ctrl-C to end\n")
    sys.stdout.flush()
