"""``skinviz view``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from skinviz.cli.arguments import Whole
from skinviz.cli.output import say

if TYPE_CHECKING:
    from skinviz.view.viewer.opened import Opened


def view(
    scene: Path | None = None,
    /,
    *,
    host: str = "127.0.0.1",
    port: Whole = 0,
    no_browser: bool = False,
    native: bool = False,
    json: bool = False,
) -> None:
    """Turn a hand, its light and its skin by hand, in the browser.

    Every colour is computed from spectra. The page shows the spectra of points that
    are clicked, the people of the archive, and up to four hands side by side. The
    server ends with Ctrl-C.

    Example: skinviz view scene.toml

    Parameters
    ----------
    scene
        Scene file (TOML), or the folder of a study, whose subjects can be chosen.
        Without it the shipped hand is shown.
    host
        Address to listen on. The usual one can be reached from this machine alone,
        as it should be: from elsewhere, use an SSH tunnel to it.
    port
        Port to listen on; 0 is any that is free.
    no_browser
        Only print the link. It holds a secret of this run: keep it to yourself.
    native
        Open a window of its own instead of a page in the browser.
    json
        Print the link as JSON, on one line, once the page can be asked for.
    """
    import asyncio
    from functools import partial

    from skinviz._files import existing_file
    from skinviz.errors import DataError

    if scene is not None and not scene.is_dir():
        existing_file(scene, DataError)  # before a page is opened
    if native:
        from skinviz.view.viewer.native import show_window

        show_window(_open(scene))
        return
    from skinviz.view.viewer.server import serve

    asyncio.run(
        serve(
            partial(_open, scene),
            host=host,
            port=port,
            browser=not no_browser,
            announce=partial(_announce, host, json),
        )
    )
    if not json:
        say("viewer ended")


def _open(scene: Path | None) -> Opened:
    """Open a scene file, a study, or the shipped hand."""
    from skinviz.view.viewer.opened import open_path

    return open_path(scene)


def _announce(host: str, json: bool, url: str) -> None:
    """Print the link; what is printed does not wait for more, wherever it goes."""
    from json import dumps

    from skinviz.view.viewer.guard import LOOPBACK

    if host not in LOOPBACK:
        sys.stderr.write(
            f"warning: listening on {host}: whoever has the link can steer the viewer, "
            "and it is not encrypted; prefer 'ssh -L' to this machine's 127.0.0.1\n"
        )
    say(dumps({"url": url}) if json else f"viewer at {url}\npress Ctrl-C to end")
    sys.stdout.flush()
