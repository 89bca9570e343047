"""Where light is computed: at vertices, and interpolated, or at every point seen."""

from __future__ import annotations

from skinviz.rendering.knobs.knob import Knob
from skinviz.rendering.plan import Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work

_RARE = 5.0  # trials, one of which suffices


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of interpolating colours; other knobs tell what light costs."""
    if plan.shading == "points":
        return 0.0
    return work.points(plan) * 3 * rates.blend


def _price(_: Plan, work: Work, rates: Rates) -> float:
    """Return the time of light at all vertices, some times over: it rarely does."""
    each = work.lights * (rates.shadow + rates.point + rates.index)
    return _RARE * len(work.stage.geometry.points) * each


KNOB = Knob(
    "shading",
    lambda _: [{"shading": "vertices"}, {"shading": "points"}],
    _cost,
    lambda plan, _: f"at {plan.shading}",
    lambda plan: "" if plan.shading == "points" else "light between vertices",
    lambda trial, setting, allowed: trial.difference(setting, allowed),
    price=_price,
)
