"""A view held still: its rays are cast once, and light that changes is added anew.

This is the quick way to pictures for whoever moves lights or changes skin: one ray a
pixel, everything else exact.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import even_size, in_slices
from skinviz.rendering import trace
from skinviz.rendering.colour import display_matrix
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.imager import pixels_of
from skinviz.rendering.lighting import Lighting
from skinviz.rendering.painter import Painter
from skinviz.rendering.plan import Plan, cells
from skinviz.rendering.shade import VertexSpectrum, parted
from skinviz.rendering.sight import Sight
from skinviz.rendering.stage import Stage
from skinviz.scene.camera import Camera
from skinviz.scene.relief import SMOOTH, Relief
from skinviz.scene.scene import Scene

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

ONE_RAY = Plan(samples=1)
"""Exact, but for edges."""

_RAYS = 2**15  # that a thread casts in one go


@dataclass(frozen=True, eq=False, repr=False)
class HeldView:
    """What the pixels of one view of a mesh see, whatever lights it.

    Attributes
    ----------
    sight : Sight
        The mesh and who looks at it.
    pixels : tuple of (k,) ndarray
        Those that show the mesh, row × width + column, some thousands at a time, in
        any order.
    hits : tuple of Hits
        What their rays hit.
    dark : (d,) ndarray
        Pixels that show the mesh's inside, which is black.
    """

    sight: Sight
    pixels: tuple[Whole, ...]
    hits: tuple[trace.Hits, ...]
    dark: Whole
    _shadows: dict[bytes, dict[int, NDArray[np.uint8]]] = field(default_factory=dict)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture. [pixels]"""
        return self.sight.view.size

    def stage(self, scene: Scene, plan: Plan = ONE_RAY) -> Stage:
        """Return a scene of this mesh on this view's stage, whatever its camera."""
        return Stage(scene, plan, self.sight, self.sight.seen)

    def xyz(self, stage: Stage) -> tuple[NDArray[np.float32], ...]:
        """Return the light (k, 3) of the pixels that show the mesh, in their parts."""
        painter = Painter(stage, self._lit_at)
        painter.prepare()
        light = [np.zeros((own.size, 3), np.float32) for own in self.pixels]

        def work(part: slice) -> None:
            for i in range(part.start, part.stop):
                light[i][:] = painter.colours(self.hits[i], 1)

        in_slices(work, len(light), 1)
        return tuple(light)

    def rgb(self, stage: Stage) -> NDArray[np.uint8]:
        """Return what the scene's display shows (height, width, 3)."""
        scene, light = stage.scene, self.xyz(stage)
        matrix = display_matrix(scene).T
        shown = np.zeros((self.size[0] * self.size[1], 3), np.uint8)
        shown[:] = scene.background
        shown[self.dark] = 0

        def work(part: slice) -> None:
            for i in range(part.start, part.stop):
                linear = light[i] @ matrix
                every = np.ones(len(linear), np.bool_)
                shown[self.pixels[i]] = scene.display.encode8(linear, every)[0]

        in_slices(work, len(light), 1)
        return shown.reshape(self.size[1], self.size[0], 3)

    def _lit_at(
        self, geometry: Geometry, lighting: Lighting, hits: trace.Hits
    ) -> NDArray[np.uint8]:
        """Return which lights points see; it is known while no light moves."""
        place = lighting.lights.tobytes()
        if place not in self._shadows:
            self._shadows.clear()
        known = self._shadows.setdefault(place, {})
        if id(hits) not in known:
            known[id(hits)] = trace.visibility_of(geometry, lighting, hits)
        return known[id(hits)]

    def point(self, column: float, row: float) -> Array | None:
        """Return the point [mm] (3,) that the ray of a pixel hits, if any.

        ``column`` and ``row`` are of any place in the pixel.
        """
        across, along = cells(1)[0]
        hit = _hit(self.sight, np.floor(column) + across, np.floor(row) + along)
        return None if hit is None else _in_mm(self.sight.geometry, hit)


