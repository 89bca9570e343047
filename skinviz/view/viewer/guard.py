"""Who may talk to the viewer's server, and how much they may say.

A page of another site that is open in the same browser can send requests here: its
``Origin`` gives it away, and where its name has been made to stand for this machine,
its ``Host``. Whoever has the run's secret may look on; nobody else.
"""

from __future__ import annotations

import ipaddress
import secrets
import socket
from collections.abc import Awaitable, Callable
from typing import Any
from urllib.parse import urlsplit

from aiohttp import web
from wslink.chunking import UnChunker
from wslink.websocket import LinkProtocol

LARGEST_MESSAGE = 2**20
"""Bytes that a browser may send at once; its own messages have some hundreds."""

LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Names that this machine has for itself alone."""

_MOST_PENDING = 8  # messages of one browser that have come in part
_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "font-src 'self' data:; connect-src 'self' ws://{name} wss://{name}; "
    "object-src 'none'; "
    "base-uri 'self'; form-action 'none'; frame-ancestors {ancestors}"
)
_EXITS = ("application.exit", "application.exit.later")

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class BoundedUnChunker(UnChunker):  # type: ignore[misc]
    """Joins messages that come in parts, up to a size that does not fill memory."""

    def set_max_message_size(self, size: int) -> None:
        """Allow a size, but none above the largest."""
        super().set_max_message_size(min(size, LARGEST_MESSAGE))

    def process_chunk(self, chunk: bytes) -> Any:
        """Take one part; return the message if it is whole."""
        if len(self.pending_messages) > _MOST_PENDING:
            raise ValueError("too many messages were begun and not ended")
        return super().process_chunk(chunk)


class Door(LinkProtocol):  # type: ignore[misc]
    """Lets browsers in that know the secret, and counts them.

    Parameters
    ----------
    secret : str
        Of this run.
    told : callable
        Told how many browsers there are when that changes.
    """

    def __init__(self, secret: str, told: Callable[[int], None]) -> None:
        """Take the secret."""
        super().__init__()
        self._secret = secret
        self._told = told
        self._vouched: dict[str, bool] = {}
        self._inside: set[str] = set()
        self._handlers: list[Any] = []

    def stand_at(self, server: Any) -> None:
        """Guard a web server that is about to start."""
        self._handlers = server._ws_handlers
        for handler in self._handlers:
            for name in _EXITS:  # no browser ends the server
                handler.functionMap.pop(name, None)

    def onConnect(self, request: web.Request, client_id: str) -> None:  # noqa: N802
        """Note whether a browser that connects was here before."""
        cookie = request.cookies.get(cookie_name(request), "")
        self._vouched[client_id] = secrets.compare_digest(
            cookie.encode(), self._secret.encode()
        )
        for handler in self._handlers:
            if client_id in handler.unchunkers:
                handler.unchunkers[client_id] = BoundedUnChunker()

    def onClose(self, client_id: str) -> None:  # noqa: N802
        """Forget a browser that has gone."""
        self._vouched.pop(client_id, None)
        if client_id in self._inside:
            self._inside.discard(client_id)
            self._told(len(self._inside))

    async def validateToken(self, token: Any, client_id: str) -> bool:  # noqa: N802
        """Return whether a browser may come in."""
        known = isinstance(token, str) and secrets.compare_digest(
            token.encode(), self._secret.encode()
        )
        if known or self._vouched.get(client_id, False):
            self._inside.add(client_id)
            self._told(len(self._inside))
            return True
        return False


def cookie_name(request: web.Request) -> str:
    """Return the cookie of this server; servers on other ports have others."""
    port = request.transport.get_extra_info("sockname")[1] if request.transport else 0
    return f"skinviz-{port}"


def middleware(secret: str, host: str, *, framed: bool) -> Any:
    """Return what every request goes through before it is answered.

    Parameters
    ----------
    secret : str
        Of this run.
    host : str
        On which the server listens.
    framed : bool
        Whether pages of this machine may show the viewer in a frame.
    """
    local = "http://localhost:* http://127.0.0.1:*"
    ancestors = f"'self' {local}" if framed else "'none'"

    @web.middleware
    async def guarded(request: web.Request, handler: Handler) -> web.StreamResponse:
        if not is_known_name(request.host, host):
            raise web.HTTPForbidden(text="this server does not go by that name\n")
        origin = request.headers.get("Origin")
        asks = request.path == "/ws" or origin is not None
        if asks and (origin or "").partition("://")[2] != request.host:
            raise web.HTTPForbidden(text="pages of other sites may not ask here\n")
        response = await handler(request)
        if response.prepared:
            return response
        response.headers.update(
            {
                "Content-Security-Policy": _POLICY.format(
                    name=request.host, ancestors=ancestors
                ),
                "Referrer-Policy": "no-referrer",
                "X-Content-Type-Options": "nosniff",
                "Cross-Origin-Resource-Policy": "same-origin",
                "Cache-Control": "no-cache",
            }
        )
        given = request.query.get("secret", "")
        if secrets.compare_digest(given.encode(), secret.encode()):
            response.set_cookie(
                *(cookie_name(request), secret), httponly=True, samesite="Strict"
            )
        return response

    return guarded


def is_known_name(header: str, host: str) -> bool:
    """Return whether a request's ``Host`` is a name of this server.

    A server of this machine alone goes by the loopback's names. One that listens on
    another address goes by that, by the machine's own name and by bare addresses,
    which no stranger's domain is.
    """
    try:
        name = urlsplit(f"//{header}").hostname or ""
    except ValueError:  # half an IPv6 address
        return False
    if name in LOOPBACK:
        return True
    if host in LOOPBACK:
        return False
    if name in (host.lower(), socket.gethostname().lower(), socket.getfqdn().lower()):
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
