"""What is kept of the surface's reflection: nothing, one index, or its dispersion."""

from __future__ import annotations

from collections.abc import Sequence

from skinviz.rendering.knobs.knob import Knob, Setting
from skinviz.rendering.plan import Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work

_INDICES = 3  # at which a dispersion is computed, about


def _disperses(work: Work) -> bool:
    """Return whether the surface's index depends on wavelength."""
    return not isinstance(work.stage.scene.surface.n, float | int)


def _levels(work: Work) -> Sequence[Setting]:
    """Return all levels that differ."""
    names = ["none", "constant", "dispersion"]
    if not _disperses(work):
        names.remove("constant")  # which is all there is
    return [{"specular": name} for name in names]


def _cost(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of lobes and of Fresnel's law."""
    at = work.vertices if plan.shading == "vertices" else work.points(plan)
    if plan.specular == "none":
        return at * work.lights * rates.point / 2  # the cosines alone
    indices = _INDICES if plan.specular == "dispersion" and _disperses(work) else 1
    return at * work.lights * (rates.point + indices * rates.index)


_WORDS = {
    "none": "none",
    "constant": "one refractive index",
    "dispersion": "as the scene has it",
}
_BEYOND = {
    "none": "the surface's reflection",
    "constant": "its dispersion",
    "dispersion": "",
}

KNOB = Knob(
    "specular",
    _levels,
    _cost,
    lambda plan, _: _WORDS[plan.specular],
    lambda plan: _BEYOND[plan.specular],
    lambda trial, setting, allowed: trial.difference(setting, allowed),
)
