"""The lights that the [[lights]] of a scene file describe."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from skinviz.errors import DataError
from skinviz.scene.hand import HandFrame
from skinviz.scene.lights import DirectionalLight, Light, PointLight
from skinviz.spectra.illuminants import (
    Illuminant,
    as_illuminant,
    black_body,
    line_lamp,
    read_illuminant,
    with_lines,
)


def light_of(
    table: dict[str, Any], frame: HandFrame | None, angle: float, folder: Path
) -> Light:
    """Return one light: near, or far in a direction that is given or an angle's."""
    places = table.keys() & {"direction", "angle", "position"}
    if len(places) > 1:
        raise DataError(
            "[[lights]] takes one of direction, angle and position; got "
            f"{', '.join(sorted(places))}"
        )
    illuminant, strength = _illuminant(table, folder), table.get("strength", 1.0)
    if "position" in table:
        return PointLight(table["position"], illuminant, strength)
    if "direction" in table:
        return DirectionalLight(table["direction"], illuminant, strength)
    assert frame is not None  # noqa: S101 - made whenever a place is missing
    degrees = float(table.get("angle", 0.0))
    if not -90 <= degrees <= 90:
        raise DataError(f"angle in [[lights]] must be -90 to 90; got {degrees:g}")
    own = np.deg2rad(degrees) if "angle" in table else angle
    return DirectionalLight(frame.direction(own), illuminant, strength)


def _illuminant(table: dict[str, Any], folder: Path) -> str | Illuminant:
    """Return a light's spectrum: a lamp, its lines alone, or both together."""
    sources = table.keys() & {"illuminant", "temperature", "spectrum"}
    if len(sources) > 1:
        raise DataError(
            "[[lights]] takes one of illuminant, temperature and spectrum; got "
            f"{', '.join(sorted(sources))}"
        )
    if "lines" not in table:
        return _lamp(table, folder)
    if not sources:
        return line_lamp(table["lines"])
    return with_lines(as_illuminant(_lamp(table, folder)), table["lines"])


def _lamp(table: dict[str, Any], folder: Path) -> str | Illuminant:
    """Return a name, a black body, or a measured lamp."""
    if "temperature" in table:
        return black_body(table["temperature"])
    if "spectrum" in table:
        return read_illuminant(folder / table["spectrum"])
    return str(table.get("illuminant", "D65"))
