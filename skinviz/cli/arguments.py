"""Kinds of arguments that several verbs take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token


def _whole(_: Any, tokens: Sequence[Token]) -> int:
    """Return a whole number; 99.9 is none and is not rounded to one."""
    return int(tokens[0].value)


Whole = Annotated[int, Parameter(converter=_whole)]
"""A whole number, refused as wrong usage where it has a fraction."""
