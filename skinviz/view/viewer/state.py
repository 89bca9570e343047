"""What is shown, as data: it goes into links, scene files and the list of undos."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

from skinviz._validate import in_range, one_of
from skinviz.errors import ArgumentError
from skinviz.rendering.planner import LOOSEST, TIGHTEST
from skinviz.spectra.adaptation import ADAPTATIONS
from skinviz.surface.models import surface_models

MOST_LOOKS = (1, 2, 4)
"""How many hands may be shown."""

MOST_POINTS = 2
"""How many points may be marked."""

_MOST_TEXT = 200
_WIDEST = 1e4  # mm, of what is shifted and where points are
_LISTS = (("light", 2, 180.0), ("view", 3, 180.0), ("shift", 2, _WIDEST))
_NUMBERS = (
    ("zoom", 0.05, 100.0),
    ("width", 0.0, 1e9),
    ("specular_scale", 0.0, 1e6),
    ("exposure", 1e-3, 1e3),
    ("tolerance", TIGHTEST, LOOSEST),
)


@dataclass(frozen=True)
class Look:
    """One hand that is shown: whose skin it has.

    Attributes
    ----------
    person : str
        As the archive has them, "China/186"; "" for the scene's own skin.
    site : str
        Of the body; "" for the scene's own skin.
    weights : tuple of float
        The model's parameters; empty for those of the fit.
    """

    person: str = ""
    site: str = ""
    weights: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what is no name and no number."""
        for text in (self.person, self.site):
            _require_text(text)
        weights = _numbers(self.weights, -1e12, 1e12, "weight")
        object.__setattr__(self, "weights", weights)


@dataclass(frozen=True)
class Mark:
    """A point that is marked on one of the hands.

    Attributes
    ----------
    look : int
        Which hand.
    place : (float, float, float)
        On the mesh. [mm]
    """

    look: int
    place: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse what is no place."""
        _require_whole(self.look, 0, max(MOST_LOOKS) - 1, "the hand of a point")
        place = _numbers(self.place, -_WIDEST, _WIDEST, "a point's coordinate")
        object.__setattr__(self, "place", _of_length(place, 3, "a point"))


@dataclass(frozen=True)
class ViewState:
    """Everything that the viewer's controls set.

    Attributes
    ----------
    looks : tuple of Look
        The hands that are shown, 1, 2 or 4.
    active : int
        The one whose skin the controls set.
    difference : bool
        Whether a map of ΔE00 between the first two is shown beside them.
    illuminant : str
        Of the first light; "" for the scene's own.
    light : (float, float)
        Angle and tilt of the first light from the back's normal. [°]
    view : (float, float, float)
        Angle, tilt and roll of the viewer. [°]
    zoom : float
        1 shows what the scene's camera shows. [1]
    shift : (float, float)
        Of the picture's middle to the right and up. [mm]
    surface : str
        A surface model.
    width : float
        Its lobe's: γ [rad], slope or exponent.
    index : str
        Its refractive index, as a number or a tissue's name.
    specular_scale : float
        Share of the physical weight β₁. [1]
    exposure : float
        [1]
    white : {"none", "cat16"}
        Whether eyes adapt to the first light.
    tolerance : float
        That the still picture keeps. [ΔE00]
    points : tuple of Mark
        At most two.
    """

    looks: tuple[Look, ...] = field(default_factory=lambda: (Look(),))
    active: int = 0
    difference: bool = False
    illuminant: str = ""
    light: tuple[float, ...] = (0.0, 0.0)
    view: tuple[float, ...] = (0.0, 0.0, 0.0)
    zoom: float = 1.0
    shift: tuple[float, ...] = (0.0, 0.0)
    surface: str = "torrance-sparrow"
    width: float = 0.27
    index: str = "1.4"
    specular_scale: float = 1.0
    exposure: float = 1.0
    white: str = "none"
    tolerance: float = 1.0
    points: tuple[Mark, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what cannot be shown; links are written by anybody."""
        _require_hands(len(self.looks))
        _require_whole(self.active, 0, len(self.looks) - 1, "the chosen hand")
        if not isinstance(self.difference, bool):
            raise ArgumentError(f"difference must be true or false: {self.difference}")
        for text in (self.illuminant, self.index):
            _require_text(text)
        for name, n, most in _LISTS:
            numbers = _numbers(getattr(self, name), -most, most, name)
            object.__setattr__(self, name, _of_length(numbers, n, name))
        one_of(self.surface, surface_models(), "surface")
        one_of(self.white, ADAPTATIONS, "white")
        for name, low, high in _NUMBERS:
            number = in_range(getattr(self, name), low, high, name.replace("_", " "))
            object.__setattr__(self, name, number)
        if len(self.points) > MOST_POINTS:
            raise ArgumentError(f"at most {MOST_POINTS} points can be marked")
        if any(mark.look >= len(self.looks) for mark in self.points):
            raise ArgumentError("a point is marked on a hand that is not shown")

    @property
    def look(self) -> Look:
        """The hand whose skin the controls set."""
        return self.looks[self.active]

    def replace(self, **changes: Any) -> ViewState:
        """Return the state with some attributes changed."""
        return dataclasses.replace(self, **changes)

    def with_look(self, **changes: Any) -> ViewState:
        """Return the state with the active hand changed."""
        looks = list(self.looks)
        looks[self.active] = dataclasses.replace(self.look, **changes)
        return self.replace(looks=tuple(looks))

    def with_hands(self, n: int) -> ViewState:
        """Return the state with n hands, further ones as the last."""
        _require_hands(n)
        looks = (self.looks + (self.looks[-1],) * n)[:n]
        return self.replace(
            looks=looks,
            active=min(self.active, n - 1),
            difference=self.difference and n == 2,
            points=tuple(mark for mark in self.points if mark.look < n),
        )

    def marking(self, mark: Mark, second: bool) -> ViewState:
        """Return the state with a point marked, as the first or as the second."""
        kept = self.points[:1] if second else ()
        return self.replace(points=(*kept, mark))


def _numbers(given: Any, low: float, high: float, name: str) -> tuple[float, ...]:
    """Return numbers within a range."""
    if not isinstance(given, list | tuple):
        raise ArgumentError(f"{name} must be a list of numbers; got {given!r}")
    return tuple(in_range(number, low, high, name) for number in given)


def _of_length(given: tuple[float, ...], n: int, name: str) -> tuple[float, ...]:
    """Return numbers if there are n of them."""
    if len(given) != n:
        raise ArgumentError(f"{name} must be {n} numbers; got {len(given)}")
    return given


def _require_hands(n: Any) -> None:
    """Refuse numbers of hands that have no place in a picture."""
    if isinstance(n, bool) or not isinstance(n, int) or n not in MOST_LOOKS:
        raise ArgumentError(f"1, 2 or 4 hands can be shown; got {n!r}")


def _require_text(given: Any) -> None:
    """Refuse what is no short text."""
    if not isinstance(given, str) or len(given) > _MOST_TEXT:
        raise ArgumentError(f"a name must be a text; got {str(given)[:40]!r}")


def _require_whole(given: Any, low: int, high: int, name: str) -> None:
    """Refuse what is no whole number within a range."""
    if not isinstance(given, int) or not low <= given <= high:
        raise ArgumentError(f"{name} must be {low} to {high}; got {given!r}")
