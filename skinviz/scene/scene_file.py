"""Scene files: TOML that a person can write, read into a frozen ``Scene``."""

from __future__ import annotations

import math
import os
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file
from skinviz.errors import ArgumentError, DataError, SkinvizError
from skinviz.scan.formats import read_mesh
from skinviz.scene.camera import Camera
from skinviz.scene.hand import HandFrame, hand_frame
from skinviz.scene.scene import Scene, Skin
from skinviz.scene.scene_lights import light_of
from skinviz.scene.scene_map import mapped, texture_of
from skinviz.scene.scene_skin import skin_of
from skinviz.scene.texture import textured
from skinviz.spectra.display_file import read_display
from skinviz.surface.models import surface_model, surface_parameters
from skinviz.surface.surface import Surface

_TEXT, _NUMBER, _NUMBERS, _COUNT = "text", "a number", "a list of numbers", "a count"
_MOST_BANDS = 2000
_SURFACE = "torrance-sparrow"  # the model of a [surface] that names none
_WORD_OR_NUMBER, _WORDS = "text or a number", "a list of texts"
_LINES = "a list of [nm, power] pairs"
_TABLE, _ROWS = "a table", "an array of tables"

_TABLES = {
    "mesh": {"path": _TEXT, "unit": _TEXT},
    "skin": {
        "model": _TEXT,
        "site": _TEXT,
        "thickness": _NUMBERS,
        "specular": _WORD_OR_NUMBER,
        "coefficients": _TEXT,
        "free": _WORDS,
        "weights": _NUMBERS,
        "fit": _TEXT,
        "record": _COUNT,
        "archive": _TEXT,
        "origin": _TEXT,
        "subject": _TEXT,
        "painted": _TEXT,
        "image": _TEXT,
        "weights_at_one": _NUMBERS,
        "map": _TABLE,
        "point": _ROWS,
        "change": _TABLE,
        "texture": _TABLE,
    },
    "surface": {"model": _TEXT, "n": _WORD_OR_NUMBER, "masking": _TEXT},
    "lights": {
        "illuminant": _TEXT,
        "temperature": _NUMBER,
        "spectrum": _TEXT,
        "lines": _LINES,
        "direction": _NUMBERS,
        "angle": _NUMBER,
        "position": _NUMBERS,
        "strength": _NUMBER,
    },
    "view": {
        "angles": _TEXT,
        "direction": _NUMBERS,
        "up": _NUMBERS,
        "size": _NUMBERS,
        "distance": _NUMBER,
        "target": _NUMBERS,
        "height": _NUMBER,
        "exposure": _NUMBER,
        "background": _NUMBERS,
        "observer": _TEXT,
        "wavelengths": _NUMBERS,
    },
    "display": {"profile": _TEXT, "white": _TEXT},
    "transport": {"interreflection": _TEXT, "diffuse_scale": _NUMBER},
}


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene from a TOML file.

    Parameters
    ----------
    path : str or path-like
        The file. Its tables are ``[mesh]``, ``[skin]``, ``[surface]``,
        ``[[lights]]``, ``[view]`` and ``[transport]``; paths in it are relative to
        it. Angles are in degrees from the normal of the hand's back.

    Returns
    -------
    scene : Scene
        With directions worked out from angles and the skin fitted if asked.

    Raises
    ------
    DataError
        If the file is missing, not TOML, or a table or key is unknown, missing or
        wrong; the message names it.
    MeshError
        If the mesh cannot be read.
    """
    file = existing_file(path, DataError)
    try:
        return scene_from(read_scene_content(file), file.parent)
    except SkinvizError as error:
        raise named(error, file) from error


def read_scene_content(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return what a scene file says, as TOML has it: its tables and keys are known.

    Raises
    ------
    DataError
        If the file is missing, not TOML, or a table or key is unknown or wrong.
    """
    file = existing_file(path, DataError)
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"{file}: not a TOML file: {error}") from error
    _require_known(content)
    return content


def named(error: SkinvizError, file: Path) -> SkinvizError:
    """Return an error of a scene that names its file."""
    told = str(error)
    kind = DataError if isinstance(error, ArgumentError) else type(error)
    # Errors of the files that a scene names already name those.
    return kind(told if file.name in told else f"{file}: {told}")


def scene_from(
    content: dict[str, Any], folder: Path, skin: Skin | None = None
) -> Scene:
    """Return the scene that a scene file's content describes.

    Parameters
    ----------
    content : dict
        From :func:`read_scene_content`.
    folder : Path
        To which its paths are relative.
    skin : Skin, optional
        In place of what ``[skin]`` describes before maps, texture and changes.

    Raises
    ------
    SkinvizError
        As :func:`read_scene`, the file not named.
    """
    mesh_table = content.get("mesh", {})
    if "path" not in mesh_table:
        raise DataError('[mesh] needs path = "hand.ply"')
    mesh = read_mesh(folder / mesh_table["path"], mesh_table.get("unit"))
    view = content.get("view", {})
    light_angle, view_angle = _angles(view.get("angles", "0/0"))
    lights_table = content.get("lights", [{}])
    # Only angles need the hand's own directions; any mesh can be lit by vectors.
    by_vectors = {"direction", "up"} <= view.keys() and all(
        light.keys() & {"direction", "position"} for light in lights_table
    )
    frame = None if by_vectors else hand_frame(mesh)
    table = content.get("skin", {})
    base = skin or skin_of(table, folder, mesh)
    even = Scene(
        mesh=mesh,
        skin=mapped(base, table, mesh, folder),
        surface=_surface(content.get("surface", {})),
        lights=tuple(
            light_of(light, frame, light_angle, folder) for light in lights_table
        ),
        camera=_camera(view, frame, view_angle),
        **_settings(content),
        **_display(content.get("display", {}), folder),
    )
    scene = textured(even, texture_of(table["texture"])) if "texture" in table else even
    return scene.replace(skin=scene.skin.changed(**table.get("change", {})))


