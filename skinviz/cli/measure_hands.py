"""What a person is asked to do at a bench, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol

from skinviz.instruments.arrangement import STATES, WHITE, Arrangement


class Follower(Protocol):
    """Who does at a simulated bench what a person was asked for."""

    def arrange(self, wanted: Arrangement, sweep: str) -> None:
        """Arrange the bench."""

    def turn(self, words: str, degrees: float) -> None:
        """Turn the lamp."""


class Asking:
    """Hands that are asked, each time for what differs from before.

    Parameters
    ----------
    ask : callable
        Shows what to do and returns when it is done.
    follower : Follower or None
        Who does it at a simulated bench.
    turns : bool
        Whether the lamp is turned by hand too, not by a motor.
    """

    def __init__(
        self,
        ask: Callable[[list[str]], None],
        follower: Follower | None,
        *,
        turns: bool,
    ) -> None:
        """Begin with a bench of which nothing is known."""
        self._ask = ask
        self._follower = follower
        self._turns = turns
        self._before: tuple[Arrangement, str] | None = None

    def arrange(self, wanted: Arrangement, sweep: str) -> None:
        """Ask for what differs and return when it is done."""
        words = list(requests(self._before, wanted, sweep, turns=self._turns))
        if words:
            self._ask(words)
        self._before = (wanted, sweep)
        if self._follower is not None:
            self._follower.arrange(wanted, sweep)

    def turn(self, words: str, degrees: float) -> None:
        """Do nothing more: the angle was asked for with all else."""
        if self._follower is not None:
            self._follower.turn(words, degrees)


def requests(
    before: tuple[Arrangement, str] | None,
    wanted: Arrangement,
    sweep: str,
    *,
    turns: bool,
) -> Iterator[str]:
    """Yield what to do so that a bench stands as wanted, a sentence each."""
    now = None if before is None else before[0]
    if now is None or now.viewing != wanted.viewing:
        yield (
            f"Set the meter to {wanted.viewing:g} degrees from the normal and focus it "
            "on the axis"
        )
    if before is None or before[1] != sweep:
        yield (
            "Place the white tile, its face where the skin will be; aim so that the "
            "meter's spot lies wholly on it"
            if wanted.target == WHITE
            else f"Place the skin, {sweep}: flat, at rest, where the tile was; aim so "
            "that the spot lies wholly on it"
        )
    if turns and (now is None or now.illumination != wanted.illumination):
        yield f"Turn the lamp to {wanted.illumination:g} degrees{_side(wanted)}"
    if now is None or now.state != wanted.state:
        yield _polarisers(wanted.state)
    if now is None or now.lamp != wanted.lamp:
        yield (
            "Open the lamp's shutter"
            if wanted.lamp
            else "Shutter the lamp, and leave all other light as it is"
        )


def in_words(how: Arrangement, sweep: str) -> str:
    """Return an arrangement in a few words."""
    light = (
        f"{how.illumination:g}/{how.viewing:g} degrees" if how.lamp else "stray light"
    )
    filters = "" if how.state == "open" else f", polarisers {how.state}"
    return f"{sweep}, {light}{filters}"


def _polarisers(state: str) -> str:
    """Return how the polarisers are to stand."""
    lamp, analyser = STATES[state]
    if analyser is None:
        return "Take the polarisers off"
    own = "none" if lamp is None else f"{lamp:g} degrees"
    return (
        f"Polarisers {state}: before the lamp {own}, before the meter {analyser:g} "
        "degrees from the plane of incidence"
    )


def _side(wanted: Arrangement) -> str:
    """Return on which side of the normal the lamp is."""
    if wanted.illumination == 0:
        return ", along the normal"
    side = "across from the meter" if wanted.illumination > 0 else "on the meter's side"
    return f" from the normal, {side}"
