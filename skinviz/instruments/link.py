"""The bytes to and from an instrument, over a port that is open.

Every wait has a deadline. ``flush`` is never called: on USB ports it may not return.
What does not belong here: ports themselves (``instruments.serial_ports``), and what
the bytes mean.
"""

from __future__ import annotations

import errno
import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from skinviz.instruments.errors import (
    InstrumentError,
    LinkLost,
    MalformedReply,
    NoReply,
    Stopped,
    TruncatedReply,
)

LONGEST_LINE = 4096  # bytes; no instrument sends more before a line's end

_LONGEST_NOISE = 65536  # bytes to throw away; no late reply is longer

SLICE = 0.1
"""After which a wait looks whether it is to stop. [s]"""

_LINE_END = re.compile(rb"\r\n|\r|\n")


@dataclass(frozen=True)
class Exchange:
    """A piece of a conversation.

    Attributes
    ----------
    at : float
        When, on the link's clock. [s]
    sent : bool
        To the instrument, or from it.
    data : bytes
        A command or a line.
    """

    at: float
    sent: bool
    data: bytes


class Link:
    """A conversation with one instrument over an open port."""

    def __init__(
        self,
        port: Any,
        name: str,
        *,
        stop: threading.Event | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take a port opened with a short read time-out, of pyserial or alike."""
        self.name = name
        self._port = port
        self._stop = threading.Event() if stop is None else stop
        self._clock = clock
        self._buffer = bytearray()
        self._after_return = False  # the line feed of a CR LF may still come
        self._not_before = -float("inf")
        self._exchanges: list[Exchange] = []

    def send(self, data: bytes, *, pace: float = 0.0, gap: float = 0.0) -> None:
        """Send bytes, one at a time where instruments are upset by haste.

        Parameters
        ----------
        data : bytes
            A command with its terminator.
        pace : float
            Pause between two bytes. [s]
        gap : float
            How long the instrument is left alone before the next command. [s]

        Raises
        ------
        LinkLost
            If the port has gone.
        """
        self.pause(self._not_before - self._clock())
        self._note(True, data)
        with self._in_use():
            for i in range(len(data)):
                if i:
                    self.pause(pace)
                self._port.write(data[i : i + 1])
        self._not_before = self._clock() + gap

    def line(self, within: float) -> bytes:
        """Return the next line without its end, be that CR LF, CR or LF.

        Raises
        ------
        NoReply, TruncatedReply
            If nothing, or only its beginning, came within so many seconds.
        MalformedReply
            If more came than any line has.
        LinkLost, Stopped
            If the port has gone, or waiting was to stop.
        """
        deadline = self._clock() + within
        while True:
            line = self._split()
            if line is not None:
                self._note(False, line)
                return line
            if len(self._buffer) > LONGEST_LINE:
                raise MalformedReply(
                    f"{self.name} sends without ever ending a line; check the baud "
                    "rate and that this is the instrument's port",
                    raw=self._take(),
                )
            if not self._receive(deadline):
                raise self._silence(within)

    def wanted_line(self, within: float, is_wanted: Callable[[bytes], object]) -> bytes:
        """Return the next line that is wanted; others are passed.

        Raises
        ------
        MalformedReply
            If only others came within so many seconds.
        NoReply, TruncatedReply, LinkLost, Stopped
            As for :meth:`line`.
        """
        deadline = self._clock() + within
        while True:
            line = self.line(deadline - self._clock())
            if is_wanted(line):
                return line
            if self._clock() >= deadline:
                raise MalformedReply(
                    f"{self.name} sends nothing but something else; check that this is "
                    "the instrument's port",
                    raw=line,
                )

    def lines(self, count: int, within: float) -> list[bytes]:
        """Return so many lines, each within so many seconds of the one before.

        Raises
        ------
        TruncatedReply
            If they end too early; ``raw`` is what came.
        MalformedReply, LinkLost, Stopped
            As for :meth:`line`.
        """
        found: list[bytes] = []
        try:
            while len(found) < count:
                found.append(self.line(within))
        except (NoReply, TruncatedReply) as error:
            whole = b"".join(line + b"\r\n" for line in found) + error.raw
            raise TruncatedReply(
                f"{self.name} stopped after {len(found)} of {count} lines; the data "
                "can be read again, otherwise check the cable",
                raw=whole,
            ) from error
        return found

    def until(self, token: bytes, within: float) -> bytes:
        """Return all bytes up to and with a token, which need not end a line.

        Raises
        ------
        NoReply, TruncatedReply, MalformedReply, LinkLost, Stopped
            As for :meth:`line`.
        """
        deadline = self._clock() + within
        while token not in self._buffer:
            if len(self._buffer) > LONGEST_LINE:
                raise MalformedReply(
                    f"{self.name} sends something else; check that this is the "
                    "instrument's port and its baud rate",
                    raw=self._take(),
                )
            if not self._receive(deadline):
                raise self._silence(within)
        end = self._buffer.index(token) + len(token)
        found = bytes(self._buffer[:end])
        del self._buffer[:end]
        self._note(False, found)
        return found

    def drain(self, quiet: float = 0.0, *, at_most: float = 5.0) -> bytes:
        """Throw away what has come, until so many seconds of silence; return it.

        Raises
        ------
        MalformedReply
            If there is no silence within ``at_most`` seconds.
        LinkLost, Stopped
            As for :meth:`line`.
        """
        thrown = bytearray(self._take())
        end = self._clock() + at_most
        while self._receive(min(self._clock() + quiet, end)):
            thrown += self._take()
            if self._clock() > end or len(thrown) > _LONGEST_NOISE:
                raise MalformedReply(
                    f"{self.name} sends without ever pausing; check that this is the "
                    "instrument's port and its baud rate",
                    raw=bytes(thrown[:LONGEST_LINE]),
                )
        self._after_return = False
        if thrown:
            self._note(False, bytes(thrown))
        return bytes(thrown)

    def pause(self, seconds: float) -> None:
        """Wait so long, or until waiting is to stop."""
        if seconds > 0 and self._stop.wait(seconds):
            raise self._stopped()

    def pulse_rts(self, seconds: float) -> None:
        """Drop the line RTS for so long; ports without that line do nothing."""
        with self._in_use():
            try:
                self._port.rts = False
                self.pause(seconds)
                self._port.rts = True
            except OSError as error:
                if error.errno != errno.ENOTTY:
                    raise

    def transcript(self) -> tuple[Exchange, ...]:
        """Return what was said since the last call of this method."""
        said = tuple(self._exchanges)
        self._exchanges.clear()
        return said

    def close(self) -> None:
        """Close the port; one that has gone is closed already."""
        # pyserial leaves a socket open whose other side has hung up.
        behind = getattr(self._port, "_socket", None)
        with suppress(OSError):
            self._port.close()
        if behind is not None:
            behind.close()

    def _receive(self, deadline: float) -> bool:
        """Wait for bytes until the deadline; return whether some came."""
        while True:
            if self._stop.is_set():
                raise self._stopped()
            with self._in_use():
                waiting = self._port.in_waiting
                left = deadline - self._clock()
                if not waiting and left <= 0:
                    return False
                if not waiting and left < SLICE:
                    self.pause(min(left, 0.002))
                    continue
                data = self._port.read(max(1, waiting))
            if data:
                self._buffer += data
                return True

    def _split(self) -> bytes | None:
        """Return the first line of what has come, if it has ended."""
        if self._after_return and self._buffer:
            if self._buffer[0:1] == b"\n":
                del self._buffer[0]
            self._after_return = False
        found = _LINE_END.search(self._buffer)
        if found is None:
            return None
        line = bytes(self._buffer[: found.start()])
        self._after_return = found.group() == b"\r" and found.end() == len(self._buffer)
        del self._buffer[: found.end()]
        return line

    def _silence(self, within: float) -> InstrumentError:
        """Return the error of a deadline that has passed."""
        came = self._take()
        if came:
            return TruncatedReply(
                f"{self.name} stopped in the middle of a line; the data can be read "
                "again, otherwise check the cable",
                raw=came,
            )
        return NoReply(
            f"{self.name} did not answer within {within:g} s; check that the "
            "instrument is on, the cable in, and the port the right one"
        )

    def _take(self) -> bytes:
        """Return and forget what has come and was not read."""
        data = bytes(self._buffer)
        self._buffer.clear()
        return data

    def _note(self, sent: bool, data: bytes) -> None:
        """Keep what was said."""
        self._exchanges.append(Exchange(self._clock(), sent, data))

    def _stopped(self) -> Stopped:
        """Return the error of a wait that the user ended."""
        return Stopped("stopped as asked; what was measured is kept")

    @contextmanager
    def _in_use(self) -> Iterator[None]:
        """Turn what a port raises that has gone into one error."""
        try:
            yield
        except OSError as error:  # pyserial's own errors are among them
            raise LinkLost(
                f"{self.name} has gone in the middle of a conversation ({error}); plug "
                "it in again and go on with --resume",
                raw=self._take(),
            ) from error
        except TypeError as error:  # pyserial, where another thread closed the port
            raise LinkLost(
                f"{self.name} was closed; open it again and go on with --resume"
            ) from error
