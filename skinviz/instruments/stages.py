"""Rotation stages: one protocol, a person who turns by hand, and Zaber's motors."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import ClassVar, Protocol, Self

from skinviz.instruments import zaber_replies as replies
from skinviz.instruments.errors import (
    CommandRejected,
    InstrumentError,
    LinkError,
    MalformedReply,
    StageFault,
    Stopped,
    WrongDevice,
)
from skinviz.instruments.link import Exchange, Link

_ANSWER = 2.0  # s
_POLL = 0.05  # s between two questions whether the stage has arrived
_ATTEMPTS = 3
_NEAR = 0.05  # degrees by which a stage may miss its place


class RotationStage(Protocol):
    """What turns the lamp."""

    @property
    def angle(self) -> float:
        """Where it is, as far as it knows. [degrees]"""

    def move(self, degrees: float, *, within: float = 60.0) -> float:
        """Turn to an angle and return the one that was reached. [degrees]"""

    def transcript(self) -> tuple[Exchange, ...]:
        """Return what was said on the line since the last call."""

    def close(self) -> None:
        """Leave the stage where it is."""


class ManualStage:
    """A person who turns the lamp by hand and says when it is done.

    Parameters
    ----------
    ask : callable
        Shows a request in words and the angle [degrees], and returns when it is done.
    """

    def __init__(self, ask: Callable[[str, float], None]) -> None:
        """Take how to ask; nobody knows where the lamp is."""
        self._ask = ask
        self._angle = float("nan")

    @property
    def angle(self) -> float:
        """What was confirmed last, NaN at first. [degrees]"""
        return self._angle

    def move(self, degrees: float, *, within: float = 60.0) -> float:  # noqa: ARG002
        """Ask for an angle, unless it is there. People take what time they need."""
        if degrees != self._angle:
            self._ask(f"turn the lamp to {degrees:g} degrees", degrees)
            self._angle = float(degrees)
        return self._angle

    def transcript(self) -> tuple[Exchange, ...]:
        """Return nothing: people's words are not kept."""
        return ()

    def close(self) -> None:
        """Leave the lamp where it is."""


class ZaberStage:
    """A Zaber rotary stage that speaks ASCII.

    Parameters
    ----------
    link : Link
        Open; the driver closes it.
    zero : float
        Angle of the stage at which the lamp's is 0. [degrees]
    """

    BAUDRATE: ClassVar[int] = 115200

    def __init__(self, link: Link, *, zero: float = 0.0) -> None:
        """Ask how many steps a turn has."""
        self._link = link
        self._zero = zero
        self._message = 0
        try:
            turn = float(self._ask("get limit.cycle.dist"))
        except (ValueError, CommandRejected) as error:
            link.close()
            raise WrongDevice(
                f"the stage at {link.name} does not say how many steps a turn has; a "
                "rotary stage is needed"
            ) from error
        except LinkError as error:
            link.close()
            raise type(error)(
                f"{error} (the driver is for a Zaber stage)", raw=error.raw
            ) from error
        except InstrumentError:
            link.close()
            raise
        if not 0 < turn < 1e12:
            link.close()
            raise WrongDevice(f"the stage at {link.name} does not turn; name another")
        self._steps = turn / 360

    @property
    def angle(self) -> float:
        """Where it is. [degrees]"""
        told = self._ask("get pos")
        try:
            return float(told) / self._steps - self._zero
        except ValueError as error:
            raise MalformedReply(
                f"the stage's position is {told!r}; ask again"
            ) from error

    def home(self, *, within: float = 120.0) -> None:
        """Find the reference position; the stage moves."""
        self._ask("home")
        self._wait(within)

    def move(self, degrees: float, *, within: float = 60.0) -> float:
        """Turn to an angle and return the one that was reached. [degrees]

        Raises
        ------
        NotHomed, OutOfTravel
            If the stage refuses.
        StageFault
            If it reports a fault, or is not there in time.
        """
        steps = round((degrees + self._zero) * self._steps)
        self._ask(f"move abs {steps}")
        self._wait(within)
        reached = self.angle
        if not abs(reached - degrees) <= _NEAR:
            raise StageFault(
                f"the stage stands at {reached:.2f} degrees instead of {degrees:g}; "
                "take away what blocks it, and home it"
            )
        return reached

    def stop(self) -> None:
        """Stop turning at once."""
        self._ask("stop")

    def transcript(self) -> tuple[Exchange, ...]:
        """Return what was said on the line since the last call."""
        return self._link.transcript()

    def close(self) -> None:
        """Leave the stage where it is, and close the port."""
        self._link.close()

    def __enter__(self) -> Self:
        """Return the driver, which is open."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()

    def _wait(self, within: float) -> None:
        """Wait until the stage has stopped."""
        deadline = time.monotonic() + within
        try:
            while self._exchange("").busy:
                if time.monotonic() > deadline:
                    self.stop()
                    raise StageFault(
                        f"the stage still turned after {within:g} s and was stopped; "
                        "set its speed, or take away what brakes it"
                    )
                self._link.pause(_POLL)
        except (Stopped, KeyboardInterrupt):
            # Whoever stops the program wants the lamp to stop too; no time to listen.
            self._link.send(replies.command("stop"))
            raise

    def _ask(self, words: str) -> str:
        """Return the data of the answer to a command."""
        return self._exchange(words).data

    def _exchange(self, words: str) -> replies.StageReply:
        """Send a command and return its answer; one that was garbled is asked again.

        To ask again is safe: every command names a place, none a distance.
        """
        for left in reversed(range(_ATTEMPTS)):
            self._link.drain()
            self._message = self._message % 99 + 1
            self._link.send(replies.command(words, message=self._message))
            try:
                reply = self._answer()
            except LinkError:
                if not left:
                    raise
                continue
            replies.require_sound(reply)
            return reply
        raise AssertionError  # the last attempt returns or raises

    def _answer(self) -> replies.StageReply:
        """Return the answer to the last command; alerts and the like are passed."""
        deadline = time.monotonic() + _ANSWER
        while True:
            left = deadline - time.monotonic()
            line = self._link.wanted_line(left, lambda line: line.startswith(b"@"))
            reply = replies.reply_of(line)
            if reply.message in (None, self._message):
                return reply
            if left <= 0:
                raise MalformedReply(
                    "the stage answers to other commands only; end the program that "
                    "uses it too",
                    raw=line,
                )
