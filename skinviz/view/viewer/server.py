"""The viewer's server: one process, one view, on this machine unless told otherwise."""

from __future__ import annotations

import asyncio
import errno
import logging
import secrets
import signal
import socket
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode

from skinviz._validate import in_range
from skinviz.errors import SkinvizError
from skinviz.view.viewer.guard import LARGEST_MESSAGE, Door, middleware
from skinviz.view.viewer.page import build_page

if TYPE_CHECKING:
    from skinviz.view.viewer.app import Viewer
    from skinviz.view.viewer.opened import Opened

HOST = "127.0.0.1"
"""This machine alone."""

_WEB = Path(__file__).with_name("web")
_SECRET_BYTES = 32


Opening = Callable[[], "Opened"]


@dataclass(eq=False)
class Running:
    """A server that answers, from before what it shows is opened.

    Attributes
    ----------
    url : str
        Where, with the secret.
    """

    url: str
    _server: Any
    _task: asyncio.Task[Any]
    _viewer: Viewer | None = None

    @property
    def viewer(self) -> Viewer:
        """What it shows, once that is opened."""
        if self._viewer is None:
            raise SkinvizError("the viewer is still opening; await ready() first")
        return self._viewer

    async def answering(self) -> None:
        """Wait until the page can be asked for."""
        await self._server.ready

    async def show(self, opening: Opening) -> None:
        """Open what is to be shown, beside what the page loads, and draw it.

        Raises
        ------
        SkinvizError
            If it cannot be opened; the page says why.
        """
        try:
            self._viewer = await asyncio.to_thread(
                _opened_viewer, opening, self._server
            )
        except SkinvizError as error:
            with self._server.state as told:
                told.busy, told.title = False, f"cannot be opened: {error}"
            raise
        self._viewer.begin()

    async def stop(self) -> None:
        """Close the connections and end."""
        if self._viewer is not None:
            await self._viewer.close()
        await self._server.stop()
        await self._task


def start(*, host: str = HOST, port: int = 0, framed: bool = False) -> Running:
    """Start to serve in the running event loop; await ``answering`` and ``show`` then.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        0: one that is free.
    framed : bool
        Whether pages of this machine may show it in a frame, as notebooks do.

    Raises
    ------
    SkinvizError
        If the address cannot be listened on.
    """
    from trame.app import get_server

    port = _free_port(host, int(in_range(port, 0, 65535, "port")))
    for name in ("wslink", "aiohttp.server", "trame_server"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # errors go to their client
    secret = secrets.token_urlsafe(_SECRET_BYTES)
    server = get_server(
        f"skinviz-{secrets.token_hex(8)}",
        client_type="vue3",
        ws_max_msg_size=LARGEST_MESSAGE,
    )
    server.enable_module(
        {
            "serve": {"skinviz": str(_WEB)},
            "scripts": ["skinviz/viewer.js"],
            "styles": ["skinviz/viewer.css"],
        }
    )
    build_page(server)
    door = Door(secret, partial(_tell_browsers, server))
    server.add_protocol_to_configure(lambda root: root.registerLinkProtocol(door))

    def bind(bound: Any) -> None:
        bound.app.middlewares.append(middleware(secret, host, framed=framed))
        door.stand_at(bound)

    server.controller.on_server_bind.add(bind)
    _without_command_line(server, host, port, secret)
    task = server.start(
        exec_mode="task",
        thread=True,
        open_browser=False,
        show_connection_info=False,
        disable_logging=True,
        backend="aiohttp",
        timeout=0,
    )
    shown = f"[{host}]" if ":" in host else host
    query = urlencode({"secret": secret})
    return Running(f"http://{shown}:{port}/?{query}", server, task)


async def serve(
    opening: Opening,
    *,
    host: str = HOST,
    port: int = 0,
    browser: bool = True,
    announce: Callable[[str], None],
) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    opening : callable
        Opens what is to be shown; in a thread, while the page loads.
    host, port : str, int
        As for :func:`start`.
    browser : bool
        Whether the page is opened in the user's browser.
    announce : callable
        Told the link, once it answers.

    Raises
    ------
    SkinvizError
        If the address cannot be listened on, or nothing be opened.
    """
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    loop.set_exception_handler(_unless_gone)
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    running = start(host=host, port=port)
    await running.answering()
    announce(running.url)
    if browser:
        await asyncio.to_thread(webbrowser.open, running.url)
    try:
        await running.show(opening)
        await ended.wait()
    finally:
        await running.stop()


def _unless_gone(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Tell of what went wrong, but not that a browser went while it was sent to."""
    if not isinstance(context.get("exception"), ConnectionError):
        loop.default_exception_handler(context)


def _opened_viewer(opening: Opening, server: Any) -> Viewer:
    """Return the viewer of what is opened; loading what it needs takes its time too."""
    from skinviz.view.viewer.app import Viewer

    opened = opening()
    _ = opened.initial
    return Viewer(opened, server)


def _tell_browsers(server: Any, n: int) -> None:
    """Tell how many browsers share the view."""
    with server.state as told:
        told.browsers = n


def _without_command_line(server: Any, host: str, port: int, secret: str) -> None:
    """Give trame its options outright; it would read those of our command line."""
    words = ["--host", host, "--port", str(port), f"--authKey={secret}"]
    words += ["--no-ws-compress", "--server", "--timeout", "0"]
    options, _ = server.cli.parse_known_args(words)
    server.cli.parse_known_args = lambda *_: (options, [])


def _free_port(host: str, port: int) -> int:
    """Return a port that can be listened on, or say before anything is started."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.create_server((host, port), family=family) as found:
            return int(found.getsockname()[1])
    except OSError as error:
        advice = "with --host; without it this machine alone is listened on"
        if error.errno in (errno.EADDRINUSE, errno.EACCES):
            advice = "with --port, or leave it out for one that is free"
        why = str(error.strerror).partition(" (while")[0]
        raise SkinvizError(
            f"cannot listen on {host} port {port}: {why}; choose another {advice}"
        ) from error
