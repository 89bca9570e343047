"""A compiled loop that tilts normals as fine relief has them."""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz._compile import compiled
from skinviz.scene.kernels import ridges

FURROW = 0.25
"""Of a furrow, from its middle to where it is down to 1/e, in cells."""


@compiled()
def engrave(
    points: Any, normals: Any, start: Any, step: Any, depth: Any, seed: Any
) -> None:
    """Tilt normals (3, n) as the sides of furrows between cells are, where points are.

    In units of the cells, a point p is at ``start`` + ``step`` p, and the surface is
    lower than it was by depth · exp(−(e/w)²), e the distance to the second nearest
    cell's point less that to the nearest.
    """
    slope = np.zeros(3)
    for i in range(points.shape[1]):
        x, y, z = (
            start[0] + step * points[0, i],
            start[1] + step * points[1, i],
            start[2] + step * points[2, i],
        )
        ratio = ridges(x, y, z, seed, slope) / FURROW
        rise = 2 * depth / FURROW * ratio * np.exp(-ratio * ratio)
        a, b, c = normals[0, i], normals[1, i], normals[2, i]
        up = slope[0] * a + slope[1] * b + slope[2] * c
        # The gradient of the height within the surface, taken off the normal.
        a, b, c = (
            a - rise * (slope[0] - up * a),
            b - rise * (slope[1] - up * b),
            c - rise * (slope[2] - up * c),
        )
        scale = 1 / np.sqrt(a * a + b * b + c * c)
        normals[0, i], normals[1, i], normals[2, i] = a * scale, b * scale, c * scale
