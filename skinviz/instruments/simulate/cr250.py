"""A CR-250, byte for byte."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from skinviz.instruments.meters import Array, Grid
from skinviz.instruments.simulate.faults import Chunk
from skinviz.instruments.simulate.meter import SimulatedMeter

_GRID = Grid(380.0, 4.0, 101)
_ERRORS = {
    "dark": b"ER:-305:M:Light intensity too low or unmeasurable\r\n",
    "over": b"ER:-306:M:Light intensity too high\r\n",
    "unsteady": b"ER:-303:M:Light intensity fluctuating\r\n",
}
_TOLD = {
    b"RC InstrumentType": b"2",
    b"RC Model": b"CR-250",
    b"RC ID": b"A00234",
}


@dataclass(eq=False)
class SimulatedCR250(SimulatedMeter):
    """Measures when asked and sends the values when asked again."""

    held: bytes = b"ER:-503:RM Spectrum:No measurement\r\n"
    fault: str | None = None

    def receive(self, data: bytes) -> Iterator[Chunk]:
        """Take bytes and yield the answer."""
        for word in self.words(data, b"\n"):
            yield from self._answer(word.strip())

    def _answer(self, word: bytes) -> Iterator[Chunk]:
        """Yield the answer to a command."""
        if word in _TOLD:
            yield b"OK:0:%b:%b\r\n" % (word, _TOLD[word])
        elif word == b"RM Exposure":
            yield b"OK:0:RM Exposure:%.2f\r\n" % (1000 * self.bench.exposure)
        elif word == b"M":
            yield from self._measure(self.faults.take())
        elif word == b"RM Spectrum":
            # A measurement's own fault, which may be none, or one of reading again.
            fault = self.faults.take() if self.fault is None else self.fault
            self.fault = None
            yield from self.faults.on_the_way(fault, self.held)
        elif word.startswith(b"SM "):
            yield from self._set(word)
        else:
            yield b"ER:-500:%b:Invalid command\r\n" % word[:40]

    def _set(self, word: bytes) -> Iterator[Chunk]:
        """Take a setting and yield the acknowledgement."""
        if word.startswith(b"SM ExposureX "):
            self.average = max(1, int(word.split()[-1]))
        yield b"OK:0:%b:\r\n" % word

    def _measure(self, fault: str) -> Iterator[Chunk]:
        """Measure; faults on the way meet the values, when they are asked for."""
        verdict, seen = self.look(_GRID, fault)
        if verdict:
            yield _ERRORS[verdict]
            return
        self.held = _printed(seen)
        self.fault = fault
        yield b"OK:0:M:\r\n"


def _printed(seen: Array) -> bytes:
    """Return a spectrum as it is printed."""
    last = _GRID.first + _GRID.step * (_GRID.count - 1)
    header = f"OK:0:RM Spectrum:{_GRID.first:.1f},{last:.1f},{_GRID.step:.1f},"
    rows = "".join(f"{value:.6e}\r\n" for value in seen)
    return f"{header}{_GRID.count}\r\n{rows}".encode("ascii")
