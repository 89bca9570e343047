"""``plan``: the cheapest way to a picture that keeps a colour tolerance."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from skinviz._threads import processors
from skinviz._validate import in_range
from skinviz.rendering.finding import Finding
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.knobs import KNOBS, Knob, Setting, sampling
from skinviz.rendering.knobs.knob import MS
from skinviz.rendering.pilot import FILLED, pilot_of
from skinviz.rendering.plan import MOST_SAMPLES, Plan
from skinviz.rendering.rates import Rates, machine_rates
from skinviz.rendering.stage import Stage, stage_of
from skinviz.rendering.tolerance import edge_allowance
from skinviz.rendering.trial import Trial
from skinviz.rendering.work import Work, work_of
from skinviz.scene.scene import Scene

TIGHTEST, LOOSEST = 0.01, 100.0
"""Tolerances that may be asked for. [ΔE00]"""

_TRIAL_FIXED = 4.0  # ms, whatever the scene
_PILOT_TRIALS = 4.0  # that a pilot costs, and must be worth
_SAMPLE_TRIALS = 4.0  # that finding out about samples costs
_FEW_RAYS: Setting = {"samples": 1, "refine": 8.0}  # that may do, in the end
_NEVER = 1e6  # a contrast that no pixel has


def plan(
    scene: Scene, tolerance: float = 1.0, *, geometry: Geometry | None = None
) -> Plan:
    """Return the cheapest way to compute a scene's picture that keeps a tolerance.

    Parameters
    ----------
    scene : Scene
        What is to be shown.
    tolerance : float
        What the 99th percentile of the colour differences to the reference may be:
        over the pixels that the mesh fills, and at edges where it is at least 2. The
        reference is ``Plan()``. [ΔE00], 0.01 to 100
    geometry : Geometry, optional
        Of the scene's mesh, where it is at hand from :func:`geometry_of`.

    Returns
    -------
    plan : Plan
        To be given to :func:`render`; ``plan.explain()`` says what it leaves out,
        what that changes and what it saves.

    Raises
    ------
    ArgumentError
        If the tolerance is outside its range.
    MeshError
        If the mesh cannot be shown.

    Notes
    -----
    Each choice is priced on some two thousand pixels of this scene, drawn evenly over
    what is seen and apart at its edges, by a bound that the 99th percentile exceeds
    in one case of a thousand. Where finding out would cost more than it could save,
    the reference's way is kept.
    """
    return planned(stage_of(scene, Plan(), geometry), tolerance).plan


def planned(stage: Stage, tolerance: float) -> Stage:
    """Return a stage of the reference with the cheapest plan that keeps a tolerance."""
    in_range(tolerance, TIGHTEST, LOOSEST, "tolerance", "ΔE00")
    work, rates = work_of(stage), machine_rates()
    search = _Search(stage, tolerance, work, rates)
    if search.worth_it:
        search.decide()
    return search.result()


@dataclass
class _Search:
    """The choices made so far, of one stage and tolerance."""

    reference: Stage
    tolerance: float
    work: Work
    rates: Rates

    def __post_init__(self) -> None:
        """Begin at the reference."""
        self.base = self.stage = self.reference
        self.spent: dict[str, float] = {}
        self.found: dict[str, tuple[float | None, str, float | None]] = {}

    @property
    def left(self) -> float:
        """What of the tolerance is not used up by what is priced by itself."""
        return self.tolerance - sum(self.spent.values())

    def trial_cost(self, plan: Plan) -> float:
        """Return what it takes to look at all rays of a pilot, about. [ms]"""
        few = Work(self.reference, 1.3 * FILLED, 1.0, 0.0)
        all_rays = plan.replace(samples=MOST_SAMPLES, refine=None, bounce_rays=0)
        return _TRIAL_FIXED + self.cost(all_rays, few)

    def _price(self, knob: Knob) -> float:
        """Return what it takes to find out about one of a knob's levels. [ms]"""
        if knob.price is None:
            return self.trial_cost(self.stage.plan)
        price = knob.price(self.stage.plan, self.work, self.rates)
        return _TRIAL_FIXED + price * MS / processors()

    def cost(self, plan: Plan, work: Work | None = None) -> float:
        """Return what a plan takes, about. [ms]"""
        each = sum(knob.cost(plan, work or self.work, self.rates) for knob in KNOBS)
        return each * MS / processors()

    @property
    def worth_it(self) -> bool:
        """Whether the cheapest levels of all knobs would save more than a pilot."""
        cheapest: dict[str, Any] = {}
        for knob in KNOBS:
            cheapest |= knob.levels(self.work)[0]
        plan = self.reference.plan
        least = plan.replace(**{**cheapest, **_FEW_RAYS})
        saved = self.cost(plan) - self.cost(least)
        return saved > _PILOT_TRIALS * self.trial_cost(least)

    def decide(self) -> None:
        """Decide knob by knob, those first that others are computed with."""
        pilot = pilot_of(self.reference)
        if pilot.filled.pixels.size == 0:
            return
        self.work = dataclasses.replace(self.work, share=pilot.share, rough={})
        trial = Trial(pilot, self.base, self.stage)
        for knob in KNOBS:
            if knob is sampling.KNOB:
                trial = self._sample(trial)
            elif knob.measure is not None and len(knob.levels(self.work)) > 1:
                trial = self._decide(knob, trial)

    def _decide(self, knob: Knob, trial: Trial) -> Trial:
        """Choose a knob's level, and return the trial with it."""
        *levels, exact = knob.levels(self.work)
        dearest = self._least(exact)
        allowed = self.left if knob.share is None else knob.share * self.tolerance
        told: tuple[str, float | None] = ("", None)
        price = self._price(knob)
        for level in sorted(levels, key=self._least):
            if self._least(level) > dearest - price:
                break
            difference = knob.measure(trial, level, allowed)  # type: ignore[misc]
            words = knob.told(self.stage.plan.replace(**level), self.work)
            if difference <= allowed and knob.share is None:
                edge = trial.edge_difference(level)
                if edge > edge_allowance(allowed):
                    told = (f"{words}, at edges", edge)
                    continue
            if difference <= allowed:
                return self._choose(knob, level, difference, told, trial)
            told = (words, difference)
        self.found[knob.name] = (None if told[1] is None else 0.0, *told)
        return trial

    def _least(self, level: Setting) -> float:
        """Return what a level may cost when few samples will be taken. [ms]"""
        return self.cost(self.stage.plan.replace(**{**_FEW_RAYS, **level}))

    def _sample(self, trial: Trial) -> Trial:
        """Choose how many rays pixels have: the cheapest that suffices."""
        best: tuple[float, Setting, float] | None = None
        told: tuple[str, float | None] = ("", None)
        plan = self.stage.plan
        *levels, exact = sampling.KNOB.levels(self.work)
        most = self.cost(plan.replace(**exact))
        if most - self._least(levels[0]) < _SAMPLE_TRIALS * self.trial_cost(plan):
            return trial
        for level in levels:
            samples, enough = level["samples"], best[0] if best else most
            if not self._surveyed(samples):
                even = self.cost(plan.replace(samples=samples, refine=_NEVER))
                if even > enough - self.trial_cost(plan):
                    break
                self._survey(trial, samples)
            cost = self.cost(plan.replace(**level))
            if cost >= enough:
                continue
            difference = trial.sampling_difference(level)
            if difference <= self.left:
                best = (cost, level, difference)
            else:
                told = (
                    sampling.KNOB.told(plan.replace(**level), self.work),
                    difference,
                )
        if best is None:
            self.found[sampling.KNOB.name] = (0.0, *told)
            return trial
        return self._choose(sampling.KNOB, best[1], best[2], told, trial)

    def _choose(
        self,
        knob: Knob,
        level: Setting,
        difference: float,
        refused: tuple[str, float | None],
        trial: Trial,
    ) -> Trial:
        """Take a level, and return the trial with it."""
        alike = self.base is self.stage
        self.stage = self.stage.replanned(**level)
        if knob.share is not None:
            self.base = self.stage if alike else self.base.replanned(**level)
            self.spent[knob.group] = difference
            self.found[knob.name] = (difference, *refused)
            return Trial(trial.pilot, self.base, self.stage)
        alone = difference
        if trial.stage is not trial.base:
            before = trial.after(trial.base)
            alone = knob.measure(before, level, float("inf"))  # type: ignore[misc]
        self.found[knob.name] = (alone, *refused)
        return trial.after(self.stage)

    def _surveyed(self, samples: int) -> bool:
        """Return whether it is known how many pixels would be refined."""
        return (samples, sampling.CONTRASTS[0]) in self.work.rough

    def _survey(self, trial: Trial, samples: int) -> None:
        """Count which pixels would be refined that have so many samples."""
        rough = trial.rough(samples)
        rough = rough[rough < float("inf")]
        for contrast in sampling.CONTRASTS:
            share = float((rough > contrast).mean()) if rough.size else 0.0
            self.work.rough[samples, contrast] = share
        self.work.rough[samples, _NEVER] = 0.0

    def result(self) -> Stage:
        """Return the stage with its plan, and what was found in it."""
        plan = self.stage.plan
        findings = tuple(self._finding(knob, plan) for knob in KNOBS)
        return self.stage.replanned(tolerance=self.tolerance, findings=findings)

    def _finding(self, knob: Knob, plan: Plan) -> Finding:
        """Return what was found of one knob."""
        exact = plan.replace(**knob.levels(self.work)[-1])
        if knob.name == "basis":
            exact = plan.replace(basis="points")
        difference, refused, changed = self.found.get(knob.name, (None, "", None))
        beyond = knob.beyond(plan)
        return Finding(
            knob.name,
            knob.told(plan, self.work),
            beyond,
            difference if beyond else 0.0,
            max(self.cost(exact) - self.cost(plan), 0.0),
            refused,
            changed,
        )
