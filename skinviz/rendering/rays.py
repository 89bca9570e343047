"""Compiled loops over rays: where they start, what they hit, what shades it.

Rays are cast in float32, which decides only *which* triangle is hit; where it is hit
is computed anew in float64. All in the coordinates of ``Geometry``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz._compile import compiled, inlined

_ROUND = 1.8  # a sphere of this radius holds every mesh: more than √3
OFFSET = 1e-5
"""By which rays start above the surface: 100 steps of float32."""

_FARTHEST = 1e10


@inlined
def _ray(view: Any, x: Any, y: Any) -> tuple[float, ...]:
    """Return a point on the ray through (x, y) of the target's plane, and its way.

    ``view`` is (5, 3): target, right, up, direction, and (distance, pixel, 0).
    """
    far = view[4, 0] == np.inf
    px = view[0, 0] + x * view[1, 0] + y * view[2, 0]
    py = view[0, 1] + x * view[1, 1] + y * view[2, 1]
    pz = view[0, 2] + x * view[1, 2] + y * view[2, 2]
    if far:
        return px, py, pz, -view[3, 0], -view[3, 1], -view[3, 2]
    # Away from the eye, formed without it: it may be much farther than the mesh.
    nearness = 1 / view[4, 0]
    dx = (x * view[1, 0] + y * view[2, 0]) * nearness - view[3, 0]
    dy = (x * view[1, 1] + y * view[2, 1]) * nearness - view[3, 1]
    dz = (x * view[1, 2] + y * view[2, 2]) * nearness - view[3, 2]
    scale = 1 / np.sqrt(dx * dx + dy * dy + dz * dz)
    return px, py, pz, dx * scale, dy * scale, dz * scale


@inlined
def _on_plane(view: Any, size: Any, cells: Any, pixel: Any, k: Any) -> tuple[Any, Any]:
    """Return where sample ``k`` of a pixel is seen in the target's plane."""
    column, row = pixel % size[0], pixel // size[0]
    x = (column + cells[k, 0] - 0.5 * size[0]) * view[4, 1]
    y = (0.5 * size[1] - row - cells[k, 1]) * view[4, 1]
    return x, y


@compiled()
def start_rays(
    view: Any, size: Any, cells: Any, pixels: Any, origins: Any, directions: Any
) -> None:
    """Write the rays of pixels (n,), those of one pixel in a row, as float32 (m, 3).

    ``cells`` (samples, 2) are the samples' places in a pixel, from its top left.
    """
    samples = cells.shape[0]
    for i in range(pixels.size):
        for k in range(samples):
            x, y = _on_plane(view, size, cells, pixels[i], k)
            px, py, pz, dx, dy, dz = _ray(view, x, y)
            # From where the ray enters the sphere round the mesh, or from the eye.
            along = -(px * dx + py * dy + pz * dz) - _ROUND
            to_eye = -np.sqrt(view[4, 0] * view[4, 0] + x * x + y * y)
            along = max(along, to_eye)
            j = i * samples + k
            origins[j, 0], directions[j, 0] = px + along * dx, dx
            origins[j, 1], directions[j, 1] = py + along * dy, dy
            origins[j, 2], directions[j, 2] = pz + along * dz, dz


@compiled()
def count_hits(triangles: Any) -> int:
    """Return how many rays hit something."""
    n = 0
    for i in range(triangles.size):
        n += triangles[i] >= 0
    return n


