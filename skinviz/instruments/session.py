"""A session: the plan's steps one after the other, every reading logged at once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

from skinviz.instruments.arrangement import SAMPLE, Arrangement
from skinviz.instruments.errors import InstrumentError, Stopped, TooDark, Unsteady
from skinviz.instruments.factor import is_steady
from skinviz.instruments.link import Exchange
from skinviz.instruments.meters import Array, Reading, Spectroradiometer
from skinviz.instruments.patience import patient_reading
from skinviz.instruments.plan import BEFORE, Plan, Step
from skinviz.instruments.skinlog import LogWriter
from skinviz.instruments.stages import RotationStage

WARMING = -1
"""Number of the step in which the lamp settles, before the plan's own."""

_MOST_WARMING = 200  # readings until the lamp must have settled
_BETWEEN_WARMING = 10.0  # s from one of them to the next


class Hands(Protocol):
    """Who arranges the bench, but for a lamp that a motor turns."""

    def arrange(self, wanted: Arrangement, sweep: str) -> None:
        """Return when the bench stands as wanted; the sweep names the site."""


class Watcher(Protocol):
    """Who is told how it goes."""

    def begins(self, step: Step, of: int) -> None:
        """Take the step that begins, and how many the plan has."""

    def read(self, step: Step, readings: Sequence[Reading], of: int) -> None:
        """Take the readings of a step so far, and how many there will be.

        ``of`` is 0 while the lamp settles: as many as that takes.
        """

    def failed(self, error: InstrumentError) -> None:
        """Take an error that is being made good."""


@dataclass(eq=False)
class Session:
    """A session that is open.

    Attributes
    ----------
    plan : Plan
    log : LogWriter
    segment : int
        0, and one more each time that the session was resumed.
    done : frozenset of int
        Numbers of the steps that earlier segments finished.
    grids : list of list of float
        Wavelengths that the log has told. [nm]
    clock : callable
        Seconds since the log began.
    """

    plan: Plan
    log: LogWriter
    segment: int
    done: frozenset[int]
    grids: list[list[float]]
    clock: Callable[[], float]

    def pending(self) -> tuple[Step, ...]:
        """Return the steps that are left.

        A session that is resumed measures the white anew before the skin, because the
        lamp may have been off meanwhile.
        """
        steps = self.plan.steps
        left = [step for step in steps if step.number not in self.done]
        if self.segment and any(step.arrangement.target == SAMPLE for step in left):
            left = [
                step
                for step in steps
                if step.number not in self.done
                or (step.sweep == BEFORE and step.arrangement.lamp)
            ]
        return tuple(left)

    def run(
        self,
        meter: Spectroradiometer,
        stage: RotationStage,
        hands: Hands,
        watcher: Watcher,
        *,
        stop: threading.Event | None = None,
        pause: Callable[[float], object] | None = None,
    ) -> None:
        """Measure what is left of the plan.

        Parameters
        ----------
        meter, stage, hands, watcher
            What measures, turns and arranges, and who is told.
        stop : threading.Event, optional
            Ends the session before the next reading when it is set.
        pause : callable, optional
            Lets so many seconds pass while the lamp settles; waits for ``stop`` if
            not given.

        Raises
        ------
        InstrumentError
            What could not be made good. All readings until then are in the log, and
            the session can be resumed.
        """
        steps = self.pending()
        stop = threading.Event() if stop is None else stop
        run = _Run(self, meter, stage, hands, watcher, stop, pause or stop.wait)
        try:
            if steps and self.plan.warm_up:
                run.warm_up()
            for step in steps:
                run.take(step)
        except InstrumentError as error:
            said = _said((*meter.transcript(), *stage.transcript()))
            self._append("error", **_told(error), said=said)
            raise
        self._append("end")

    def _append(self, kind: str, **rest: Any) -> None:
        """Log a record of this segment."""
        record = {"kind": kind, "t": self.clock(), "segment": self.segment}
        self.log.append(record | rest)

    def _grid(self, wavelengths: Array) -> int:
        """Return the number of a grid, which is logged when it is new."""
        grid = wavelengths.tolist()
        if grid not in self.grids:
            self.log.append(
                {"kind": "grid", "grid": len(self.grids), "wavelengths": grid}
            )
            self.grids.append(grid)
        return self.grids.index(grid)


@dataclass(eq=False)
class _Run:
    """What a session runs with."""

    session: Session
    meter: Spectroradiometer
    stage: RotationStage
    hands: Hands
    watcher: Watcher
    stop: threading.Event
    pause: Callable[[float], object]

    def warm_up(self) -> None:
        """Read the white until three readings in a row agree."""
        first = self.session.plan.steps[0].arrangement
        step = Step(WARMING, BEFORE, replace(first, lamp=True))
        self._arrange(step)
        taken: list[Reading] = []
        while not is_steady([reading.radiance.sum() for reading in taken]):
            if len(taken) >= _MOST_WARMING:
                raise Unsteady(
                    f"the lamp did not settle in {len(taken)} readings; let it warm "
                    "up for half an hour, check its supply, and go on with --resume"
                )
            if taken:
                self.pause(_BETWEEN_WARMING)
            reading = self._read(step, len(taken))
            if reading is not None:
                taken.append(reading)
                self.watcher.read(step, taken, 0)

    def take(self, step: Step) -> None:
        """Take the readings of a step."""
        self._arrange(step)
        taken: list[Reading] = []
        for repeat in range(self.session.plan.repeats):
            reading = self._read(step, repeat)
            if reading is None:
                continue
            taken.append(reading)
            self.watcher.read(step, taken, self.session.plan.repeats)

    def _arrange(self, step: Step) -> None:
        """Have the bench arranged."""
        self.watcher.begins(step, len(self.session.plan.steps))
        self.hands.arrange(step.arrangement, step.sweep)
        angle = self.stage.move(step.arrangement.illumination)
        said = _said(self.stage.transcript())
        self.session._append("arrange", step=step.number, angle=angle, said=said)

    def _read(self, step: Step, repeat: int) -> Reading | None:
        """Measure and log once; None where the lamp is off and there is no light."""
        if self.stop.is_set():
            raise Stopped("stopped as asked; go on with --resume")
        number = {"step": step.number, "repeat": repeat}
        begun = self.session.clock()
        try:
            reading = patient_reading(self.meter, self._failed)
        except TooDark:
            if step.arrangement.lamp:
                raise
            self.session._append("dark", **number)
            return None
        self.session._append(
            "reading",
            **number,
            begun=begun,
            grid=self.session._grid(reading.wavelengths),
            radiance=reading.radiance.tolist(),
            exposure=reading.exposure,
            warnings=list(reading.warnings),
            said=_said(self.meter.transcript()),
        )
        return reading

    def _failed(self, error: InstrumentError) -> None:
        """Log an error that is being made good."""
        self.session._append(
            "error", **_told(error), said=_said(self.meter.transcript())
        )
        self.watcher.failed(error)


def _told(error: InstrumentError) -> dict[str, Any]:
    """Return an error as it is logged."""
    return {
        "error": type(error).__name__,
        "message": str(error),
        "raw": error.raw.decode("latin-1"),
    }


def _said(exchanges: Iterable[Exchange]) -> list[list[Any]]:
    """Return a conversation as it is logged: time, direction, bytes as Latin-1."""
    return [
        [round(piece.at, 6), ">" if piece.sent else "<", piece.data.decode("latin-1")]
        for piece in exchanges
    ]
