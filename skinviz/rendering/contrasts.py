"""Compiled loops over pixels that are compared with their neighbours."""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz._compile import compiled, inlined


@inlined
def _difference(one: Any, other: Any) -> Any:
    """Return the square of about ΔE between two cube roots of XYZ over white."""
    x, y, z = one[0] - other[0], one[1] - other[1], one[2] - other[2]
    return (116 * y) ** 2 + (250 * (x - y)) ** 2 + (100 * (y - z)) ** 2


@inlined
def _roots(xyz: Any, white: Any, out: Any) -> None:
    """Write the cube roots of XYZ over white, Y clipped at 1 by scaling."""
    scale = 1 / max(xyz[1], 1.0)
    for i in range(3):
        out[i] = np.cbrt(xyz[i] * scale / white[i]) if xyz[i] > 0 else 0.0


@compiled()
def contrasts(
    xyz: Any,
    rays: Any,
    fewest: Any,
    white: Any,
    limit: Any,
    start: Any,
    stop: Any,
    out: Any,
) -> None:
    """Mark in ``out`` (h, w) the pixels that differ from a neighbour by over ``limit``.

    ``xyz`` is (h, w, 3); only pixels with the fewest ``rays`` (h, w) are looked at,
    the others are as fine as can be; rows from ``start`` to ``stop``, and each with
    the one above it. Differences are about those of ΔE: of lightness, and of chroma
    at half its size, as skin's chroma weighs.
    """
    width = rays.shape[1]
    roots = np.zeros((2, width, 3))
    square = limit * limit
    for row in range(max(start - 1, 0), stop):
        own, above = roots[row % 2], roots[(row + 1) % 2]
        for column in range(width):
            _roots(xyz[row, column], white, own[column])
        if row < start:
            continue
        for column in range(width):
            if rays[row, column] != fewest:
                continue
            left, up = max(column - 1, 0), max(row - 1, 0)
            if (
                rays[row, left] == fewest
                and _difference(own[column], own[left]) > square
            ):
                out[row, column] = out[row, left] = True
            if (
                up < row
                and rays[up, column] == fewest
                and _difference(own[column], above[column]) > square
            ):
                out[row, column] = out[up, column] = True


@compiled()
def neighbour_contrasts(xyz: Any, white: Any, out: Any) -> None:
    """Write how much each pixel differs from its neighbours, as ``contrasts`` does.

    ``xyz`` is (n, k, 3), the pixel itself first; a neighbour that is not to be looked
    at is negative.
    """
    own, other = np.zeros(3), np.zeros(3)
    for at in range(xyz.shape[0]):
        _roots(xyz[at, 0], white, own)
        most = 0.0
        for k in range(1, xyz.shape[1]):
            if xyz[at, k, 1] < 0:
                continue
            _roots(xyz[at, k], white, other)
            most = max(most, _difference(own, other))
        out[at] = np.sqrt(most)