@compiled()
def hit_points(
    triangles: Any,
    view: Any,
    size: Any,
    cells: Any,
    pixels: Any,
    corners: Any,
    faces: Any,
    smooth: Any,
    hits: Any,
    weights: Any,
    points: Any,
    normals: Any,
    lifted: Any,
    facets: Any,
) -> int:
    """Write where rays hit the front of triangles; return how many do.

    Written are ``hits`` (the ray), ``weights`` (3, m) of the triangle's corners,
    ``points``, ``normals`` and ``lifted`` (3, m), from where shadow rays start, and
    ``facets`` (3, m), the triangle's own normal times the root of its longest edge.
    The back of a triangle is the inside of the mesh: it is dark and left out.
    """
    samples = cells.shape[0]
    n = 0
    w = np.zeros(3)
    for j in range(triangles.size):
        if triangles[j] < 0:
            continue
        x, y = _on_plane(view, size, cells, pixels[j // samples], j % samples)
        px, py, pz, dx, dy, dz = _ray(view, x, y)
        face = faces[triangles[j]]
        gx, gy, gz = _facet(corners, face)
        if gx * dx + gy * dy + gz * dz >= 0:
            continue
        _weigh(corners, face, px, py, pz, dx, dy, dz, w)
        hits[n] = j
        for i in range(3):
            weights[i, n] = w[i]
        _settle(corners, smooth, face, w, gx, gy, gz, n, points, normals, lifted)
        root = _root_of_edge(corners, face)
        facets[0, n], facets[1, n], facets[2, n] = gx * root, gy * root, gz * root
        n += 1
    return n


@inlined
def _facet(corners: Any, face: Any) -> tuple[float, float, float]:
    """Return a triangle's unit normal, 0 where it has no area."""
    a, b, c = face[0], face[1], face[2]
    ux, uy, uz = (
        corners[b, 0] - corners[a, 0],
        corners[b, 1] - corners[a, 1],
        corners[b, 2] - corners[a, 2],
    )
    vx, vy, vz = (
        corners[c, 0] - corners[a, 0],
        corners[c, 1] - corners[a, 1],
        corners[c, 2] - corners[a, 2],
    )
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    scale = 1 / length if length > 0 else 0.0
    return nx * scale, ny * scale, nz * scale


@inlined
def _root_of_edge(corners: Any, face: Any) -> float:
    """Return the square root of a triangle's longest edge."""
    longest = 0.0
    for i in range(3):
        a, b = corners[face[i]], corners[face[(i + 1) % 3]]
        x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        longest = max(longest, x * x + y * y + z * z)
    return float(np.sqrt(np.sqrt(longest)))


@inlined
def _weigh(
    corners: Any,
    face: Any,
    px: Any,
    py: Any,
    pz: Any,
    dx: Any,
    dy: Any,
    dz: Any,
    w: Any,
) -> None:
    """Write the weights of the corners where a ray's line crosses a triangle.

    Each is the volume that the ray spans with the opposite edge. One that float32
    has hit just beside its triangle is taken to its edge.
    """
    total = 0.0
    for i in range(3):
        b, c = face[(i + 1) % 3], face[(i + 2) % 3]
        ux, uy, uz = corners[b, 0] - px, corners[b, 1] - py, corners[b, 2] - pz
        vx, vy, vz = corners[c, 0] - px, corners[c, 1] - py, corners[c, 2] - pz
        volume = (
            dx * (uy * vz - uz * vy)
            + dy * (uz * vx - ux * vz)
            + dz * (ux * vy - uy * vx)
        )
        w[i] = max(-volume, 0.0)
        total += w[i]
    for i in range(3):
        w[i] = w[i] / total if total > 0 else 1 / 3


@inlined
def _settle(
    corners: Any,
    smooth: Any,
    face: Any,
    w: Any,
    gx: Any,
    gy: Any,
    gz: Any,
    n: Any,
    points: Any,
    normals: Any,
    lifted: Any,
) -> None:
    """Write the point with these weights, its smooth normal, and its lifted twin.

    A shadow ray from a flat triangle would meet its neighbours where the smooth
    surface is still lit (the terminator of coarse meshes). It starts from the smooth
    surface instead: the mean of the point's images on the corners' tangent planes
    (Hanika, Ray Tracing Gems II (2021), ch. 4).
    """
    px = py = pz = nx = ny = nz = 0.0
    for i in range(3):
        p, s = corners[face[i]], smooth[face[i]]
        px, py, pz = px + w[i] * p[0], py + w[i] * p[1], pz + w[i] * p[2]
        nx, ny, nz = nx + w[i] * s[0], ny + w[i] * s[1], nz + w[i] * s[2]
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length < 1e-6:  # the corners' normals cancel
        nx, ny, nz, length = gx, gy, gz, 1.0
    points[0, n], points[1, n], points[2, n] = px, py, pz
    normals[0, n], normals[1, n], normals[2, n] = nx / length, ny / length, nz / length
    lx, ly, lz = px + OFFSET * gx, py + OFFSET * gy, pz + OFFSET * gz
    for i in range(3):
        p, s = corners[face[i]], smooth[face[i]]
        below = (px - p[0]) * s[0] + (py - p[1]) * s[1] + (pz - p[2]) * s[2]
        rise = -w[i] * min(below, 0.0)
        lx, ly, lz = lx + rise * s[0], ly + rise * s[1], lz + rise * s[2]
    lifted[0, n], lifted[1, n], lifted[2, n] = lx, ly, lz


@compiled()
def shadow_rays(
    lifted: Any,
    normals: Any,
    facets: Any,
    light: Any,
    asked: Any,
    origins: Any,
    directions: Any,
    lengths: Any,
) -> int:
    """Write rays towards a light from the points that face it; return how many do.

    ``asked`` are these points; rays end at the light. Where the smooth surface faces
    the light and the triangle does not, the ray starts higher by what the triangle
    itself hides: else it would be a black spot in a lit valley.
    """
    n = 0
    for i in range(lifted.shape[1]):
        x, y, z = lifted[0, i], lifted[1, i], lifted[2, i]
        dx, dy, dz = (
            light[0] - light[3] * x,
            light[1] - light[3] * y,
            light[2] - light[3] * z,
        )
        if normals[0, i] * dx + normals[1, i] * dy + normals[2, i] * dz <= 0:
            continue
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        gx, gy, gz = facets[0, i], facets[1, i], facets[2, i]
        rise = max(-(gx * dx + gy * dy + gz * dz) / length, 0.0)
        asked[n] = i
        origins[n, 0], origins[n, 1] = x + rise * gx, y + rise * gy
        origins[n, 2] = z + rise * gz
        directions[n, 0] = dx / length
        directions[n, 1] = dy / length
        directions[n, 2] = dz / length
        lengths[n] = min(length, _FARTHEST) if light[3] != 0 else _FARTHEST
        n += 1
    return n


@compiled()
def interpolate(hits: Any, faces: Any, weights: Any, fields: Any, out: Any) -> None:
    """Write fields (n, e), given at vertices, at points of triangles ``hits``."""
    for j in range(hits.size):
        face = faces[hits[j]]
        for i in range(out.shape[0]):
            out[i, j] = (
                weights[0, j] * fields[face[0], i]
                + weights[1, j] * fields[face[1], i]
                + weights[2, j] * fields[face[2], i]
            )


@compiled()
def interpolate_rows(hits: Any, faces: Any, weights: Any, rows: Any, out: Any) -> None:
    """Write rows (n, c), given at vertices, at points of triangles ``hits``: (m, c)."""
    for j in range(hits.size):
        face = faces[hits[j]]
        a, b, c = rows[face[0]], rows[face[1]], rows[face[2]]
        for i in range(out.shape[1]):
            out[j, i] = (
                weights[0, j] * a[i] + weights[1, j] * b[i] + weights[2, j] * c[i]
            )


@compiled()
def mark_blocks(places: Any, faces: Any, block: Any, marked: Any) -> None:
    """Mark the blocks of pixels that the box round any triangle touches.

    ``places`` (n, 2) are the vertices' columns and rows; ``marked`` is (rows, columns)
    of blocks, each ``block`` pixels a side.
    """
    rows, columns = marked.shape
    left_out = marked.size
    for f in range(faces.shape[0]):
        if left_out == 0:
            break
        a, b, c = places[faces[f, 0]], places[faces[f, 1]], places[faces[f, 2]]
        left = np.floor(min(a[0], b[0], c[0]) / block - 0.01)
        right = np.floor(max(a[0], b[0], c[0]) / block + 0.01)
        top = np.floor(min(a[1], b[1], c[1]) / block - 0.01)
        bottom = np.floor(max(a[1], b[1], c[1]) / block + 0.01)
        for row in range(int(max(top, 0)), int(min(bottom, rows - 1)) + 1):
            for column in range(int(max(left, 0)), int(min(right, columns - 1)) + 1):
                left_out -= not marked[row, column]
                marked[row, column] = True


@compiled()
def hemispheres(
    points: Any, normals: Any, local: Any, origins: Any, directions: Any
) -> None:
    """Write rays from points (n, 3) in the directions ``local`` (k, 3) about normals.

    References
    ----------
    .. [1] Duff et al., J. Comput. Graph. Tech. 6(1):1 (2017): right-angled axes.
    """
    k = local.shape[0]
    for i in range(points.shape[0]):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        sign = 1.0 if z >= 0 else -1.0
        a = -1 / (sign + z)
        b = x * y * a
        px, py, pz = (
            points[i, 0] + OFFSET * x,
            points[i, 1] + OFFSET * y,
            points[i, 2] + OFFSET * z,
        )
        for j in range(k):
            u, v, w = local[j, 0], local[j, 1], local[j, 2]
            at = i * k + j
            origins[at, 0], origins[at, 1], origins[at, 2] = px, py, pz
            directions[at, 0] = u * (1 + sign * x * x * a) + v * b + w * x
            directions[at, 1] = u * (sign * b) + v * (sign + y * y * a) + w * y
            directions[at, 2] = u * (-sign * x) - v * y + w * z


@compiled()
def gather(
    triangles: Any,
    second: Any,
    third: Any,
    facets: Any,
    directions: Any,
    faces: Any,
    leaving: Any,
    out: Any,
) -> None:
    """Write the mean over each point's rays of the light that leaves what they meet.

    ``second`` and ``third`` are the weights of a triangle's corners, ``facets`` its
    normals (m, 3); the back of a triangle sends nothing. ``leaving`` is (n, e) of
    vertices, ``out`` (points, e).
    """
    k = triangles.size // max(out.shape[0], 1)
    for at in range(triangles.size):
        if triangles[at] < 0:
            continue
        towards = (
            facets[at, 0] * directions[at, 0]
            + facets[at, 1] * directions[at, 1]
            + facets[at, 2] * directions[at, 2]
        )
        if towards >= 0:
            continue
        face = faces[triangles[at]]
        q, r = max(second[at] / k, 0.0), max(third[at] / k, 0.0)
        p = max(1 / k - q - r, 0.0)
        a, b, c = leaving[face[0]], leaving[face[1]], leaving[face[2]]
        row = out[at // k]
        for e in range(row.size):
            row[e] += p * a[e] + q * b[e] + r * c[e]
