"""The ways to compute a scene's picture that are worth comparing with each other."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from skinviz.rendering.geometry import Geometry
from skinviz.rendering.knobs import KNOBS, sampling
from skinviz.rendering.plan import MOST_SAMPLES, SAMPLES, Plan
from skinviz.rendering.planner import plan as planned
from skinviz.rendering.stage import stage_of
from skinviz.rendering.work import Work, work_of
from skinviz.scene.scene import Scene

TOLERANCES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""What is planned for. [ΔE00]"""

PLAIN = Plan(samples=1, spectrum="scene", basis="points")
"""The plain way: a spectrum at the middle of each pixel, on the scene's bands."""

REFERENCE, ONE_KNOB, UNIFORM, PLAIN_WAY, TOLERANCE, GRID = GROUPS = (
    "reference",
    "one knob",
    "uniform",
    "plain",
    "tolerance",
    "grid",
)
"""Why a way is looked at."""

_GRID_CONTRASTS = (None, 64.0, 16.0, 4.0, 2.0, 1.0)
_GRID_TOLERANCES = (0.2, 1.0, 5.0)


@dataclass(frozen=True)
class Way:
    """One way to compute a picture, before it is tried.

    Attributes
    ----------
    group : str
        One of ``GROUPS``.
    name : str
        What of it is told apart within the group.
    plan : Plan
        The way itself.
    tolerance : float or None
        What it was planned for. [ΔE00]
    planning : float
        What planning it took. [ms]
    """

    group: str
    name: str
    plan: Plan
    tolerance: float | None = None
    planning: float = 0.0

    @property
    def setting(self) -> Plan:
        """The plan without what it was made for: equal for equal pictures."""
        return self.plan.replace(tolerance=None, findings=())


def ways(
    scene: Scene,
    tolerances: Sequence[float] = TOLERANCES,
    *,
    geometry: Geometry | None = None,
) -> list[Way]:
    """Return the ways that a scene's trade of speed for accuracy is swept by.

    The reference; each knob's cheaper levels, all else exact; fewer samples for all
    pixels alike; the plain way; plans for tolerances; and combinations of samples and
    refinement with what some of these plans chose besides. Of ways that give the same
    picture only the first is there, but for plans, which are all there.

    Parameters
    ----------
    scene : Scene
        What is to be shown.
    tolerances : sequence of float
        To plan for. [ΔE00]
    geometry : Geometry, optional
        Of the scene's mesh, where it is at hand.
    """
    stage = stage_of(scene, Plan(), geometry)
    work = work_of(stage)
    made = list(_planned(scene, tolerances, stage.geometry))
    return _distinct(
        [
            Way(REFERENCE, "everything", Plan()),
            Way(PLAIN_WAY, "spectra at each point, one ray a pixel", PLAIN),
            *_uniform(),
            *_one_knob(work),
            *made,
            *_grid(made, work),
        ]
    )


def _planned(
    scene: Scene, tolerances: Sequence[float], geometry: Geometry
) -> Iterator[Way]:
    """Yield the plans for tolerances, with the time each took."""
    planned(scene, 1.0, geometry=geometry)  # or the first would pay for all
    for tolerance in tolerances:
        begun = time.perf_counter()
        plan = planned(scene, tolerance, geometry=geometry)
        took = 1e3 * (time.perf_counter() - begun)
        yield Way(TOLERANCE, f"ΔE00 {tolerance:g}", plan, tolerance, took)


def _uniform() -> Iterator[Way]:
    """Yield fewer samples, as many for each pixel."""
    for samples in SAMPLES[:-1]:
        rays = "1 ray" if samples == 1 else f"{samples} rays"
        yield Way(UNIFORM, f"{rays} a pixel", Plan(samples=samples))


def _one_knob(work: Work) -> Iterator[Way]:
    """Yield each knob's levels below the exact one, all else exact."""
    for knob in KNOBS:
        for level in knob.levels(work)[:-1]:
            plan = Plan(**level)
            yield Way(ONE_KNOB, f"{knob.name}: {knob.told(plan, work)}", plan)


def _grid(made: Iterable[Way], work: Work) -> Iterator[Way]:
    """Yield samples × contrasts, with what plans chose besides."""
    chosen = [way.plan for way in made if way.tolerance in _GRID_TOLERANCES]
    for plan in chosen:
        for samples, contrast in itertools.product(sampling.FEW, _GRID_CONTRASTS):
            finer = plan.replace(samples=samples, refine=contrast, tolerance=None)
            yield Way(GRID, sampling.KNOB.told(finer, work), finer.replace(findings=()))
        most = plan.replace(samples=MOST_SAMPLES, refine=None, tolerance=None)
        yield Way(GRID, sampling.KNOB.told(most, work), most.replace(findings=()))


def _distinct(found: Iterable[Way]) -> list[Way]:
    """Return ways without those that repeat another one; plans stay."""
    known: set[Plan] = set()
    kept = []
    for way in found:
        if way.setting in known and way.group != TOLERANCE:
            continue
        known.add(way.setting)
        kept.append(way)
    return kept