@dataclass(frozen=True)
class SeenPoint:
    """The light that one point of the mesh sends to the eye.

    Attributes
    ----------
    xyz : (3,) ndarray
        Summed as pictures' colours are.
    spectrum : VertexSpectrum
        On the scene's wavelengths, in its parts.
    """

    xyz: Array
    spectrum: VertexSpectrum


def hold(geometry: Geometry, camera: Camera, relief: Relief = SMOOTH) -> HeldView:
    """Cast one ray for each pixel of a camera's picture.

    Parameters
    ----------
    geometry : Geometry
        Of the mesh, from :func:`geometry_of`.
    camera : Camera
        Who looks at it.
    relief : Relief
        Of what is seen, finer than its triangles.

    Returns
    -------
    held : HeldView
        To be lit as often as wanted.
    """
    sight = Sight(geometry, camera.view(geometry.in_mm), relief)
    _ = geometry.embree
    block, marked = sight.blocks
    asked = pixels_of(np.argwhere(marked), block, *camera.size)
    step = even_size(asked.size, _RAYS)
    parts: dict[int, tuple[Whole, trace.Hits, Whole]] = {}

    def work(part: slice) -> None:
        own = asked[part]
        hits = trace.cast(sight, cells(1), own)
        dark = hits.covered > 0
        dark[hits.pixels] = False
        parts[part.start] = own[hits.pixels], _alone(hits), own[dark]

    in_slices(work, asked.size, step)
    if not parts:
        return HeldView(sight, (), (), np.zeros(0, np.int64))
    pixels, hits, dark = zip(*(parts[i] for i in sorted(parts)), strict=True)
    return HeldView(sight, pixels, hits, np.concatenate(dark))


def seen_point(stage: Stage, point: Array, nearby: float = 0.5) -> SeenPoint | None:
    """Return the light of a point of the mesh; None where the eye does not see it.

    Parameters
    ----------
    stage : Stage
        A scene and its view.
    point : (3,) ndarray
        On the mesh. [mm]
    nearby : float
        How far from it the eye's ray may hit the mesh. [mm]
    """
    sight = stage.sight
    column, row = sight.view.project(point)
    hit = _hit(sight, column, row)
    if hit is None:
        return None
    if np.linalg.norm(_in_mm(sight.geometry, hit) - point) > nearby:
        return None
    painter, lit = Painter(stage), stage.bands
    scalars = painter.scalars(lit, hit)[:, 0]
    pigments = stage.scene.skin.values
    if pigments.ndim == 2:
        corners = sight.geometry.faces[hit.triangles[0]]
        pigments = hit.weights[:, 0] @ pigments[corners]
    return SeenPoint(
        np.asarray(painter.colours(hit, 1)[0], dtype=np.float64),
        parted(stage.scene, lit, scalars, pigments),
    )


def _hit(sight: Sight, column: float, row: float) -> trace.Hits | None:
    """Return what is hit through a place of the picture."""
    width, height = sight.view.size
    x, y = int(np.floor(column)), int(np.floor(row))
    if not (0 <= x < width and 0 <= y < height):
        return None
    within = np.array([[column - x, row - y]])
    hits = trace.cast(sight, within, np.array([y * width + x]))
    return hits if hits.rays.size else None


def _alone(hits: trace.Hits) -> trace.Hits:
    """Return hits of one ray a pixel as those of pixels 0, 1, ..."""
    number = np.arange(hits.rays.size)
    covered = np.ones(number.size, dtype=np.uint8)
    return dataclasses.replace(hits, rays=number, pixels=number, covered=covered)


def _in_mm(geometry: Geometry, hit: trace.Hits) -> Array:
    """Return where a hit is. [mm]"""
    return np.asarray(geometry.centre + geometry.scale * hit.points[:, 0])
