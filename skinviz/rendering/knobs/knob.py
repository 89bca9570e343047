"""What every knob of the plan is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from skinviz.rendering.plan import Plan
from skinviz.rendering.rates import Rates
from skinviz.rendering.work import Work

if TYPE_CHECKING:
    from skinviz.rendering.trial import Trial

Setting = Mapping[str, Any]
"""Attributes of a plan, and the values that one level gives them."""

MS = 1e-6
"""Of a nanosecond. [ms]"""


@dataclass(frozen=True)
class Knob:
    """One choice that trades speed for accuracy.

    Attributes
    ----------
    name : str
        What people call it.
    levels : callable
        From the work to its settings, from cheap to exact; the last alone where there
        is no choice.
    cost : callable
        From a plan, the work and the rates to the time that this knob's part of the
        picture takes on one processor. [ns]
    told : callable
        From a plan and the work to the plan's level in words.
    beyond : callable
        From a plan to what the reference has beyond it, empty if nothing.
    measure : callable or None
        From a trial, a setting and what is allowed to a bound on what the setting
        changes, or to less that is not allowed either [ΔE00]; None if all levels give
        the same colours but for rounding.
    share : float or None
        Of the tolerance, that it may use up together with the others of its group;
        None if it is judged together with all decided before it. [1]
    group : str
        Of knobs whose differences are told together, each with those before it.
    price : callable or None
        From a plan, the work and the rates to the time that it takes one processor
        to find out about a level [ns]; None if all rays of a pilot are looked at.
    """

    name: str
    levels: Callable[[Work], Sequence[Setting]]
    cost: Callable[[Plan, Work, Rates], float]
    told: Callable[[Plan, Work], str]
    beyond: Callable[[Plan], str]
    measure: Callable[[Trial, Setting, float], float] | None
    share: float | None = None
    group: str = ""
    price: Callable[[Plan, Work, Rates], float] | None = None
