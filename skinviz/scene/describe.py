"""A scene as plain data, to be kept with what was made of it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from skinviz.scene.camera import Camera
from skinviz.scene.lights import Light
from skinviz.scene.scene import Scene, Skin


def describe(scene: Scene) -> dict[str, Any]:
    """Return what a scene is made of, as JSON can hold it.

    The mesh is told by its counts and box, pigments that differ over it by their
    ranges: a description is for people and for finding the same again, and does not
    replace the files.
    """
    points = np.asarray(scene.mesh.points, dtype=np.float64)
    return {
        "mesh": {
            "vertices": scene.mesh.n_points,
            "triangles": scene.mesh.n_cells,
            "from_mm": points.min(axis=0).tolist(),
            "to_mm": points.max(axis=0).tolist(),
        },
        "skin": _skin(scene.skin),
        "surface": {
            "model": type(scene.surface).__name__,
            **{
                field.name: _plain(getattr(scene.surface, field.name))
                for field in dataclasses.fields(scene.surface)
            },
        },
        "lights": [_light(light) for light in scene.lights],
        "camera": _camera(scene.camera),
        "diffuse_scale": scene.diffuse_scale,
        "exposure": scene.exposure,
        "interreflection": scene.interreflection,
        "observer": scene.observer,
        "wavelengths_nm": scene.wavelengths.tolist(),
        "display": scene.display.name,
        "white": scene.white,
        "relief": dataclasses.asdict(scene.relief),
        "background_rgb8": list(scene.background),
    }


def _skin(skin: Skin) -> dict[str, Any]:
    """Return a model and its parameters, or their ranges."""
    names = [p.name for p in skin.model.parameters]
    values = np.atleast_2d(skin.values)
    low, high = values.min(axis=0), values.max(axis=0)
    told: dict[str, Any] = {
        name: [float(a), float(b)] if b > a else float(a)
        for name, a, b in zip(names, low, high, strict=True)
    }
    history = {"history": list(skin.history)} if skin.history else {}
    return {**skin.model.description, "parameters": told, **history}


def _light(light: Light) -> dict[str, Any]:
    """Return one light."""
    *at, near = light.homogeneous.tolist()
    lamp = light.spectrum
    return {
        "position_mm" if near else "direction": at,
        "illuminant": lamp.name,
        **({"lines_nm_power": lamp.lines.tolist()} if len(lamp.lines) else {}),
        "strength": float(light.strength),
    }


def _camera(camera: Camera) -> dict[str, Any]:
    """Return a camera; null where it is aimed by the mesh, or far away."""
    return {
        "direction": camera.direction.tolist(),
        "up": camera.up.tolist(),
        "size_pixels": list(camera.size),
        "distance_mm": None if np.isinf(camera.distance) else float(camera.distance),
        "target_mm": None if camera.target is None else camera.target.tolist(),
        "height_mm": camera.height,
    }


def _plain(value: Any) -> Any:
    """Return a number or word as it is, and anything else in words."""
    return value if isinstance(value, float | int | str | bool) else str(value)
