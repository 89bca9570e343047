"""Plans as TOML files that a person can write."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from skinviz._files import existing_file
from skinviz._validate import one_of
from skinviz.errors import ArgumentError, DataError
from skinviz.instruments.plan import Plan

_TEXT, _NUMBER, _COUNT, _FLAG = "text", "a number", "a whole number", "true or false"
_TEXTS, _ANGLES = "a list of texts", "a list of degrees, or {from, to, step}"
_KINDS: dict[str, tuple[type, ...]] = {
    _TEXT: (str,),
    _NUMBER: (int, float),
    _COUNT: (int,),
    _FLAG: (bool,),
    _TEXTS: (list,),
    _ANGLES: (list, dict),
}
_TABLES = {
    "session": {"subject": _TEXT, "sites": _TEXTS, "operator": _TEXT, "white": _TEXT},
    "geometry": {"illumination": _ANGLES, "viewing": _NUMBER, "states": _TEXTS},
    "readings": {
        "repeats": _COUNT,
        "ambient": _FLAG,
        "warm_up": _FLAG,
        "exposure": _NUMBER,
        "average": _COUNT,
        "sync": _FLAG,
    },
    "skin": {"n": _NUMBER, "leakage": _NUMBER},
}
_MOST_ANGLES = 1000


def read_plan(path: str | os.PathLike[str]) -> tuple[Plan, Path | None]:
    """Read a plan from a TOML file.

    Parameters
    ----------
    path : path-like
        With any of the tables ``[session]``, ``[geometry]``, ``[readings]`` and
        ``[skin]``, whose keys are the fields of :class:`Plan`; angles in degrees.

    Returns
    -------
    plan : Plan
    white : Path or None
        The certificate that ``white`` of ``[session]`` names, relative to the file.

    Raises
    ------
    DataError
        If the file is missing, not TOML, or a table or key is unknown or wrong; the
        message names it.
    """
    file = existing_file(path, DataError)
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"{file}: not a TOML file: {error}") from error
    try:
        fields = dict(_fields(content))
        white = fields.pop("white", None)
        return Plan(**fields), None if white is None else file.parent / white
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error


def _fields(content: dict[str, Any]) -> list[tuple[str, Any]]:
    """Return names and values of all that a file says."""
    found = []
    for name, table in content.items():
        known = _TABLES[one_of(name, _TABLES, "table")]
        if not isinstance(table, dict):
            raise ArgumentError(f"write {name} as a table, [{name}]")
        for key, value in table.items():
            kind = known[one_of(key, known, f"key in [{name}]")]
            found.append((key, _value(value, kind, f"{key} in [{name}]")))
    return found


def _value(value: Any, kind: str, where: str) -> Any:
    """Return a value of a kind, lists as tuples, or say what is expected."""
    right = isinstance(value, _KINDS[kind]) and isinstance(value, bool) == (
        kind == _FLAG
    )
    told = value
    if right and kind == _TEXTS:
        right = all(isinstance(item, str) for item in value)
        told = tuple(value)
    if right and kind == _ANGLES:
        told, right = _angles(value)
    if not right:
        raise ArgumentError(f"{where} must be {kind}; got {value!r}")
    return told


def _angles(value: Any) -> tuple[tuple[float, ...], bool]:
    """Return angles that are listed or ranged over, and whether they are such."""
    if isinstance(value, dict):
        if set(value) != {"from", "to", "step"}:
            return (), False
        first, last, step = (value[key] for key in ("from", "to", "step"))
        if not all(_is_number(x) for x in (first, last, step)) or step <= 0:
            return (), False
        count = (last - first) / step + 1
        if not 1 <= count <= _MOST_ANGLES:
            return (), False
        value = (first + step * np.arange(int(count + 1e-9))).tolist()
    return tuple(map(float, value)) if all(map(_is_number, value)) else (), all(
        map(_is_number, value)
    )


def _is_number(value: Any) -> bool:
    """Return whether a value is a number; true is none."""
    return isinstance(value, int | float) and not isinstance(value, bool)
