"""How many rays a pixel has, and which pixels have all sixteen."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

from skinviz.rendering.knobs.knob import Knob, Setting
from skinviz.rendering.plan import MOST_SAMPLES, Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work

FEW = (1, 2, 4)
"""Samples of pixels that are not refined."""

CONTRASTS = (64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0)
"""To a neighbour, above which a pixel is refined."""


_LEVELS: Sequence[Setting] = (
    *(
        {"samples": samples, "refine": contrast}
        for samples, contrast in product(FEW, CONTRASTS)
    ),
    {"samples": MOST_SAMPLES, "refine": None},
)


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of rays from the eye."""
    return work.rays(plan) * rates.ray


def _told(plan: Plan, _: Work) -> str:
    """Return the level in words."""
    if plan.refine is None or plan.samples == MOST_SAMPLES:
        return f"{plan.samples} rays a pixel"
    return f"{plan.samples}, 16 at contrasts over {plan.refine:g}"


def _beyond(plan: Plan) -> str:
    """Return what sixteen samples have beyond it."""
    if plan.samples == MOST_SAMPLES:
        return ""
    return "rays of even pixels" if plan.refine is not None else "16 rays a pixel"


KNOB = Knob(
    "sampling",
    lambda _: _LEVELS,
    _cost,
    _told,
    _beyond,
    lambda trial, setting, _: trial.sampling_difference(setting),
)
