"""What simulated spectroradiometers have in common: words, faults, noise."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from skinviz.instruments.meters import Array, Grid
from skinviz.instruments.simulate.faults import VERDICTS, Chunk, Faults
from skinviz.instruments.simulate.scene import Bench


@dataclass(eq=False)
class SimulatedMeter(ABC):
    """A device that is fed bytes and yields what it answers."""

    bench: Bench
    faults: Faults = field(default_factory=Faults)
    average: int = 1
    received: bytes = b""

    @abstractmethod
    def receive(self, data: bytes) -> Iterator[Chunk]:
        """Take bytes and yield the answer."""

    def words(self, data: bytes, ends: bytes) -> Iterator[bytes]:
        """Yield the commands that these bytes end."""
        for byte in data:
            if byte in ends:
                word, self.received = self.received, b""
                yield word
            else:
                self.received = (self.received + bytes([byte]))[-200:]

    def look(self, grid: Grid, fault: str) -> tuple[str, Array]:
        """Return the instrument's verdict, "" if it is well, and what it measured."""
        if fault in VERDICTS:
            self.bench.time.elapse(self.bench.exposure)
            return fault, np.zeros(grid.count)
        seen = self.bench.reading(grid.wavelengths, self.average)
        return ("dark" if seen.max() < self.bench.darkest else ""), seen
