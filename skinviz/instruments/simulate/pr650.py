"""A PR-650, byte for byte."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from skinviz.instruments.meters import Array, Grid
from skinviz.instruments.simulate.faults import Chunk
from skinviz.instruments.simulate.meter import SimulatedMeter

_GRID = Grid(380.0, 4.0, 101)
_CODES = {"dark": b"10", "over": b"19", "unsteady": b"16"}
_SETTING = re.compile(rb"S01,,,,(\d*),(\d*),(\d\d),([01])")
_TOLD = {
    b"D111": b"PR-650\r\n",
    b"D110": b"60965203\r\n",
    b"D120": b"0101,008.0,0380.,0780.,4.0\r\n",
}


@dataclass(eq=False)
class SimulatedPR650(SimulatedMeter):
    """Holds its last good spectrum, also after a measurement that failed."""

    spectrum: bytes = b"".join(b"%04d.,0.000E+00\r\n" % nm for nm in range(380, 781, 4))
    integral: bytes = b"0.000E+00\r\n"
    quality: bytes = b"00"

    def receive(self, data: bytes) -> Iterator[Chunk]:
        """Take bytes and yield the answer."""
        for word in self.words(data, b"\r\n"):
            yield from self._answer(word)

    def _answer(self, word: bytes) -> Iterator[Chunk]:
        """Yield the answer to a command."""
        if word in _TOLD:
            yield _TOLD[word]
        elif word in (b"B0", b"B1", b"B2", b"B3"):
            yield b"000\r\n"
        elif word == b"M5":
            fault = self.faults.take()
            self._measure(fault)
            yield from self.faults.on_the_way(fault, self._reply())
        elif word == b"D5":
            yield from self.faults.on_the_way(self.faults.take(), self._reply())
        elif word.startswith(b"S"):
            yield self._set(word)

    def _set(self, word: bytes) -> bytes:
        """Take a setting and return the acknowledgement."""
        found = _SETTING.fullmatch(word)
        if found is None:
            return b"001\r\n"
        self.average = max(1, int(found[3]))
        return b"000\r\n"

    def _measure(self, fault: str) -> None:
        """Measure; what failed leaves the spectrum before it in the memory."""
        verdict, seen = self.look(_GRID, fault)
        self.quality = _CODES[verdict] if verdict else b"00"
        if not verdict:
            self.integral = f"{seen.sum() * _GRID.step:.3E}\r\n".encode("ascii")
            self.spectrum = _rows(seen)

    def _reply(self) -> bytes:
        """Return quality, integral and rows."""
        return self.quality + b",0\r\n" + self.integral + self.spectrum


def _rows(seen: Array) -> bytes:
    """Return a spectrum as it is printed."""
    rows = zip(_GRID.wavelengths, seen, strict=True)
    return "".join(f"{x:04.0f}.,{y:.3E}\r\n" for x, y in rows).encode("ascii")
