"""Whether the points of uniform skin share a few spectra, or each has its own."""

from __future__ import annotations

from skinviz.rendering.knobs.knob import Knob
from skinviz.rendering.knobs.spectrum import nodes
from skinviz.rendering.plan import Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of spectra at every point."""
    if plan.basis == "shared":
        return 0.0
    products = nodes(plan, work) * (2 + 2 * work.lights)
    return work.points(plan) * (nodes(plan, work) * rates.band + products * rates.mix)


KNOB = Knob(
    "basis",
    lambda _: [{"basis": "shared"}],
    _cost,
    lambda plan, _: (
        "spectra shared" if plan.basis == "shared" else "spectra at each point"
    ),
    lambda _: "",
    None,
)
