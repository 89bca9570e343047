"""Scene files: TOML that a person can write, read into a frozen ``Scene``."""

from __future__ import annotations

import json
import math
import os
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from skinviz._files import existing_file
from skinviz.errors import ArgumentError, DataError, SkinvizError
from skinviz.scan.formats import read_mesh
from skinviz.scene.camera import Camera
from skinviz.scene.hand import HandFrame, hand_frame
from skinviz.scene.lights import DirectionalLight
from skinviz.scene.scene import Scene, Skin
from skinviz.skin.fit import fit_skin
from skinviz.skin.fitted import FITS_FORMAT
from skinviz.skin.models import skin_model
from skinviz.skin.report import FIT_FORMAT
from skinviz.spectra.archives import load_archive
from skinviz.surface.torrance_sparrow import TorranceSparrow

_TEXT, _NUMBER, _NUMBERS, _COUNT = "text", "a number", "a list of numbers", "a count"
_WORD_OR_NUMBER, _WORDS = "text or a number", "a list of texts"

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
    },
    "surface": {
        "gamma": _NUMBER,
        "n": _NUMBER,
        "specular_scale": _NUMBER,
        "beta": _NUMBER,
        "masking": _TEXT,
    },
    "lights": {
        "illuminant": _TEXT,
        "direction": _NUMBERS,
        "angle": _NUMBER,
        "strength": _NUMBER,
    },
    "view": {
        "angles": _TEXT,
        "direction": _NUMBERS,
        "up": _NUMBERS,
        "size": _NUMBERS,
        "exposure": _NUMBER,
        "observer": _TEXT,
    },
}


_TISSUE = {"site", "thickness", "coefficients", "free"}
_SKIN_KEYS = {
    "weights": {"model", "specular"} | _TISSUE,
    "fit": {"record"},
    "archive": {"model", "specular", "origin", "subject"} | _TISSUE,
}


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene from a TOML file.

    Parameters
    ----------
    path : str or path-like
        The file. Its tables are ``[mesh]``, ``[skin]``, ``[surface]``,
        ``[[lights]]`` and ``[view]``; paths in it are relative to it. Angles are
        in degrees from the normal of the hand's back.

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
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"{file}: not a TOML file: {error}") from error
    try:
        return _scene(content, file.parent)
    except SkinvizError as error:
        told = str(error)
        kind = DataError if isinstance(error, ArgumentError) else type(error)
        # Errors of the files that a scene names already name those.
        raise kind(told if file.name in told else f"{file}: {told}") from error


def _scene(content: dict[str, Any], folder: Path) -> Scene:
    """Return the scene that parsed TOML describes."""
    _require_known(content)
    mesh_table = content.get("mesh", {})
    if "path" not in mesh_table:
        raise DataError('[mesh] needs path = "hand.ply"')
    mesh = read_mesh(folder / mesh_table["path"], mesh_table.get("unit"))
    view = content.get("view", {})
    light_angle, view_angle = _angles(view.get("angles", "0/0"))
    lights_table = content.get("lights", [{}])
    # Only angles need the hand's own directions; any mesh can be lit by vectors.
    by_vectors = {"direction", "up"} <= view.keys() and all(
        "direction" in light for light in lights_table
    )
    frame = None if by_vectors else hand_frame(mesh)
    return Scene(
        mesh=mesh,
        skin=_skin(content.get("skin", {}), folder),
        surface=_surface(content.get("surface", {})),
        lights=tuple(_light(light, frame, light_angle) for light in lights_table),
        camera=_camera(view, frame, view_angle),
        exposure=view.get("exposure", 1.0),
        observer=view.get("observer", "cie1931"),
    )


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
        for key, value in (pair for row in rows for pair in row.items()):
            _require_kind(name, key, value)


def _require_kind(table: str, key: str, value: Any) -> None:
    """Refuse an unknown key, or a value of another kind than the key's."""
    known = _TABLES[table]
    if key not in known:
        raise DataError(
            f"unknown key {key!r} in [{table}]; known are {', '.join(sorted(known))}"
        )
    number = _is_number(value)
    fits = {
        _TEXT: isinstance(value, str),
        _NUMBER: number,
        _COUNT: number and isinstance(value, int) and value >= 0,
        _NUMBERS: isinstance(value, list) and all(map(_is_number, value)),
        _WORD_OR_NUMBER: isinstance(value, str) or number,
        _WORDS: isinstance(value, list) and all(isinstance(x, str) for x in value),
    }
    if not fits[known[key]]:
        raise DataError(f"{key} in [{table}] must be {known[key]}; got {value!r}")


def _is_number(value: Any) -> bool:
    """Return whether a TOML value is a finite number."""
    return type(value) in (int, float) and math.isfinite(value)


