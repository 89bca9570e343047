"""Simulated devices behind a pseudo-terminal or, on any system, a socket."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Protocol, Self

from skinviz.instruments.simulate.faults import Chunk

_LOOK = 0.1  # s between two looks whether to end
_TICK = 0.01  # s, in which a paced line sends what fits


class Device(Protocol):
    """What is fed bytes and yields its answers."""

    def receive(self, data: bytes) -> Iterator[Chunk]:
        """Take bytes and yield the answer."""


class Server(ABC):
    """A thread that stands between a device and its line.

    Parameters
    ----------
    device : Device
        What answers.
    baudrate : float
        Pace of the answers; as fast as can be, if not said. [1/s]
    """

    url: str

    def __init__(self, device: Device, *, baudrate: float = float("inf")) -> None:
        """Begin to answer."""
        self._device = device
        self._tick = max(1, int(min(baudrate * _TICK / 10, 2**20)))
        self._pace = _TICK if baudrate < float("inf") else 0.0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread and close the line."""
        self._end.set()
        self._thread.join(timeout=2)

    def __enter__(self) -> Self:
        """Return the server, which answers."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()

    @abstractmethod
    def _serve(self) -> None:
        """Answer until the end."""

    def _answer(self, data: bytes, line: int) -> bool:
        """Send a device's answer to bytes; return whether the cable is still in."""
        for chunk in self._device.receive(data):
            if chunk is None:
                return False
            if isinstance(chunk, float):
                self._end.wait(chunk)
            else:
                self._send(chunk, line)
        return True

    def _send(self, data: bytes, line: int) -> None:
        """Send bytes at the line's pace, as far as somebody takes them."""
        sent = 0
        while sent < len(data) and not self._end.is_set():
            _, ready, _ = select.select([], [line], [], _LOOK)
            if ready:
                sent += os.write(line, data[sent : sent + self._tick])
                if self._pace:
                    time.sleep(self._pace)


class PtyServer(Server):
    """A device at a pseudo-terminal, which is a serial port to every program."""

    def __init__(self, device: Device, *, baudrate: float = float("inf")) -> None:
        """Open a pseudo-terminal and begin to answer."""
        import tty

        # The slave stays open: without one the master cannot be read.
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url = os.ttyname(self._slave)
        super().__init__(device, baudrate=baudrate)

    def _serve(self) -> None:
        """Answer until the end or until the cable is pulled out."""
        try:
            while not self._end.is_set():
                ready, _, _ = select.select([self._master], [], [], _LOOK)
                if ready and not self._answer(
                    os.read(self._master, 1024), self._master
                ):
                    break
        except OSError:
            pass  # the pseudo-terminal has gone
        finally:
            os.close(self._master)
            os.close(self._slave)


class SocketServer(Server):
    """A device at a socket of this computer, for systems without pseudo-terminals."""

    def __init__(self, device: Device, *, baudrate: float = float("inf")) -> None:
        """Listen at a free port."""
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(_LOOK)
        self.url = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"
        super().__init__(device, baudrate=baudrate)

    def _serve(self) -> None:
        """Answer one caller after the other."""
        with self._listener:
            while not self._end.is_set():
                with contextlib.suppress(TimeoutError):
                    caller, _ = self._listener.accept()
                    with caller, contextlib.suppress(OSError):
                        self._converse(caller)

    def _converse(self, caller: socket.socket) -> None:
        """Answer one caller until it hangs up."""
        caller.setblocking(False)
        caller.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while not self._end.is_set():
            ready, _, _ = select.select([caller], [], [], _LOOK)
            if ready:
                data = caller.recv(1024)
                if not data or not self._answer(data, caller.fileno()):
                    return


def serve(device: Device, *, baudrate: float = float("inf")) -> Server:
    """Return a server of a device, at a pseudo-terminal where there are any."""
    kind = PtyServer if hasattr(os, "openpty") else SocketServer
    return kind(device, baudrate=baudrate)
