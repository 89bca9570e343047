"""Where light is computed: at vertices, and interpolated, or at every point seen."""

from __future__ import annotations

from skinviz.rendering.knobs.knob import Knob
from skinviz.rendering.plan import Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of interpolating colours; other knobs tell what light costs."""
    if plan.shading == "points":
        return 0.0
    return work.points(plan) * 3 * rates.blend


KNOB = Knob(
    "shading",
    lambda _: [{"shading": "vertices"}, {"shading": "points"}],
    _cost,
    lambda plan, _: f"at {plan.shading}",
    lambda plan: "" if plan.shading == "points" else "light between vertices",
    lambda trial, setting: trial.difference(setting),
)