def _skin(table: dict[str, Any], folder: Path) -> Skin:
    """Return the skin: weights given, read from a fit file, or fitted now."""
    sources = [key for key in _SKIN_KEYS if key in table]
    if len(sources) != 1:
        raise DataError(
            "[skin] needs exactly one of weights = [w_m, w_h, w_dh], "
            f'fit = "fit.json" and archive = "issa"; got {sources or "none"}'
        )
    (source,) = sources
    idle = sorted(table.keys() - _SKIN_KEYS[source] - {source})
    if idle:
        raise DataError(f"[skin] with {source} has no use for {', '.join(idle)}")
    if source == "fit":
        return skin_from_fit_file(folder / table["fit"], table.get("record", 0))
    options = {key: table[key] for key in _TISSUE if key in table}
    if str(options.get("coefficients")).lower().endswith(".csv"):
        options["coefficients"] = folder / options["coefficients"]
    name = table.get("model", "two-layer")
    if source == "archive":
        return _archive_skin(table, name, options)
    if "specular" not in table:
        raise DataError(
            '[skin] needs specular = "excluded", "included" or a number: how the '
            "spectrum behind the weights was measured"
        )
    model = skin_model(name, specular=table["specular"], **options)
    return Skin(model, np.asarray(table["weights"], dtype=np.float64))


def _archive_skin(table: dict[str, Any], name: str, options: dict[str, Any]) -> Skin:
    """Fit the spectrum of one archive subject and site."""
    archive = load_archive(table["archive"])
    chosen = np.ones(archive.sizes["record"], dtype=bool)
    for key in ("origin", "subject", "site"):
        if key not in table:
            raise DataError(f"[skin] with archive needs {key} = ...")
        chosen &= archive[key].values == str(table[key])
    if not chosen.any():
        sites = sorted(set(archive["site"].values))
        raise DataError(
            f"archive {table['archive']!r} has no spectrum of subject "
            f"{table['subject']!r} of {table['origin']!r} at {table['site']!r}; its "
            f"sites are {', '.join(sites)}, its origins "
            f"{', '.join(sorted(set(archive['origin'].values)))}"
        )
    if "thickness" in options:  # then the site only names the spectrum
        options = {key: options[key] for key in options if key != "site"}
    spectrum = archive.reflectance.values[chosen].mean(axis=0)
    specular = table.get("specular", archive.attrs["specular"])
    model = skin_model(name, specular=specular, **options)
    return Skin.from_fit(fit_skin(spectrum, archive.wavelength.values, model))


def skin_from_fit_file(path: Path, record: int = 0) -> Skin:
    """Return the skin in a JSON file that ``skinviz fit`` wrote."""
    file = existing_file(path, DataError)
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        known = content["format"] == FIT_FORMAT
        if content["format"] == FITS_FORMAT:
            raise DataError(
                f"{file} holds fits of several models; fit with one --model for a scene"
            )
        fits = content["fits"]
        options = {key: content[key] for key in ("specular", "coefficients")}
        options |= {key: content[key] for key in ("free",) if key in content}
        name, thickness = content["model"], content["thickness_mm"]
        backing = content["hypodermis"]
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(f"{file}: not a fit file of 'skinviz fit'") from error
    if not known:
        raise DataError(f"{file}: written as {content['format']!r}; fit the file anew")
    if record >= len(fits):
        raise DataError(f"{file} has {len(fits)} records, 0 the first; got {record}")
    model = skin_model(name, thickness=thickness, hypodermis=backing, **options)
    weights = fits[record]["parameters"]
    values = [weights[p.name]["value"] for p in model.parameters]
    if any(value is None for value in values):
        raise DataError(
            f"{file}: record {record} was refused by the fit; choose another"
        )
    return Skin(model, np.asarray(values, dtype=np.float64))


def _surface(table: dict[str, Any]) -> TorranceSparrow:
    """Return the surface, by β or by its physical scale."""
    if "beta" not in table:
        return TorranceSparrow(**table)
    if "specular_scale" in table:
        raise DataError("[surface] takes beta or specular_scale, not both")
    default = TorranceSparrow()
    return TorranceSparrow.from_beta(
        table["beta"],
        table.get("gamma", default.gamma),
        table.get("n", default.n),
        table.get("masking", default.masking),
    )


def _light(
    table: dict[str, Any], frame: HandFrame | None, angle: float
) -> DirectionalLight:
    """Return one light, its direction given or from its angle."""
    if "direction" in table:
        if "angle" in table:
            raise DataError("[[lights]] takes direction or angle, not both")
        direction = table["direction"]
    else:
        assert frame is not None  # noqa: S101 - made whenever a direction is missing
        degrees = float(table.get("angle", 0.0))
        if not -90 <= degrees <= 90:
            raise DataError(f"angle in [[lights]] must be -90 to 90; got {degrees:g}")
        own = np.deg2rad(degrees) if "angle" in table else angle
        direction = frame.direction(own)
    return DirectionalLight(
        direction,
        table.get("illuminant", "D65"),
        table.get("strength", 1.0),
    )


def _camera(table: dict[str, Any], frame: HandFrame | None, angle: float) -> Camera:
    """Return the camera, its direction given or on the other side from the light."""
    size = table.get("size", [1024, 1024])
    if frame is None:
        return Camera(table["direction"], table["up"], size)
    return Camera(
        table.get("direction", frame.direction(-angle)),
        table.get("up", frame.fingers),
        size,
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
