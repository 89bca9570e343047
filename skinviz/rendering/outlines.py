"""Which pixels an outline of the mesh crosses: there, and only there, do rays differ.

What a pixel's rays hit changes from one surface to another, or to none, only across
the picture of an edge between a triangle that faces the eye and one that does not, or
of an open edge.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._compile import compiled, inlined

_MARGIN = 0.02  # pixels, by which float32 rays may miss


def outline_pixels(
    places: NDArray[np.float64],
    edges: NDArray[np.int32],
    facing: NDArray[np.bool_],
    size: tuple[int, int],
) -> NDArray[np.bool_]:
    """Return which pixels (height, width) an outline may cross.

    Parameters
    ----------
    places : (n, 2) ndarray
        Columns and rows of the vertices.
    edges : (k, 4) ndarray
        From :func:`edges_of`.
    facing : (m,) ndarray
        Which triangles face the eye.
    size : (int, int)
        Width and height. [pixels]
    """
    width, height = size
    marked = np.zeros((height, width), dtype=np.bool_)
    _mark(places, edges, facing, _MARGIN, marked)
    return marked


def edges_of(faces: NDArray[np.int32], n_vertices: int) -> NDArray[np.int32]:
    """Return the edges (k, 4) of triangles: two vertices, and the triangles beside.

    The last is -1 at an open edge; where more than two triangles meet, each further
    one has a row of its own with -1.
    """
    counts = np.zeros(n_vertices + 1, dtype=np.int64)
    table = np.zeros((3 * len(faces), 4), dtype=np.int32)
    k = _join(faces, counts, table)
    return table[:k]


def facing_triangles(
    points: NDArray[np.float64], faces: NDArray[np.int32], eye: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return which triangles (m,) face a homogeneous eye (4,)."""
    out = np.zeros(len(faces), dtype=np.bool_)
    _face(points, faces, eye, out)
    return out


@compiled()
def _face(points: Any, faces: Any, eye: Any, out: Any) -> None:
    """Write which triangles face the eye; those without an area do not."""
    for f in range(faces.shape[0]):
        a, b, c = points[faces[f, 0]], points[faces[f, 1]], points[faces[f, 2]]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        out[f] = (
            (uy * vz - uz * vy) * (eye[0] - eye[3] * a[0])
            + (uz * vx - ux * vz) * (eye[1] - eye[3] * a[1])
            + (ux * vy - uy * vx) * (eye[2] - eye[3] * a[2])
        ) > 0


@inlined
def _place(table: Any, first: Any, end: Any, high: Any) -> int:
    """Return where in a bucket an edge to ``high`` lacks a triangle, or the end."""
    for at in range(first, end):
        if table[at, 1] == high and table[at, 3] < 0:
            return int(at)
    return int(end)


@inlined
def _close_up(table: Any, starts: Any, ends: Any) -> int:
    """Move what the buckets hold together; return how much it is."""
    k = 0
    for v in range(starts.size - 1):
        for at in range(starts[v], ends[v]):
            table[k] = table[at]
            k += 1
    return k


@compiled()
def _join(faces: Any, counts: Any, table: Any) -> int:
    """Write each edge once, bucketed by its lower vertex; return how many there are.

    ``counts`` (vertices + 1) are zeros, and become where the buckets begin.
    """
    for f in range(faces.shape[0]):
        for i in range(3):
            counts[min(faces[f, i], faces[f, (i + 1) % 3]) + 1] += 1
    for v in range(1, counts.size):
        counts[v] += counts[v - 1]
    ends = counts.copy()  # how far each bucket is filled
    for f in range(faces.shape[0]):
        for i in range(3):
            a, b = faces[f, i], faces[f, (i + 1) % 3]
            low, high = min(a, b), max(a, b)
            at = _place(table, counts[low], ends[low], high)
            if at < ends[low]:
                table[at, 3] = f
            else:
                table[at, 0], table[at, 1], table[at, 2], table[at, 3] = (
                    low,
                    high,
                    f,
                    -1,
                )
                ends[low] += 1
    return int(_close_up(table, counts, ends))


@compiled()
def _mark(places: Any, edges: Any, facing: Any, margin: Any, marked: Any) -> None:
    """Mark the pixels that edges cross at which facing changes."""
    height, width = marked.shape
    for e in range(edges.shape[0]):
        f, g = edges[e, 2], edges[e, 3]
        if g >= 0 and facing[f] == facing[g]:
            continue
        x0, y0 = places[edges[e, 0], 0], places[edges[e, 0], 1]
        x1, y1 = places[edges[e, 1], 0], places[edges[e, 1], 1]
        if y0 > y1:
            x0, y0, x1, y1 = x1, y1, x0, y0
        top = max(np.floor(y0 - margin), 0.0)
        bottom = min(np.floor(y1 + margin), height - 1.0)
        slope = (x1 - x0) / (y1 - y0) if y1 > y0 else 0.0
        row = int(top)
        while row <= bottom:
            # Where the edge is while it crosses this row.
            a = min(max(row - margin, y0), y1)
            b = max(min(row + 1 + margin, y1), y0)
            left, right = x0 + (a - y0) * slope, x0 + (b - y0) * slope
            if y1 - y0 < 2 * margin:  # it lies in the row
                left, right = x0, x1
            left, right = min(left, right) - margin, max(left, right) + margin
            if right >= 0 and left < width:
                for column in range(
                    int(max(left, 0.0)), int(min(right, width - 1.0)) + 1
                ):
                    marked[row, column] = True
            row += 1
