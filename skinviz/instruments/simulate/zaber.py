"""A Zaber rotary stage, byte for byte."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from skinviz.instruments.simulate.faults import ALERT, Chunk, Faults
from skinviz.instruments.simulate.scene import Bench
from skinviz.instruments.zaber_replies import checksum

_TURN = 384000  # steps
_ALERT = b"!01 1 IDLE --\r\n"


@dataclass(eq=False)
class SimulatedZaber:
    """Turns the bench's lamp, at a speed. [degrees/s]"""

    bench: Bench
    faults: Faults = field(default_factory=Faults)
    speed: float = 60.0
    homed: bool = True
    travel: tuple[float, float] = (-95.0, 95.0)
    fault_flag: bytes = b""
    received: bytes = b""
    begun: float = 0.0
    origin: float = 0.0
    goal: float = 0.0

    def receive(self, data: bytes) -> Iterator[Chunk]:
        """Take bytes and yield the answer."""
        for byte in data:
            if byte in b"\r\n":
                line, self.received = self.received, b""
                if line.startswith(b"/"):
                    yield from self._line(line)
            else:
                self.received = (self.received + bytes([byte]))[-200:]

    @property
    def place(self) -> float:
        """Where the lamp is now. [degrees]"""
        gone = self.speed * (self.bench.time.now() - self.begun)
        way = self.goal - self.origin
        return self.goal if gone >= abs(way) else self.origin + gone * (way > 0 or -1)

    def _line(self, line: bytes) -> Iterator[Chunk]:
        """Yield the answer to a line, nothing if its checksum is wrong."""
        body, mark, told = line[1:].rpartition(b":")
        if not mark:
            body = told
        elif told != checksum(body):
            return
        cells = body.split(b" ")
        data = self._obey(b" ".join(cells[3:]))
        self.bench.turn(self.place)
        verdict = b"RJ" if data.startswith(b"BAD") else b"OK"
        state = b"IDLE" if self.place == self.goal else b"BUSY"
        flag = self.fault_flag or (b"--" if self.homed else b"WR")
        answer = b"%b 1 %b %b %b %b %b" % (
            cells[0], cells[2], verdict, state, flag, data,
        )  # fmt: skip
        whole = b"@" + answer + b":" + checksum(answer) + b"\r\n"
        fault = self.faults.take()
        yield from self.faults.on_the_way(
            fault, _ALERT + whole if fault == ALERT else whole
        )

    def _obey(self, words: bytes) -> bytes:
        """Do what is said and return the data of the answer."""
        self.bench.time.tick()
        if words.startswith(b"move abs "):
            return self._move(words)
        told = {
            b"get limit.cycle.dist": b"%d" % _TURN,
            b"get pos": b"%d" % round(self.place * _TURN / 360),
        }
        goals = {b"": self.goal, b"stop": self.place, b"home": 0.0}
        if words in goals:
            self.homed = self.homed or words == b"home"
            self._go(goals[words])
        return told.get(words, b"0" if words in goals else b"BADCOMMAND")

    def _move(self, words: bytes) -> bytes:
        """Begin to move, if the stage knows where it is and can go there."""
        goal = int(words.split()[-1]) * 360 / _TURN
        if not self.homed or not self.travel[0] <= goal <= self.travel[1]:
            return b"BADDATA"
        self._go(goal)
        return b"0"

    def _go(self, goal: float) -> None:
        """Begin to move, unless it goes there already."""
        if goal != self.goal:
            self.origin, self.goal = self.place, goal
            self.begun = self.bench.time.now()
