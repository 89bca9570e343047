"""Whether lights are tested for what stands between."""

from __future__ import annotations

from skinviz.rendering.knobs.knob import Knob
from skinviz.rendering.plan import Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work

_FACING = 0.8  # share of points that face a light


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of rays to the lights."""
    if not plan.shadows:
        return 0.0
    at = work.vertices if plan.shading == "vertices" else work.points(plan)
    return at * work.lights * _FACING * rates.shadow


KNOB = Knob(
    "shadows",
    lambda _: [{"shadows": False}, {"shadows": True}],
    _cost,
    lambda plan, _: "cast" if plan.shadows else "none",
    lambda plan: "" if plan.shadows else "cast shadows",
    lambda trial, setting, allowed: trial.difference(setting, allowed),
)
