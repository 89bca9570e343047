"""Numbers at marked points: colour, its difference, and light in its parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.colour import display_matrix
from skinviz.rendering.held import seen_point
from skinviz.rendering.shade import VertexSpectrum
from skinviz.spectra.colorimetry import delta_e_2000, xyz_to_lab
from skinviz.view.viewer.pictures import Shown
from skinviz.view.viewer.state import Mark

Array = NDArray[np.float64]

_DIGITS = 4  # of millimetres, in links


@dataclass(frozen=True, eq=False)
class Reading:
    """What is seen at a marked point.

    Attributes
    ----------
    mark : Mark
        The point.
    at : (float, float)
        Where it is in the picture, as shares of its width and height.
    xyz : (3,) ndarray
        The perfect diffuser under light 1 has Y = exposure.
    lab : (3,) ndarray
        L*a*b* with that diffuser as the white.
    rgb : (int, int, int)
        What the display shows.
    spectrum : VertexSpectrum
        Radiance in its parts.
    """

    mark: Mark
    at: tuple[float, float]
    xyz: Array
    lab: Array
    rgb: tuple[int, ...]
    spectrum: VertexSpectrum

    @property
    def hex(self) -> str:
        """The colour as a page has it, "#aabbcc"."""
        return "#" + "".join(f"{level:02x}" for level in self.rgb)


def readings_of(shown: Shown) -> tuple[Reading | None, ...]:
    """Return what is seen at each marked point; None where it is out of sight."""
    return tuple(_reading(shown, mark) for mark in shown.state.points)


def difference_of(readings: tuple[Reading | None, ...]) -> float | None:
    """Return ΔE00 between two points, None unless both are seen."""
    if len(readings) < 2 or readings[0] is None or readings[1] is None:
        return None
    return float(delta_e_2000(readings[0].lab, readings[1].lab))


def mark_at(shown: Shown, column: float, row: float) -> Mark | None:
    """Return the point seen at a place of the picture, if any is. [pixels]"""
    found = shown.tiles.at(column, row)
    if found is None or found[0] >= len(shown.stages):
        return None
    tile, x, y = found
    point = shown.held.point(x, y)
    if point is None:
        return None
    return Mark(tile, tuple(np.round(point, _DIGITS).tolist()))


def _reading(shown: Shown, mark: Mark) -> Reading | None:
    """Return what is seen at a point."""
    stage = shown.stages[mark.look]
    place = np.array(mark.place)
    seen = seen_point(stage, place)
    if seen is None:
        return None
    linear = seen.xyz[None] @ display_matrix(stage.scene).T
    rgb = stage.scene.display.encode8(linear, np.ones(1, np.bool_))[0][0]
    left, top = shown.tiles.corner(mark.look)
    column, row = stage.sight.view.project(place)
    width, height = shown.tiles.whole
    return Reading(
        mark,
        (float((left + column) / width), float((top + row) / height)),
        seen.xyz,
        xyz_to_lab(seen.xyz, stage.white),
        tuple(int(level) for level in rgb),
        seen.spectrum,
    )
