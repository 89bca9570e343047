"""What a session measures, in order: white, each site of the skin, white again."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from dataclasses import fields as fields_of
from functools import cached_property
from typing import Any, Self

import numpy as np

from skinviz._validate import in_range, one_of
from skinviz.errors import ArgumentError
from skinviz.instruments.arrangement import SAMPLE, STATES, WHITE, Arrangement
from skinviz.instruments.polarisation import Polarisers, state_weights

BEFORE, AFTER = "white before", "white after"
"""The sweeps over the white; the others are named after sites."""

_MOST = 20_000  # readings of a session


@dataclass(frozen=True)
class Step:
    """Repeated readings of one arrangement.

    Attributes
    ----------
    number : int
        Its place in the plan.
    sweep : str
        ``BEFORE``, a site, or ``AFTER``.
    arrangement : Arrangement
    """

    number: int
    sweep: str
    arrangement: Arrangement


@dataclass(frozen=True)
class Plan:
    """A session as it is meant to go.

    Attributes
    ----------
    subject : str
        A pseudonym, never a name.
    sites : tuple of str
        Body sites, all measured between the same two sweeps over the white.
    operator : str
        Whoever measures; "" if not told.
    illumination : tuple of float
        Angles of the lamp from the normal; negative ones, on the viewer's side, are
        free of specular light and tell the asymmetry of what leaves the body.
        [degrees]
    viewing : float
        Angle of the meter from the normal. [degrees]
    states : tuple of str
        Of the polarisers, keys of ``STATES``.
    repeats : int
        Readings of each arrangement, at least 2.
    ambient : bool
        Whether stray light is measured, with the lamp shuttered.
    warm_up : bool
        Whether the lamp must have settled before the first sweep.
    exposure, average, sync
        As for :meth:`Spectroradiometer.configure`.
    n, leakage : float
        As for :class:`Polarisers`.
    """

    subject: str = "subject"
    sites: tuple[str, ...] = ("skin",)
    operator: str = ""
    illumination: tuple[float, ...] = (45.0,)
    viewing: float = 0.0
    states: tuple[str, ...] = ("open",)
    repeats: int = 5
    ambient: bool = True
    warm_up: bool = True
    exposure: float = 0.0
    average: int = 1
    sync: bool = False
    n: float = 1.4
    leakage: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what cannot be measured, or says nothing."""
        for name in ("sites", "illumination", "states"):
            _require_distinct(getattr(self, name), name)
        for site in self.sites:
            if not site.strip() or site in (BEFORE, AFTER):
                raise ArgumentError(f"a site cannot be called {site!r}; name it else")
        for state in self.states:
            one_of(state, STATES, "state of the polarisers")
        for angle in self.illumination:
            Arrangement(illumination=angle, viewing=self.viewing)
        in_range(self.repeats, 2, 1000, "repeats")
        in_range(self.exposure, 0.0, 60.0, "exposure", "s")
        in_range(self.average, 1, 99, "average")
        given = Polarisers(self.n, self.leakage)
        for angle in self.illumination if len(self.states) > 1 else ():
            angles = (np.deg2rad(angle), np.deg2rad(self.viewing))
            state_weights(self.states, angles, given)
        if len(self.steps) * self.repeats > _MOST:
            raise ArgumentError(
                f"{len(self.steps) * self.repeats:,} readings are too many for a "
                f"session; plan at most {_MOST:,}, or several sessions"
            )

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        """All steps in order.

        A polariser is turned by hand, so a state is kept while the lamp goes through
        its angles, up and down by turns.
        """
        sweeps = [
            (BEFORE, WHITE, self.ambient),
            *((site, SAMPLE, self.ambient) for site in self.sites),
            (AFTER, WHITE, False),
        ]
        arranged = [
            (sweep, arrangement)
            for sweep, target, ambient in sweeps
            for arrangement in self._sweep(target, ambient)
        ]
        return tuple(Step(i, *what) for i, what in enumerate(arranged))

    @property
    def polarisers(self) -> Polarisers:
        """What is assumed of skin and polarisers."""
        return Polarisers(self.n, self.leakage)

    def to_json(self) -> dict[str, Any]:
        """Return it as a session's log keeps it."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Self:
        """Return what :meth:`to_json` kept.

        Raises
        ------
        ArgumentError
            If a later version kept it, with fields that are not known here.
        """
        unknown = sorted(set(data) - {field.name for field in fields_of(cls)})
        if unknown:
            raise ArgumentError(
                f"the plan says {', '.join(unknown)}, which a later version of skinviz "
                "knows; use that one"
            )
        fields: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value
            for key, value in data.items()
        }
        return cls(**fields)

    def _sweep(self, target: str, ambient: bool) -> Iterable[Arrangement]:
        """Yield the arrangements of a sweep."""
        angles = list(self.illumination)
        for state in self.states:
            if ambient:
                yield Arrangement(target, False, angles[0], self.viewing, state)
            for angle in angles:
                yield Arrangement(target, True, angle, self.viewing, state)
            angles.reverse()


def _require_distinct(values: tuple[Any, ...], name: str) -> None:
    """Refuse a list that is empty or says a thing twice."""
    if not values or len(set(values)) < len(values):
        raise ArgumentError(f"{name} must be a list, each once; got {list(values)}")
