"""A PR-655 or PR-670, byte for byte."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from skinviz.instruments.meters import Array, Grid
from skinviz.instruments.simulate.faults import Chunk
from skinviz.instruments.simulate.meter import SimulatedMeter

_CODES = {"dark": -8, "over": -2, "unsteady": -1}
_WELL = b"0000\r\n"
_GRID, _FINE_GRID = Grid(380.0, 4.0, 101), Grid(380.0, 2.0, 201)


@dataclass(eq=False)
class SimulatedPR655(SimulatedMeter):
    """Answers to ``PHOTO`` once, then to commands, until ``Q``.

    ``hurried`` is how real meters are that lose ``PHOTO`` when it comes all at once.
    """

    model: str = "PR-655"
    grid: Grid = _GRID
    longest: int = 6000
    remote: bool = False
    hurried: bool = False
    held: bytes = b"-2000\r\n"

    def receive(self, data: bytes) -> Iterator[Chunk]:
        """Take bytes and yield the answer."""
        if self.hurried and b"PHOTO" in data:
            return
        for byte in data:
            yield from self._letter(bytes([byte]))

    def _letter(self, letter: bytes) -> Iterator[Chunk]:
        """Take one byte; a lone ``Q`` leaves without an answer."""
        if not self.remote:
            self.received = (self.received + letter)[-5:]
            if self.received == b"PHOTO":
                self.remote, self.received = True, b""
                yield b"\x00REMOTE MODE"
        elif letter == b"Q" and not self.received:
            self.remote = False
        else:
            for word in self.words(letter, b"\r\n"):
                yield from self._answer(word)

    def _answer(self, word: bytes) -> Iterator[Chunk]:
        """Yield the answer to a command."""
        grid = self.grid
        last = grid.first + grid.step * (grid.count - 1)
        told = {
            b"D111": self.model,
            b"D110": "61234567",
            b"D114": "1.18",
            b"D120": f"{grid.count},0.00,{grid.first:.0f},{last:.0f},{grid.step:g}"
            ",256,7,247",
            b"D13": f"0,{1000 * self.bench.exposure:.2f}",
        }
        if word in told:
            yield f"00000,{told[word]}\r\n".encode("ascii")
        elif word == b"M5":
            fault = self.faults.take()
            self._measure(fault)
            yield from self.faults.on_the_way(fault, self.held)
        elif word == b"D5":
            yield from self.faults.on_the_way(self.faults.take(), self.held)
        elif word[:2] in (b"SU", b"SE", b"SN", b"SS"):
            yield self._set(word[:2], word[2:])
        else:
            yield b"-1000\r\n"

    def _set(self, what: bytes, value: bytes) -> bytes:
        """Set a value and return the acknowledgement."""
        if not value.isdigit():
            return b"-1001\r\n"
        number = int(value)
        if what == b"SE" and not (number == 0 or 3 <= number <= self.longest):
            return b"-1005\r\n"
        if what == b"SN":
            self.average = max(1, number)
        return _WELL

    def _measure(self, fault: str) -> None:
        """Measure and hold the reply."""
        verdict, seen = self.look(self.grid, fault)
        if verdict:
            self.held = b"%05d\r\n" % _CODES[verdict]
        else:
            self.held = self._printed(seen)

    def _printed(self, seen: Array) -> bytes:
        """Return a spectrum as it is printed."""
        nm = self.grid.wavelengths
        photons = seen * nm * 5.034e15
        header = (
            f"00000,0,{nm[seen.argmax()]:.3e},{seen.sum() * self.grid.step:.3e},"
            f"{photons.sum() * self.grid.step:.3e}"
        )
        rows = (f"{x:.0f},{y:.3e}" for x, y in zip(nm, seen, strict=True))
        return "\r\n".join((header, *rows, "")).encode("ascii")


@dataclass(eq=False)
class SimulatedPR670(SimulatedPR655):
    """The model with twice the points."""

    model: str = "PR-670"
    grid: Grid = _FINE_GRID
    longest: int = 30000
