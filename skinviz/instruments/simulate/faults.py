"""What can go wrong with an instrument and its cable, on demand or at random."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from skinviz._validate import in_range, one_of

Chunk = bytes | float | None
"""Bytes to send, seconds to wait, or None: the cable is pulled out."""

VERDICTS = ("dark", "over", "unsteady")
"""What the instrument says instead of a spectrum."""

ON_THE_WAY = ("silent", "cut", "drop_row", "garble", "bitflip", "slow", "unplug")
"""What happens to a reply between instrument and computer."""

ALERT = "alert"
"""A stage's own word, in front of a reply."""

FAULTS = (*VERDICTS, *ON_THE_WAY, ALERT)
"""All of them."""


@dataclass(eq=False)
class Faults:
    """The faults to come: those that are queued, then some at random.

    Attributes
    ----------
    queue : deque of str
        What happens to the next measurements, one each; "" is nothing.
    rate : float
        Share of the later ones to which something happens. [1]
    kinds : tuple of str
        What may happen at random.
    seed : int
        Of the chance.
    late : float
        By how much a slow reply is late. [s]
    """

    queue: deque[str] = field(default_factory=deque)
    rate: float = 0.0
    kinds: tuple[str, ...] = tuple(k for k in FAULTS if k not in ("unplug", ALERT))
    seed: int = 0
    late: float = 1.5

    def __post_init__(self) -> None:
        """Refuse faults that there are not."""
        in_range(self.rate, 0.0, 1.0, "rate of faults")
        for kind in (*self.queue, *self.kinds):
            if kind:
                one_of(kind, FAULTS, "fault")
        self.rng = np.random.default_rng(self.seed)

    def add(self, kinds: Iterable[str]) -> None:
        """Queue faults."""
        self.queue.extend(
            one_of(kind, FAULTS, "fault") if kind else "" for kind in kinds
        )

    def take(self) -> str:
        """Return what happens to this measurement, "" if nothing."""
        if self.queue:
            return self.queue.popleft()
        if self.rate and self.rng.random() < self.rate:
            return str(self.rng.choice(list(self.kinds)))
        return ""

    def on_the_way(self, fault: str, reply: bytes) -> Iterator[Chunk]:
        """Yield what becomes of a reply, as it is where nothing happens to it."""
        if fault == "silent":
            return
        if fault == "cut":
            yield reply[: int(len(reply) * self.rng.uniform(0.2, 0.9))]
        elif fault == "unplug":
            yield reply[: len(reply) // 2]
            yield 0.02
            yield None
        elif fault == "slow":
            yield self.late
            yield reply
        else:
            yield _CHANGES[fault](self, reply) if fault in _CHANGES else reply

    def _drop_row(self, reply: bytes) -> bytes:
        """Leave a line out that is not the first."""
        lines = reply.splitlines(keepends=True)
        if len(lines) > 1:
            del lines[int(self.rng.integers(1, len(lines)))]
        return b"".join(lines)

    def _garble(self, reply: bytes) -> bytes:
        """Replace a few bytes by others."""
        changed = bytearray(reply)
        count = int(self.rng.integers(2, 9))
        at = int(self.rng.integers(0, max(1, len(reply) - count)))
        changed[at : at + count] = self.rng.bytes(min(count, len(reply)))
        return bytes(changed)

    def _bitflip(self, reply: bytes) -> bytes:
        """Turn one bit of one byte over, but of no line's end."""
        at = int(self.rng.choice([i for i, b in enumerate(reply) if b not in b"\r\n"]))
        changed = bytearray(reply)
        changed[at] ^= 1 << int(self.rng.integers(0, 7))
        return bytes(changed)


_CHANGES = {
    "drop_row": Faults._drop_row,
    "garble": Faults._garble,
    "bitflip": Faults._bitflip,
}
