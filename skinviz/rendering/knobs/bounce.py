"""How finely light between parts of the mesh is gathered, if the scene declares it."""

from __future__ import annotations

from collections.abc import Sequence

from skinviz.rendering.knobs.knob import Knob, Setting
from skinviz.rendering.knobs.spectrum import nodes
from skinviz.rendering.plan import Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.tolerance import FEW
from skinviz.rendering.work import Work

RAYS = (0, 16, 64, 256)
"""Directions a vertex looks in; the last is the reference's."""

_TRIAL_RAYS = 64  # by which fewer are judged: more would cost as much as the picture
_TRIED = 3300  # vertices at most, that a pilot's points lie between
_GATHERED = 0.3  # share of a ray's time that each further number takes it to fetch


def _levels(work: Work) -> Sequence[Setting]:
    """Return all levels where the scene declares light between its parts."""
    return [{"bounce_rays": n} for n in (RAYS if work.bounces else RAYS[-1:])]


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of these rays, and of the skin that they meet."""
    if not work.bounces or plan.bounce_rays == 0:
        return 0.0
    numbers = nodes(plan, work) if work.mapped else work.lights
    each = rates.bounce * (1 + _GATHERED * (numbers - 1) / 4)
    everywhere = len(work.stage.geometry.points)
    model = everywhere * numbers * rates.band if work.mapped else 0.0
    lit = everywhere * work.lights * (rates.shadow + rates.point)
    return work.vertices * plan.bounce_rays * each + model + lit


def trial_rays(n_filled: float) -> int:
    """Return the directions by which fewer are judged, for so many filled pixels.

    Of few pixels the largest difference counts, of which 64 directions tell nothing.
    """
    return _TRIAL_RAYS if n_filled >= FEW else RAYS[-1]


def _price(_: Plan, work: Work, rates: Rates) -> float:
    """Return the time of finding out."""
    rays = trial_rays(work.pixels * work.share)
    return min(work.vertices, _TRIED) * rays * rates.bounce


def _told(plan: Plan, work: Work) -> str:
    """Return the level in words."""
    if not work.bounces:
        return "none declared"
    return f"{plan.bounce_rays} rays a vertex" if plan.bounce_rays else "none"


def _beyond(plan: Plan) -> str:
    """Return what the reference has beyond it."""
    if plan.bounce_rays == 0:
        return "light between parts"
    return "" if plan.bounce_rays >= RAYS[-1] else "finer gathering"


KNOB = Knob(
    "bounce",
    _levels,
    _cost,
    _told,
    _beyond,
    lambda trial, setting, _: trial.bounce_difference(setting),
    share=0.4,
    group="bounce",
    price=_price,
)
