"""A state as the query of a link, and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from urllib.parse import parse_qsl, urlencode

from skinviz.errors import ArgumentError
from skinviz.view.viewer.state import Look, Mark, ViewState

LONGEST = 4000
"""Characters that a query may have."""

_LISTS = {"looks": "hand", "points": "point"}


def to_query(state: ViewState, initial: ViewState) -> str:
    """Return what differs from the initial state, as a link's query."""
    pairs: list[tuple[str, str]] = []
    for name, (write, _) in _CODECS.items():
        value = getattr(state, name)
        if value == getattr(initial, name):
            continue
        if name in _LISTS:
            pairs += [(_LISTS[name], write(one)) for one in value] or [
                (_LISTS[name], "")
            ]
        else:
            pairs.append((name, write(value)))
    return urlencode(pairs)


def from_query(query: str, initial: ViewState) -> ViewState:
    """Return the state that a link describes.

    Raises
    ------
    ArgumentError
        If a key is unknown or a value impossible.
    """
    if len(query) > LONGEST:
        raise ArgumentError(f"the link is longer than {LONGEST} characters")
    keys = {_LISTS.get(name, name): name for name in _CODECS}
    said: dict[str, Any] = {}
    for key, text in parse_qsl(query, keep_blank_values=True):
        if key not in keys:
            raise ArgumentError(f"the link says {key!r}, which the viewer has not")
        name = keys[key]
        try:
            value = _CODECS[name][1](text)
        except (ValueError, IndexError) as error:
            raise ArgumentError(f"the link's {key} is not readable: {text!r}") from (
                error
            )
        if name not in _LISTS:
            said[name] = value
        elif text or name == "looks":
            said[name] = (*said.get(name, ()), value)
        else:
            said.setdefault(name, ())
    return initial.replace(**said)


def _numbers_text(values: tuple[float, ...]) -> str:
    """Return numbers with commas between them."""
    return ",".join(repr(value) for value in values)


def _numbers_of(text: str) -> tuple[float, ...]:
    """Return numbers from between commas."""
    return tuple(float(part) for part in text.split(",") if part)


def _look_text(look: Look) -> str:
    """Return a hand as "person|site|weights"."""
    return f"{look.person}|{look.site}|{_numbers_text(look.weights)}"


def _look_of(text: str) -> Look:
    """Return the hand of such a text."""
    person, site, weights = text.split("|")
    return Look(person, site, _numbers_of(weights))


def _mark_text(mark: Mark) -> str:
    """Return a point as "hand,x,y,z"."""
    return f"{mark.look},{_numbers_text(mark.place)}"


def _mark_of(text: str) -> Mark | None:
    """Return the point of such a text."""
    if not text:
        return None
    look, place = text.split(",", 1)
    return Mark(int(look), _numbers_of(place))


def _flag_of(text: str) -> bool:
    """Return whether a switch is on."""
    if text not in ("0", "1"):
        raise ValueError(text)
    return text == "1"


_NUMBER: tuple[Callable[[Any], str], Callable[[str], Any]] = (repr, float)
_NUMBERS: tuple[Callable[[Any], str], Callable[[str], Any]] = (
    _numbers_text,
    _numbers_of,
)
_TEXT: tuple[Callable[[Any], str], Callable[[str], Any]] = (str, str)

_CODECS: dict[str, tuple[Callable[[Any], str], Callable[[str], Any]]] = {
    "looks": (_look_text, _look_of),
    "active": (str, int),
    "difference": (lambda on: str(int(on)), _flag_of),
    "illuminant": _TEXT,
    "light": _NUMBERS,
    "view": _NUMBERS,
    "zoom": _NUMBER,
    "shift": _NUMBERS,
    "surface": _TEXT,
    "width": _NUMBER,
    "index": _TEXT,
    "specular_scale": _NUMBER,
    "exposure": _NUMBER,
    "white": _TEXT,
    "tolerance": _NUMBER,
    "points": (_mark_text, _mark_of),
}
