"""A mesh and who looks at it: what stays when lights move."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering import rays
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.outlines import facing_triangles, outline_pixels
from skinviz.scene.camera import View
from skinviz.scene.relief import SMOOTH, Relief

Array = NDArray[np.float64]

_BLOCKS = 64  # along the longer side of a picture


@dataclass(frozen=True, eq=False)
class Sight:
    """A view of a mesh.

    Attributes
    ----------
    geometry : Geometry
        What is seen.
    view : View
        Who looks. [mm]
    relief : Relief
        Of what is seen, finer than its triangles.
    """

    geometry: Geometry
    view: View
    relief: Relief = SMOOTH

    @cached_property
    def eye(self) -> Array:
        """The eye as a homogeneous point (4,) in the geometry's coordinates."""
        return self.geometry.within(self.view.homogeneous)

    @cached_property
    def frame(self) -> Array:
        """The view (5, 3) in the geometry's coordinates, as compiled loops want it.

        Target, right, up, direction, and distance, side of a pixel and 0.
        """
        view, geometry = self.view, self.geometry
        return np.stack(
            [
                (view.target - geometry.centre) / geometry.scale,
                *(view.right, view.up, view.direction),
                [view.distance / geometry.scale, view.pixel / geometry.scale, 0.0],
            ]
        )

    @cached_property
    def facing(self) -> NDArray[np.bool_]:
        """Which vertices (n,) face the viewer."""
        towards = self.eye[:3] - self.eye[3] * self.geometry.points
        return np.asarray((self.geometry.normals * towards).sum(axis=1) > 0)

    @cached_property
    def places(self) -> Array | None:
        """Columns and rows (n, 2) of the vertices; None if one is beside the eye."""
        view, points = self.view, self.geometry.in_mm
        if np.isfinite(view.distance):
            nearness = 1 - (points - view.target) @ view.direction / view.distance
            if nearness.min() < 1e-3:  # beside or behind the eye, nothing is projected
                return None
        return view.project(points)

    @cached_property
    def front(self) -> NDArray[np.bool_]:
        """Which triangles (m,) turn their outside to the eye."""
        geometry = self.geometry
        return facing_triangles(geometry.points, geometry.faces, self.eye)

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Which vertices (n,) belong to such a triangle: no others can matter."""
        seen = np.zeros(len(self.geometry.points), dtype=np.bool_)
        seen[self.geometry.faces[self.front]] = True
        return seen

    @cached_property
    def outlines(self) -> NDArray[np.bool_]:
        """Which pixels (height, width) an outline of the mesh may cross."""
        width, height = self.view.size
        if self.places is None:
            return np.ones((height, width), dtype=np.bool_)
        edges = self.geometry.edges
        return outline_pixels(self.places, edges, self.front, self.view.size)

    @cached_property
    def blocks(self) -> tuple[int, NDArray[np.bool_]]:
        """A size of blocks of pixels, and which (rows, columns) may show the mesh."""
        width, height = self.view.size
        block = -(-max(width, height) // _BLOCKS)
        marked = np.zeros((-(-height // block), -(-width // block)), dtype=bool)
        if self.places is None:
            marked[:] = True
        else:
            rays.mark_blocks(self.places, self.geometry.faces, block, marked)
        return block, marked
