"""From a log's raw readings to means: of the white, of each site, of stray light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skinviz.errors import DataError
from skinviz.instruments.arrangement import WHITE, Arrangement
from skinviz.instruments.errors import WhiteMissing
from skinviz.instruments.factor import Array, Frame, bend, between, drift, frame_of
from skinviz.instruments.plan import AFTER, BEFORE, Plan, Step
from skinviz.instruments.skinlog import SkinLog


@dataclass(frozen=True, eq=False)
class White:
    """What the white was at a time.

    Attributes
    ----------
    frame : Frame
        On a line between its readings before and after.
    drift : float
        By what share it changed from the one to the other. [1]
    bend : float
        Standard uncertainty of the line, the same share in all bands. [1]
    """

    frame: Frame
    drift: float
    bend: float


@dataclass(frozen=True, eq=False)
class Frames:
    """The means of a session.

    Attributes
    ----------
    plan : Plan
    wavelengths : (n,) ndarray
        [nm]
    by_step : dict of int to tuple of Frame
        The steps' means in the order of time: one for each segment of the session in
        which all the step's readings were taken. Of stray light that was too dark to
        be measured twice there is none.
    """

    plan: Plan
    wavelengths: Array
    by_step: dict[int, tuple[Frame, ...]]

    def sample(self, site: str, how: Arrangement) -> Frame:
        """Return the last mean of a site.

        Raises
        ------
        DataError
            If it was not measured.
        """
        found = self._of(site, how)
        if not found:
            raise DataError(
                f"{site!r} was not measured at {how.illumination:g}/{how.viewing:g} "
                f"degrees, polarisers {how.state}; go on with --resume"
            )
        return found[-1]

    def white(self, how: Arrangement, time: float) -> White:
        """Return what the white was at a time.

        Raises
        ------
        WhiteMissing
            If it was not measured before and after.
        DriftExceeded
            If it changed too much.
        """
        whites = sorted(
            (f for sweep in (BEFORE, AFTER) for f in self._of(sweep, how)),
            key=lambda frame: frame.time,
        )
        before = [frame for frame in whites if frame.time <= time]
        after = [frame for frame in whites if frame.time > time]
        if not before or not after:
            raise WhiteMissing(
                f"the white was not measured {'before' if not before else 'after'} the "
                f"skin at {how.illumination:g}/{how.viewing:g} degrees, polarisers "
                f"{how.state}; finish the plan with --resume"
            )
        first, last = before[-1], after[0]
        return White(
            between(first, last, time), drift(first, last), bend(first, last, time)
        )

    def ambient(self, sweep: str, state: str) -> Frame | None:
        """Return the stray light of a sweep, None if there was too little."""
        for step in self.plan.steps:
            how = step.arrangement
            if step.sweep == sweep and how.state == state and not how.lamp:
                found = self.by_step.get(step.number, ())
                return found[-1] if found else None
        return None

    def scatter(self) -> dict[str, float]:
        """Return the largest scatter of repeats of the white and of each site. [1]

        The lamp's own is in both; what a site has more is the skin's and the hand's.
        """
        found: dict[str, float] = {}
        for step in self.plan.steps:
            if step.arrangement.lamp:
                name = step.sweep if step.sweep in self.plan.sites else WHITE
                for frame in self.by_step.get(step.number, ()):
                    found[name] = max(found.get(name, 0.0), frame.scatter)
        return found

    def _of(self, sweep: str, how: Arrangement) -> tuple[Frame, ...]:
        """Return the means of a sweep in an arrangement, whatever the target."""
        for step in self.plan.steps:
            if step.sweep == sweep and _alike(step, how):
                return self.by_step.get(step.number, ())
        return ()


def frames_of(log: SkinLog) -> Frames:
    """Return the means of a session's readings.

    Raises
    ------
    DataError
        If there is no reading, or they are on several grids.
    """
    plan = Plan.from_json(log.header["plan"])
    grids = {r["grid"]: r["wavelengths"] for r in log.records if r["kind"] == "grid"}
    readings: dict[tuple[int, int], dict[int, tuple[list[float], float]]] = {}
    dark: dict[tuple[int, int], set[int]] = {}
    used: set[int] = set()
    for record in log.records:
        if record["kind"] == "reading" and record["step"] >= 0:
            key = (record["step"], record["segment"])
            time = (record["begun"] + record["t"]) / 2
            readings.setdefault(key, {})[record["repeat"]] = (record["radiance"], time)
            used.add(record["grid"])
        elif record["kind"] == "dark":
            key = (record["step"], record["segment"])
            dark.setdefault(key, set()).add(record["repeat"])
    if len(used) != 1:
        raise DataError(
            "there is no reading in the log yet; go on with --resume"
            if not used
            else "the readings have several grids; measure with one instrument"
        )
    by_step: dict[int, list[Frame]] = {}
    for key, taken in sorted(readings.items()):
        step, _ = key
        done = len(taken | dict.fromkeys(dark.get(key, ())))
        if done >= plan.repeats and len(taken) > 1:
            values, times = zip(*taken.values(), strict=True)
            by_step.setdefault(step, []).append(frame_of(values, times))
    wavelengths = np.array(grids[used.pop()])
    return Frames(plan, wavelengths, {k: tuple(v) for k, v in by_step.items()})


def _alike(step: Step, how: Arrangement) -> bool:
    """Return whether a step's angles and polarisers are these, the lamp on."""
    own = step.arrangement
    return own.lamp and (own.illumination, own.viewing, own.state) == (
        how.illumination,
        how.viewing,
        how.state,
    )
