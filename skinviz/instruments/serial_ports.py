"""Serial ports, listed and opened: the only module that touches pyserial."""

from __future__ import annotations

import errno
import re
import threading
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from skinviz.instruments.errors import PortUnavailable
from skinviz.instruments.link import SLICE, Link

_OPENING = {
    errno.ENOENT: "there is no such port; see 'skinviz measure --list', and the cable",
    errno.ENODEV: "the device has gone; plug it in again",
    errno.ENXIO: "the device has gone; plug it in again",
    errno.EACCES: "you may not use it; add yourself to the group that owns it "
    "(dialout or uucp) and log in again",
    errno.EPERM: "you may not use it; add yourself to the group that owns it",
    errno.EAGAIN: "another program has it open; close that program",
    errno.EBUSY: "another program has it open; close that program",
    errno.EISDIR: "it is a folder; name a port, see 'skinviz measure --list'",
    errno.ENOTTY: "it is no serial port; see 'skinviz measure --list'",
    errno.ECONNREFUSED: "nothing listens there; start the server of the port",
}


@dataclass(frozen=True)
class Port:
    """A serial port as the system describes it.

    Attributes
    ----------
    name : str
        What to give as ``--port``.
    description : str
        What the system knows of the device behind it.
    usb : str
        Vendor and product, as "0861:1003"; "" if it is not on USB.
    serial : str
        The adapter's serial number.
    """

    name: str
    description: str
    usb: str
    serial: str


def list_ports() -> tuple[Port, ...]:
    """Return the ports of this computer; not a byte is sent to any."""
    from serial.tools import list_ports as system

    return tuple(
        Port(
            port.device,
            port.description or "",
            "" if port.vid is None else f"{port.vid:04x}:{port.pid:04x}",
            port.serial_number or "",
        )
        for port in sorted(system.comports())
    )


def open_link(
    url: str,
    *,
    baudrate: int = 9600,
    rtscts: bool = False,
    stop: threading.Event | None = None,
) -> Link:
    """Open a serial port, ``socket://host:port`` or whatever else pyserial knows.

    Parameters
    ----------
    url : str
        As ``/dev/ttyACM0``, ``COM5`` or ``socket://192.168.1.7:4001``.
    baudrate : int
        [1/s]
    rtscts : bool
        With the handshake of the lines RTS and CTS.
    stop : threading.Event, optional
        Ends every wait when it is set.

    Raises
    ------
    PortUnavailable
        If the port is absent, in use or forbidden.
    """
    import serial

    _require_address(url)
    options: dict[str, Any] = {} if "://" in url else {"exclusive": True}
    try:
        port = serial.serial_for_url(
            url, baudrate=baudrate, rtscts=rtscts, timeout=SLICE, **options
        )
    except (OSError, ValueError) as error:  # SerialException is an OSError
        raise PortUnavailable(f"cannot open {url}: {_why(error)}") from error
    return Link(port, url, stop=stop)


def _require_address(url: str) -> None:
    """Refuse a remote port without host and number, of which pyserial says little."""
    scheme, mark, rest = url.partition("://")
    if not mark or scheme not in ("socket", "rfc2217"):
        return
    try:
        told = urlsplit(f"//{rest}")
        whole = bool(told.hostname and told.port)
    except ValueError:
        whole = False
    if not whole:
        raise PortUnavailable(
            f"cannot open {url}: write host and number, as {scheme}://192.168.1.7:4001"
        )


def _why(error: Exception) -> str:
    """Return the advice for an error of opening; sockets hide its number."""
    cause: BaseException | None = error
    while cause is not None:
        number = getattr(cause, "errno", None)
        if number in _OPENING:
            return _OPENING[number]
        cause = cause.__cause__ or cause.__context__
    for number, advice in _OPENING.items():
        if re.search(rf"\[Errno {number}\]|\({number}, '", str(error)):
            return advice
    return f"{error}; check the port's name"
