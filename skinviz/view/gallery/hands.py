"""Scenes of the hand that figures show: one shape, one view, many skins and lights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.spectral import white_xyz
from skinviz.scan.formats import read_mesh
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scene.camera import Camera
from skinviz.scene.hand import HandFrame, hand_frame
from skinviz.scene.lights import DirectionalLight
from skinviz.scene.scene import Scene, Skin
from skinviz.spectra.colorimetry import xyz_to_lab
from skinviz.spectra.illuminants import Illuminant
from skinviz.surface.torrance_sparrow import TorranceSparrow
from skinviz.view.gallery.recipe import Settings
from skinviz.view.hands_grid import render_linked
from skinviz.view.page import EDGE

if TYPE_CHECKING:
    import pyvista

    from skinviz.rendering.render import Rendering

Array = NDArray[np.float64]

ASPECT = 4 / 3
"""Height of a picture over its width."""

MADE = (
    "Two-layer Kubelka–Munk skin and Torrance–Sparrow surface, rays traced, colours "
    "through CIE XYZ without white adaptation; all pictures have one exposure and one "
    "scale."
)
"""Said of all pictures of hands."""


@cache
def hand() -> tuple[pyvista.PolyData, HandFrame]:
    """Return the shipped hand [mm] and how it lies."""
    mesh = read_mesh(shipped_mesh(TRUE_SHAPE), unit="m")
    return mesh, hand_frame(mesh)


def hand_scene(
    skin: Skin,
    size: tuple[int, int],
    *,
    illuminant: str | Illuminant = "D65",
    angles: tuple[float, float] = (0.0, 0.0),
) -> Scene:
    """Return the hand with a skin, under a light.

    ``angles`` are of illumination and viewing from the normal of the hand's back, on
    opposite sides, as in the paper's fig. 9. [°]
    """
    mesh, frame = hand()
    light, view = np.deg2rad(angles)
    return Scene(
        mesh=mesh,
        skin=skin,
        surface=TorranceSparrow(),
        lights=(DirectionalLight(frame.direction(light), illuminant),),
        camera=Camera(frame.direction(-view), frame.fingers, size),
    )


def picture_size(settings: Settings, columns: int) -> tuple[int, int]:
    """Return the size at which pictures in some columns are printed. [pixels]"""
    wide = (settings.width - 2 * EDGE) / columns * settings.dots
    return max(int(wide), 8), max(int(wide * ASPECT), 8)


def rendered(
    scenes: Mapping[str, Scene], settings: Settings
) -> tuple[dict[str, NDArray[np.uint8]], list[dict[str, Any]]]:
    """Return pictures by name, and one row of numbers for each.

    The rows have the median L*a*b* of the lit pixels that the hand fills, with the
    perfect diffuser under the picture's light as white, and how many the display cannot
    show.
    """
    advance = settings.counting(len(scenes))
    made = render_linked(list(scenes.values()), advance=advance)
    pictures = {name: own.rgb for name, own in zip(scenes, made, strict=True)}
    rows = [
        {"picture": name, **_numbers(own)}
        for name, own in zip(scenes, made, strict=True)
    ]
    return pictures, rows


def _numbers(picture: Rendering) -> dict[str, Any]:
    """Return what is measured of a picture."""
    full = (picture.covered == picture.rays) & (picture.xyz[..., 1] > 0)
    lab = np.median(xyz_to_lab(picture.xyz[full], white_xyz(picture.scene)), axis=0)
    counts = picture.counts
    return {
        "pixel_mm": picture.view.pixel,
        "L": lab[0],
        "a": lab[1],
        "b": lab[2],
        "pixels": counts.total,
        "out_of_gamut": counts.out_of_gamut,
        "over_exposed": counts.over_exposed,
    }


def grid_of(names: Sequence[str], columns: int) -> list[list[str]]:
    """Return names in rows of some columns."""
    return [list(names[i : i + columns]) for i in range(0, len(names), columns)]
