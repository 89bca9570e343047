"""Kinds of arguments that several verbs take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter, Token

if TYPE_CHECKING:
    from skinviz.scene.scene import Scene


def _whole(_: Any, tokens: Sequence[Token]) -> int:
    """Return a whole number; 99.9 is none and is not rounded to one."""
    return int(tokens[0].value)


Whole = Annotated[int, Parameter(converter=_whole)]
"""A whole number, refused as wrong usage where it has a fraction."""


@Parameter(name="*")
@dataclass(frozen=True)
class WhatIf:
    """What a scene's skin has more or less of: x2 multiplies, +0.01 adds, 0.4 sets.

    Parameters
    ----------
    melanin
        Change of w_m, as x2, +0.05 or 0.2.
    oxyhaemoglobin
        Change of w_h.
    deoxyhaemoglobin
        Change of w_dh.
    haemoglobin
        Change of both, the saturation kept.
    saturation
        Change of the share of haemoglobin with oxygen, all haemoglobin kept.
    """

    melanin: str | None = None
    oxyhaemoglobin: str | None = None
    deoxyhaemoglobin: str | None = None
    haemoglobin: str | None = None
    saturation: str | None = None

    def of(self, scene: Scene) -> Scene:
        """Return a scene with its skin changed."""
        given = {name: word for name, word in asdict(self).items() if word is not None}
        return scene.replace(skin=scene.skin.changed(**given))


UNCHANGED = WhatIf()
"""Skin as the scene has it."""