def _display(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return what pictures are made for, where it is said."""
    found = {key: table[key] for key in ("white",) if key in table}
    if "profile" in table:
        found["display"] = read_display(folder / table["profile"])
    return found


def _settings(content: dict[str, Any]) -> dict[str, Any]:
    """Return what a scene is told by single words and numbers, where it is said."""
    view = content.get("view", {})
    keys = ("exposure", "background", "observer", "wavelengths")
    found = {key: view[key] for key in keys if key in view}
    found |= content.get("transport", {})
    if "wavelengths" in found:
        found["wavelengths"] = _grid(found["wavelengths"])
    if "background" in found:
        found["background"] = tuple(found["background"])
    return found


def _grid(numbers: list[float]) -> NDArray[np.float64]:
    """Return the wavelengths from the first to the last by a step. [nm]"""
    if len(numbers) != 3 or numbers[2] <= 0 or numbers[1] < numbers[0]:
        raise DataError(
            "wavelengths in [view] must be [first, last, step] in nm, as [400, 700, "
            f"5]; got {numbers}"
        )
    first, last, step = numbers
    n = int((last - first) / step + 1e-9) + 1
    if n > _MOST_BANDS:
        raise DataError(f"[view] has {n} wavelengths; at most {_MOST_BANDS}")
    return first + step * np.arange(n, dtype=np.float64)


def _require_known(content: dict[str, Any]) -> None:
    """Refuse misspelt tables and keys instead of passing over them."""
    for name, table in content.items():
        if name not in _TABLES:
            raise DataError(f"unknown table [{name}]; known are {', '.join(_TABLES)}")
        rows = table if isinstance(table, list) else [table]
        if (name == "lights") != isinstance(table, list) or not all(
            isinstance(row, dict) for row in rows
        ):
            shape = "[[lights]], once per light" if name == "lights" else f"[{name}]"
            raise DataError(f"write {shape}")
        for row in rows:
            known = _surface_keys(row) if name == "surface" else _TABLES[name]
            for key, value in row.items():
                _require_kind(name, known, key, value)


def _surface_keys(table: dict[str, Any]) -> dict[str, str]:
    """Return the keys of [surface], those of its model, and their kinds."""
    kinds = _TABLES["surface"]
    own = surface_parameters(table.get("model", _SURFACE))
    return {key: kinds.get(key, _NUMBER) for key in ("model", *own)}


def _require_kind(table: str, known: dict[str, str], key: str, value: Any) -> None:
    """Refuse an unknown key, or a value of another kind than the key's."""
    if key not in known:
        raise DataError(
            f"unknown key {key!r} in [{table}]; known are {', '.join(sorted(known))}"
        )
    number = _is_number(value)
    fits = {
        _TEXT: isinstance(value, str),
        _NUMBER: number,
        _COUNT: number and isinstance(value, int) and value >= 0,
        _NUMBERS: _are_numbers(value),
        _LINES: isinstance(value, list)
        and all(_are_numbers(pair) and len(pair) == 2 for pair in value),
        _WORD_OR_NUMBER: isinstance(value, str) or number,
        _WORDS: isinstance(value, list) and all(isinstance(x, str) for x in value),
        _TABLE: isinstance(value, dict),
        _ROWS: isinstance(value, list) and all(isinstance(x, dict) for x in value),
    }
    if not fits[known[key]]:
        raise DataError(f"{key} in [{table}] must be {known[key]}; got {value!r}")


def _is_number(value: Any) -> bool:
    """Return whether a TOML value is a finite number."""
    return type(value) in (int, float) and math.isfinite(value)


def _are_numbers(value: Any) -> bool:
    """Return whether a TOML value is a list of finite numbers."""
    return isinstance(value, list) and all(map(_is_number, value))


def _surface(table: dict[str, Any]) -> Surface:
    """Return the surface that a model's name and keys describe."""
    own = {key: table[key] for key in table if key != "model"}
    return surface_model(table.get("model", _SURFACE), **own)


def _camera(table: dict[str, Any], frame: HandFrame | None, angle: float) -> Camera:
    """Return the camera, its direction given or on the other side from the light."""
    options = {
        key: table[key] for key in ("distance", "target", "height") if key in table
    }
    size = table.get("size", [1024, 1024])
    if frame is None:
        return Camera(table["direction"], table["up"], size, **options)
    return Camera(
        table.get("direction", frame.direction(-angle)),
        table.get("up", frame.fingers),
        size,
        **options,
    )


def _angles(text: str) -> tuple[float, float]:
    """Return illumination and viewing angle [rad] from the shorthand "60/60"."""
    try:
        light, view = (float(part) for part in text.split("/"))
    except ValueError as error:
        raise DataError(
            f'angles must be "illumination/viewing" in degrees, as "60/60"; got '
            f"{text!r}"
        ) from error
    if not (0 <= light <= 90 and 0 <= view <= 90):
        raise DataError(f"angles must be within 0 to 90 degrees; got {text!r}")
    return float(np.deg2rad(light)), float(np.deg2rad(view))
