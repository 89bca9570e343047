"""From pixels to what their rays see: points of the skin and the light there."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering import rays
from skinviz.rendering.engraving import engrave
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.lighting import Lighting
from skinviz.rendering.sight import Sight

Array = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Hits:
    """What the rays of some pixels hit, each hit on the mesh's outside.

    Attributes
    ----------
    rays : (m,) ndarray
        Which of the rays each hit is of, ascending, those of a pixel in a row.
    pixels : (m,) ndarray
        Which of the pixels asked for each hit belongs to, ascending.
    triangles : (m,) ndarray
        What is hit.
    weights : (3, m) ndarray
        Of the triangle's corners at the point.
    points, normals : (3, m) ndarray
        The point, in the geometry's coordinates, and its unit normal: the smooth one,
        tilted by the scene's relief.
    lifted : (3, m) ndarray
        Where shadow rays of the point start.
    facets : (3, m) ndarray
        Normal of the triangle itself, times the root of its longest edge.
    covered : (pixels,) ndarray of uint8
        How many rays of each pixel hit the mesh at all.
    """

    rays: Whole
    pixels: Whole
    triangles: NDArray[np.int32]
    weights: Array
    points: Array
    normals: Array
    lifted: Array
    facets: Array
    covered: NDArray[np.uint8]

    def part(self, which: slice | Whole) -> Hits:
        """Return some of the hits (k,), as pixels 0 to k - 1 of one ray each."""
        k = self.rays[which].size

        def columns(values: Array) -> Array:
            return np.ascontiguousarray(values[:, which])

        return Hits(
            rays=np.arange(k),
            pixels=np.arange(k),
            triangles=self.triangles[which],
            weights=columns(self.weights),
            points=columns(self.points),
            normals=columns(self.normals),
            lifted=columns(self.lifted),
            facets=columns(self.facets),
            covered=np.ones(k, dtype=np.uint8),
        )

    def apart(self, n_rays: int) -> Hits:
        """Return the hits with each of the ``n_rays`` cast as a pixel of its own.

        Only those that hit the mesh's outside count as covered.
        """
        covered = np.zeros(n_rays, dtype=np.uint8)
        covered[self.rays] = 1
        return dataclasses.replace(self, pixels=self.rays, covered=covered)


def cast(sight: Sight, places: Array, pixels: Whole) -> Hits:
    """Cast the rays of pixels.

    Parameters
    ----------
    sight : Sight
        Who looks at what.
    places : (samples, 2) ndarray
        Of the rays in a pixel. [pixels]
    pixels : (k,) ndarray of int64
        Row × width + column.
    """
    geometry, frame, size = sight.geometry, sight.frame, np.array(sight.view.size)
    n = pixels.size * len(places)
    origins, directions = (np.zeros((n, 3), dtype=np.float32) for _ in range(2))
    rays.start_rays(frame, size, places, pixels, origins, directions)
    triangles = geometry.embree.run(origins, directions, query="INTERSECT")
    m = rays.count_hits(triangles)
    hit = np.zeros(m, dtype=np.int64)
    weights, points, normals, lifted, facets = np.zeros((5, 3, m))
    m = rays.hit_points(
        *(triangles, frame, size, places, pixels),
        *(geometry.points, geometry.faces, geometry.normals),
        *(hit, weights, points, normals, lifted, facets),
    )
    points, normals = (np.ascontiguousarray(x[:, :m]) for x in (points, normals))
    _engrave(sight, points, normals)
    shape = (pixels.size, len(places))
    covered = (triangles >= 0).reshape(shape).sum(axis=1, dtype=np.uint8)
    return Hits(
        hit[:m],
        hit[:m] // len(places),
        triangles[hit[:m]],
        np.ascontiguousarray(weights[:, :m]),
        points,
        normals,
        np.ascontiguousarray(lifted[:, :m]),
        np.ascontiguousarray(facets[:, :m]),
        covered,
    )


def _engrave(sight: Sight, points: Array, normals: Array) -> None:
    """Tilt the normals (3, m) of points as the relief has it; nothing if it is flat."""
    relief, geometry = sight.relief, sight.geometry
    if relief.depth > 0:
        depth = 1e-3 * relief.depth / relief.spacing  # both in mm
        start, step = geometry.centre / relief.spacing, geometry.scale / relief.spacing
        engrave(points, normals, start, step, depth, relief.seed)


def joined(parts: list[Hits], samples: int) -> Hits:
    """Return the hits of pixels that were cast in parts, with so many samples each."""
    first = np.cumsum([0, *(part.covered.size for part in parts)])

    def columns(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts], axis=1)

    pixels = [part.pixels + n for part, n in zip(parts, first, strict=False)]
    rays = [part.rays + samples * n for part, n in zip(parts, first, strict=False)]
    return Hits(
        rays=np.concatenate(rays),
        pixels=np.concatenate(pixels),
        triangles=np.concatenate([part.triangles for part in parts]),
        weights=columns("weights"),
        points=columns("points"),
        normals=columns("normals"),
        lifted=columns("lifted"),
        facets=columns("facets"),
        covered=np.concatenate([part.covered for part in parts]),
    )


def visibility(
    geometry: Geometry,
    lighting: Lighting,
    lifted: Array,
    normals: Array,
    facets: Array,
) -> NDArray[np.uint8]:
    """Return which lights (n_lights, n) nothing hides from points (3, n).

    Parameters
    ----------
    geometry : Geometry
        What may stand between.
    lighting : Lighting
        The lights.
    lifted, normals, facets : (3, n) ndarray
        Where shadow rays start; the normals of the points; as in :class:`Hits`.

    Returns
    -------
    visible : (n_lights, n) ndarray of uint8
        0 also where the point faces away from the light.
    """
    n = lifted.shape[1]
    visible = np.zeros((len(lighting.lights), n), dtype=np.uint8)
    origins, directions = (np.zeros((n, 3), dtype=np.float32) for _ in range(2))
    lengths, asked = np.zeros(n, dtype=np.float32), np.zeros(n, dtype=np.int64)
    for seen, light in zip(visible, lighting.lights, strict=True):
        m = rays.shadow_rays(
            lifted, normals, facets, light, asked, origins, directions, lengths
        )
        hidden: Any = geometry.embree.run(
            origins[:m], directions[:m], query="OCCLUDED", dists=lengths[:m]
        )
        seen[asked[:m]] = hidden < 0
    return visible


def visibility_of(
    geometry: Geometry, lighting: Lighting, hits: Hits
) -> NDArray[np.uint8]:
    """Return which lights (n_lights, m) nothing hides from points that are hit."""
    return visibility(geometry, lighting, hits.lifted, hits.normals, hits.facets)


def vertex_visibility(geometry: Geometry, lighting: Lighting) -> NDArray[np.uint8]:
    """Return which lights (n_lights, n) nothing hides from the vertices."""
    points, normals = geometry.components
    lifted = points + rays.OFFSET * normals
    return visibility(geometry, lighting, lifted, normals, np.zeros_like(points))


def at_corners(geometry: Geometry, hits: Hits, fields: Array) -> Array:
    """Return fields (n, e), given at the vertices, at the points hit: (e, m)."""
    out = np.zeros((fields.shape[1], hits.triangles.size))
    rays.interpolate(hits.triangles, geometry.faces, hits.weights, fields, out)
    return out
