"""Numbers in which mapped skin's tints are kept: single or double precision."""

from __future__ import annotations

from collections.abc import Sequence

from skinviz.rendering.knobs.knob import Knob, Setting
from skinviz.rendering.knobs.spectrum import body_price
from skinviz.rendering.plan import ARITHMETICS, Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work

_WIDER = 0.1  # share of a table's time that numbers twice as wide cost


def _levels(work: Work) -> Sequence[Setting]:
    """Return both where tints are kept, else the exact one alone."""
    return [{"arithmetic": name} for name in ARITHMETICS[0 if work.mapped else 1 :]]


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time that double precision costs more where tints are kept."""
    kept = work.mapped and plan.reflectance != "model" and plan.shading == "points"
    if not kept or plan.arithmetic == "single":
        return 0.0
    return _WIDER * work.points(plan) * work.channels * rates.look


KNOB = Knob(
    "arithmetic",
    _levels,
    _cost,
    lambda plan, _: f"{plan.arithmetic} precision",
    lambda plan: "" if plan.arithmetic == "double" else "29 bits of each tint",
    lambda trial, setting, _: trial.body_difference(setting),
    share=0.3,
    group="body",
    price=body_price,
)
