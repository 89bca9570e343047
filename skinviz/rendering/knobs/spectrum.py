"""Where colours are summed over wavelengths: few nodes, bands, or every nanometre."""

from __future__ import annotations

from collections.abc import Sequence

from skinviz.rendering.knobs.knob import Knob, Setting
from skinviz.rendering.plan import SPECTRA, Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work

NANOMETRES = 401
"""Nodes of the finest level, where all data reach so far."""

_TRIED = 1400  # points of a pilot, about
_RULE_TIME = 8e6  # ns: choosing nodes, or where a table has its own


_WORDS = {"1 nm": "every nm", "scene": "the scene's bands"}


def _levels(work: Work) -> Sequence[Setting]:
    """Return all levels of mapped skin; others' are summed once."""
    return [{"spectrum": name} for name in (SPECTRA if work.mapped else SPECTRA[-1:])]


def nodes(plan: Plan, work: Work) -> int:
    """Return at how many wavelengths a plan needs the skin's reflectance."""
    if plan.spectrum == "scene":
        return work.stage.scene.wavelengths.size
    if plan.spectrum == "1 nm":
        return NANOMETRES
    return int(plan.spectrum.split()[0])


def body_price(plan: Plan, work: Work, rates: Rates) -> float:
    """Return the time of finding out about another reflectance, or its sum."""
    return _RULE_TIME + _TRIED * nodes(plan, work) * rates.band


def _told(plan: Plan, _: Work) -> str:
    """Return the level in words."""
    if plan.spectrum in _WORDS:
        return _WORDS[plan.spectrum]
    return plan.spectrum if "nodes" in plan.spectrum else f"{plan.spectrum} bands"


def _beyond(plan: Plan) -> str:
    """Return what every nanometre has beyond it."""
    return "" if plan.spectrum == "1 nm" else "the wavelengths between"


KNOB = Knob(
    "spectrum",
    _levels,
    lambda *_: 0.0,  # what needs the nodes tells what they cost
    _told,
    _beyond,
    lambda trial, setting, _: trial.body_difference(setting),
    share=0.15,
    group="body",
    price=body_price,
)
