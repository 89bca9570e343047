"""Where mapped skin's reflectance comes from: vertices, a table, or the model."""

from __future__ import annotations

from collections.abc import Sequence

from skinviz.rendering.knobs.knob import Knob, Setting
from skinviz.rendering.knobs.spectrum import body_price, nodes
from skinviz.rendering.plan import REFLECTANCES, Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import TABLE_ENTRIES, Work


def _levels(work: Work) -> Sequence[Setting]:
    """Return all levels of mapped skin; others have one reflectance, the model's."""
    names = REFLECTANCES if work.mapped else REFLECTANCES[-1:]
    return [{"reflectance": name} for name in names]


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of the model, and of what is interpolated."""
    if not work.mapped or plan.basis == "points":
        return 0.0
    n, channels, points = nodes(plan, work), work.channels, work.points(plan)
    model = n * rates.band + n * channels * rates.mix
    if plan.reflectance == "vertices" or plan.shading == "vertices":
        own = 0.0 if plan.shading == "vertices" else points * channels * rates.blend
        return work.vertices * model + own
    if plan.reflectance == "table":
        return TABLE_ENTRIES * model + points * channels * rates.look
    return points * model


_WORDS = {"vertices": "from vertices", "table": "from a table", "model": "the model"}

KNOB = Knob(
    "reflectance",
    _levels,
    _cost,
    lambda plan, work: _WORDS[plan.reflectance] if work.mapped else "the model, once",
    lambda plan: "" if plan.reflectance == "model" else "the model at each point",
    lambda trial, setting, _: trial.body_difference(setting),
    share=0.25,
    group="body",
    price=body_price,
)
