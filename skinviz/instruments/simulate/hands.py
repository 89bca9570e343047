"""Hands that arrange a simulated bench, and take their time as people do."""

from __future__ import annotations

from dataclasses import dataclass, replace

from skinviz.instruments.arrangement import Arrangement
from skinviz.instruments.simulate.scene import Bench
from skinviz.instruments.stages import ManualStage


@dataclass(frozen=True, eq=False)
class SimulatedHands:
    """Arrange a bench, each change in so many seconds."""

    bench: Bench
    seconds: float = 0.0

    def arrange(self, wanted: Arrangement, sweep: str) -> None:  # noqa: ARG002
        """Arrange all but the lamp's angle, which a stage or a hand turns."""
        now = self.bench.arrangement
        other = replace(wanted, illumination=now.illumination)
        if other != now:
            self.bench.time.elapse(self.seconds)
            self.bench.arrange(other)

    def turn(self, words: str, degrees: float) -> None:  # noqa: ARG002
        """Turn the lamp."""
        self.bench.time.elapse(self.seconds)
        self.bench.turn(degrees)

    def stage(self) -> ManualStage:
        """Return a stage that these hands turn."""
        return ManualStage(self.turn)
