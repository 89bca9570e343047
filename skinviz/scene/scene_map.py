"""Skin that differs by place, as [skin.map] and the like of a scene file have it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinviz._validate import one_of
from skinviz.errors import DataError
from skinviz.scene.pigment_map import Point, pigment_map
from skinviz.scene.scene import Skin
from skinviz.scene.scene_skin import archive_fit, skin_from_fit_file
from skinviz.scene.texture import SkinTexture

if TYPE_CHECKING:
    import pyvista

_SAID = (
    'weights as [w_m, w_h, w_dh], a fit file as "fit.json#2", a site of the archive '
    'as "palm", or changes as { melanin = "x0.4" }'
)


def mapped(
    skin: Skin, table: Mapping[str, Any], mesh: pyvista.PolyData, folder: Path
) -> Skin:
    """Return a skin that is spread from the points a scene names, if it names any.

    What a point has may be said relative to ``skin``, that of the whole.
    """
    points: dict[Point, Any] = dict(table.get("map", {}))
    for row in table.get("point", []):
        place = _place(row)
        if place in points:
            raise DataError(f"[[skin.point]] says {place} twice; leave one out")
        points[place] = row.get("skin", {})
    if not points:
        return skin
    if skin.values.ndim != 1:
        raise DataError(
            "[skin.map] needs one skin that its points differ from, by weights, fit or "
            "archive; painted and image are maps already"
        )
    values = {
        point: _values(skin, said, point, table, folder)
        for point, said in points.items()
    }
    told = ", ".join(map(str, points))
    history = (*skin.history, f"spread along the surface from {told}")
    return Skin(skin.model, pigment_map(mesh, values), history)


def texture_of(table: Mapping[str, Any]) -> SkinTexture:
    """Return the texture that [skin.texture] says."""
    known = [field.name for field in dataclasses.fields(SkinTexture)]
    for key in table:
        one_of(key, known, "key in [skin.texture]")
    return SkinTexture(**table)


def _place(row: Mapping[str, Any]) -> Point:
    """Return the vertex or coordinates of a [[skin.point]]."""
    unknown = row.keys() - {"at", "vertex", "skin"}
    if unknown or len(row.keys() & {"at", "vertex"}) != 1:
        raise DataError(
            "[[skin.point]] takes at = [x, y, z] in mm or vertex = 12, and skin = ...; "
            f"got {', '.join(row) or 'nothing'}"
        )
    if "vertex" in row:
        if type(row["vertex"]) is not int:
            raise DataError(f"vertex must be a whole number; got {row['vertex']!r}")
        return int(row["vertex"])
    if not isinstance(row["at"], list):
        raise DataError(f"at must be [x, y, z] in mm; got {row['at']!r}")
    return tuple(row["at"])


def _values(
    skin: Skin, said: Any, point: Point, table: Mapping[str, Any], folder: Path
) -> Any:
    """Return the parameters (p,) that a scene says of one point."""
    if isinstance(said, dict):
        return skin.changed(**said).values
    if isinstance(said, list):
        return said
    if not isinstance(said, str):
        raise DataError(f"the point {point!r} in [skin] takes {_SAID}; got {said!r}")
    name, _, record = said.partition("#")
    if name.lower().endswith(".json"):
        key = int(record) if record.isdecimal() else record or 0
        other = skin_from_fit_file(folder / name, key)
        if other.model.description != skin.model.description:
            raise DataError(
                f"{name} was fitted with another model, thickness, coefficients or "
                f"specular than [skin] has: {_differing(other, skin)}; one surface has "
                "one model: fit all points with the same --thickness"
            )
        return other.values
    if "archive" not in table:
        raise DataError(
            f"the point {point!r} in [skin] names {said!r}, a site of an archive; say "
            f"archive, origin, subject and site in [skin], or give {_SAID}"
        )
    return archive_fit(table, said, skin.model).values


def _differing(one: Skin, other: Skin) -> str:
    """Return what of two models differs."""
    own, theirs = one.model.description, other.model.description
    return ", ".join(
        f"{key} {own.get(key)} and {theirs.get(key)}"
        for key in own.keys() | theirs.keys()
        if own.get(key) != theirs.get(key)
    )
