"""One setting for both programs, and how Mitsuba is told of it.

The light is the 61 bands' and nothing else: linear between them and falling to 0 at
5 nm beyond either end, so that Mitsuba's integral is the sum over bands.
"""

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import mitsuba as mi
import numpy as np

DEFAULT_SAMPLER, BEST_SAMPLER = "independent", "ldsampler"
_AT_ONCE = 256  # samples a pixel, beyond which new seeds help ldsampler more


@dataclass(frozen=True, eq=False)
class Material:
    """A Lambertian surface, or one half of it and half of rough facets.

    ``roughness`` is Beckmann's slope m, None without facets; ``n`` their index.
    """

    reflectance: np.ndarray
    roughness: float | None = None
    n: float = 1.4


@dataclass(frozen=True, eq=False)
class Setting:
    """Mesh [mm] with its normals, direction to the light, view, bands and light."""

    points: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    light: np.ndarray
    view: object  # of skinviz.scene.camera
    wavelengths: np.ndarray
    spd: np.ndarray


def hand(setting: Setting, material: Material, sampler: str, film: dict | None = None):
    """Return Mitsuba's scene of the mesh."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.ply"
        _write_ply(path, setting)
        shape = {"type": "ply", "filename": str(path)}
        return _scene(setting, material, shape, sampler, film)


def ball(setting: Setting, material: Material, radius: float):
    """Return Mitsuba's scene of a true sphere around the view's target."""
    shape = {"type": "sphere", "radius": radius, "center": list(setting.view.target)}
    return _scene(setting, material, shape, BEST_SAMPLER)


def white(setting: Setting, film: dict | None = None):
    """Return Mitsuba's scene of the perfect diffuser that faces light and viewer."""
    view, towards = setting.view, setting.light
    up = np.cross(towards, np.roll(towards, 1))
    up = up / np.linalg.norm(up)
    right = np.cross(up, towards)
    facing = replace(setting, view=replace(view, right=right, up=up, direction=towards))
    plate = mi.ScalarTransform4f().look_at(
        list(view.target), list(view.target + towards), list(up)
    )
    size = mi.ScalarTransform4f().scale(1e4)
    shape = {"type": "rectangle", "to_world": plate @ size}
    material = Material(np.ones(setting.wavelengths.size))
    return _scene(facing, material, shape, BEST_SAMPLER, film)


def spectral_film(wavelengths: np.ndarray) -> dict:
    """Return a film of one channel a band, each a triangle from band to band."""
    bands = _padded(wavelengths)
    hats = {
        f"band{i:03d}": _spectrum(bands[i : i + 3], np.array([0.0, 1.0, 0.0]))
        for i in range(wavelengths.size)
    }
    return {"type": "specfilm", **hats}


def bsdf(material: Material, wavelengths: np.ndarray) -> dict:
    """Return the material in Mitsuba's words."""
    bands = _padded(wavelengths)
    reflectance = np.pad(material.reflectance, 1, mode="edge")
    diffuse = {"type": "diffuse", "reflectance": _spectrum(bands, reflectance)}
    if material.roughness is None:
        return diffuse
    rough = {
        "type": "roughconductor",
        "distribution": "beckmann",
        "alpha": material.roughness,
        "eta": material.n,
        "k": 0.0,
        "specular_reflectance": 1.0,
    }
    return {"type": "blendbsdf", "weight": 0.5, "first": diffuse, "second": rough}


def _scene(
    setting: Setting,
    material: Material,
    shape: dict,
    sampler: str,
    film: dict | None = None,
):
    """Return a scene that is lit by the far light alone, seen by the parallel view."""
    view = setting.view
    width, height = view.size
    # The far light is found by light sampling only; the BSDF's would be wasted.
    integrator = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
    far = 1e4 * np.asarray(view.direction)
    stands = mi.ScalarTransform4f().look_at(
        list(view.target + far), list(view.target), list(view.up)
    )
    half_width = view.pixel * width / 2
    sensor = {
        "type": "orthographic",
        "far_clip": 3e4,
        "to_world": stands @ mi.ScalarTransform4f().scale([half_width, half_width, 1]),
        "sampler": {"type": sampler},
        "film": {
            **(film or {"type": "hdrfilm", "pixel_format": "xyz"}),
            "width": width,
            "height": height,
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
    }
    light = {
        "type": "directional",
        "direction": list(-setting.light),
        "irradiance": _spectrum(_padded(setting.wavelengths), np.pad(setting.spd, 1)),
    }
    surface = bsdf(material, setting.wavelengths)
    parts = {"integrator": integrator, "sensor": sensor, "light": light}
    return mi.load_dict({"type": "scene", **parts, "shape": {**shape, "bsdf": surface}})


def render(scene, spp: int, seed: int) -> np.ndarray:
    """Return Mitsuba's picture (height, width, channels), of its own scale."""
    return timed(scene, spp, seed)[0]


def timed(scene, spp: int, seed: int) -> tuple[np.ndarray, float]:
    """Return Mitsuba's picture and its time: passes × the least of one. [s]"""
    passes = max(1, spp // _AT_ONCE)
    total, times = 0.0, []
    for k in range(passes):
        start = time.perf_counter()
        film = mi.render(scene, spp=spp // passes, seed=seed * 10_000 + k)
        total = total + np.array(film, dtype=np.float64)
        times.append(time.perf_counter() - start)
    return total / passes, passes * min(times)


def _padded(wavelengths: np.ndarray) -> np.ndarray:
    """Return the bands with one more at either end."""
    first, last = wavelengths[:2], wavelengths[-2:]
    return np.r_[2 * first[0] - first[1], wavelengths, 2 * last[1] - last[0]]


def _spectrum(wavelengths: np.ndarray, values: np.ndarray) -> dict:
    return {
        "type": "irregular",
        "wavelengths": ", ".join(f"{x:.9g}" for x in wavelengths),
        "values": ", ".join(f"{x:.9g}" for x in values),
    }


def _write_ply(path: Path, setting: Setting) -> None:
    """Write points, normals and faces as binary PLY in single precision."""
    n, m = len(setting.points), len(setting.faces)
    names = "".join(f"property float {x}\n" for x in ("x", "y", "z", "nx", "ny", "nz"))
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {n}\n{names}"
        f"element face {m}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(m, dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, setting.faces
    vertices = np.hstack([setting.points, setting.normals]).astype("<f4")
    path.write_bytes(head.encode() + vertices.tobytes() + faces.tobytes())
