"""Compiled loops over points: geometry's scalars, and their expansion into spectra.

Radiance is a sum of scalars that depend on geometry alone times spectra that do
not depend on the point:

    Y(λ) = Σ_lights [ α (N·L) · R(λ) E(λ)  +  spread · F(n(λ)) · E(λ) ]

``scalars`` fills in those of lights, ``expand`` the products. Vectors are (3, n),
because loops over points then read each component in a row. Lights and the eye are
homogeneous points: (x, y, z, 1), or (x, y, z, 0) in a direction.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from skinviz._compile import compiled, inlined
from skinviz.surface.kernels import LOBE, fresnel

BLOCK = 256
"""Points that are worked on together, so that all of theirs stays near."""

_VECTOR, _MATRIX = types.float64[::1], types.float64[:, ::1]
_CHUNK = 1024  # vertices whose scalars are kept at once
_LEAST = 1e-300  # added to squares whose root divides: 0 stays 0, never 0/0


# Rows of a block's scratch, flat so that loops over it are seen not to overlap.
_NL, _NV, _NH, _SH, _VH, _FALL, _OUT, _END = (BLOCK * row for row in range(8))


@inlined
def _cosines(
    points: Any, normals: Any, start: Any, n: Any, to: Any, reach: Any, rows: Any
) -> None:
    """Fill in N·L, N·V, N·H, |N × H|, V·H and the fall-off with distance.

    ``to`` are the light and the eye, four numbers each.
    """
    stop = start + n
    X, Y, Z = points[0, start:stop], points[1, start:stop], points[2, start:stop]
    A, B, C = normals[0, start:stop], normals[1, start:stop], normals[2, start:stop]
    lx, ly, lz, lw, ex, ey, ez, ew = to
    for i in range(n):
        x, y, z = X[i], Y[i], Z[i]
        a, b, c = lx - lw * x, ly - lw * y, lz - lw * z
        d, e, f = ex - ew * x, ey - ew * y, ez - ew * z
        square = a * a + b * b + c * c + _LEAST
        scale = 1 / np.sqrt(square)
        a, b, c = a * scale, b * scale, c * scale
        scale = 1 / np.sqrt(d * d + e * e + f * f + _LEAST)
        d, e, f = d * scale, e * scale, f * scale
        rows[_NL + i] = A[i] * a + B[i] * b + C[i] * c
        rows[_NV + i] = A[i] * d + B[i] * e + C[i] * f
        a, b, c = a + d, b + e, c + f
        length = np.sqrt(a * a + b * b + c * c)
        scale = 1 / (length + _LEAST)
        a, b, c = a * scale, b * scale, c * scale
        rows[_VH + i] = min(0.5 * length, 1.0)
        rows[_NH + i] = A[i] * a + B[i] * b + C[i] * c
        d, e, f = B[i] * c - C[i] * b, C[i] * a - A[i] * c, A[i] * b - B[i] * a
        rows[_SH + i] = np.sqrt(d * d + e * e + f * f)
        rows[_FALL + i] = lw * (reach / square) + (1 - lw)


@inlined
def _far_cosines(normals: Any, start: Any, n: Any, to: Any, rows: Any) -> None:
    """Fill in the same where light and eye are far: H is the same everywhere."""
    stop = start + n
    A, B, C = normals[0, start:stop], normals[1, start:stop], normals[2, start:stop]
    lx, ly, lz, _, ex, ey, ez, _ = to
    hx, hy, hz = lx + ex, ly + ey, lz + ez
    length = np.sqrt(hx * hx + hy * hy + hz * hz)
    scale = 1 / (length + _LEAST)
    hx, hy, hz = hx * scale, hy * scale, hz * scale
    VH = min(0.5 * length, 1.0)
    for i in range(n):
        a, b, c = A[i], B[i], C[i]
        x, y, z = b * hz - c * hy, c * hx - a * hz, a * hy - b * hx
        rows[_NL + i] = a * lx + b * ly + c * lz
        rows[_NV + i] = a * ex + b * ey + c * ez
        rows[_NH + i] = a * hx + b * hy + c * hz
        rows[_SH + i] = np.sqrt(x * x + y * y + z * z)
        rows[_VH + i] = VH
        rows[_FALL + i] = 1.0


@inlined
def _fill(
    points: Any, normals: Any, start: Any, n: Any, to: Any, reach: Any, rows: Any
) -> None:
    """Fill in the cosines by the quicker way that holds."""
    if to[3] == 0 and to[7] == 0:
        _far_cosines(normals, start, n, to, rows)
    else:
        _cosines(points, normals, start, n, to, reach, rows)


@compiled(
    types.void(
        *(_MATRIX, _MATRIX, types.int64, _MATRIX, _VECTOR, _VECTOR),
        *(LOBE, _VECTOR, _VECTOR, types.uint8[:, ::1], _MATRIX),
    )
)
def scalars(
    points: Any,
    normals: Any,
    start: Any,
    lights: Any,
    reaches: Any,
    eye: Any,
    lobe: Any,
    constants: Any,
    indices: Any,
    visible: Any,
    out: Any,
) -> None:
    """Write what each light gives each point.

    ``out`` is (lights (1 + indices) + more, n): max(N·L, 0) of each light, then for
    each light the specular scalar at each refractive index. ``points`` and
    ``normals`` are read from ``start`` on; ``visible`` is (lights, n), or (0, 0)
    where every light is seen. ``reaches`` are the squared distances at which a near
    light's irradiance is 1.
    """
    n, n_lights, n_indices = out.shape[1], lights.shape[0], indices.size
    rows = np.zeros(_END)
    for first in range(0, n, BLOCK):
        m = min(BLOCK, n - first)
        NL, NV, NH = rows[_NL : _NL + m], rows[_NV : _NV + m], rows[_NH : _NH + m]
        SH, VH, spread = rows[_SH : _SH + m], rows[_VH : _VH + m], rows[_OUT : _OUT + m]
        fall = rows[_FALL : _FALL + m]
        for k in range(n_lights):
            light = lights[k]
            to = (
                *(light[0], light[1], light[2], light[3]),
                *(eye[0], eye[1], eye[2], eye[3]),
            )
            _fill(points, normals, start + first, m, to, reaches[k], rows)
            lobe(NL, NV, NH, SH, VH, constants, spread)
            if visible.size:
                seen = visible[k, first : first + m]
                for i in range(m):
                    fall[i] *= seen[i]
            lit = out[k, first : first + m]
            for i in range(m):
                lit[i] = max(NL[i], 0.0) * fall[i]
            for j in range(n_indices):
                index = indices[j]
                shine = out[n_lights + k * n_indices + j, first : first + m]
                for i in range(m):
                    shine[i] = spread[i] * fall[i] * fresnel(VH[i], index)


@inlined
def _products(mean: Any, spectra: Any, row: Any) -> None:
    """Write the sum of scalars times spectra, two at a time to save stores; k > 0."""
    k = mean.size
    odd = k % 2
    if odd:
        for j in range(row.size):
            row[j] = mean[0] * spectra[0, j]
    else:
        for j in range(row.size):
            row[j] = mean[0] * spectra[0, j] + mean[1] * spectra[1, j]
    for i in range(2 - odd, k, 2):
        if mean[i] != 0 or mean[i + 1] != 0:
            for j in range(row.size):
                row[j] += mean[i] * spectra[i, j] + mean[i + 1] * spectra[i + 1, j]


@compiled(
    types.void(
        *(_MATRIX, _MATRIX, types.int64, _MATRIX, _VECTOR, _VECTOR),
        *(LOBE, _VECTOR, _VECTOR, types.uint8[:, ::1], _MATRIX),
        *(types.float32[:, ::1], types.float32[:, ::1], _VECTOR),
    )
)
def expand_vertices(
    points: Any,
    normals: Any,
    start: Any,
    lights: Any,
    reaches: Any,
    eye: Any,
    lobe: Any,
    constants: Any,
    indices: Any,
    visible: Any,
    fields: Any,
    spectra: Any,
    out: Any,
    peaks: Any,
) -> None:
    """Write what :func:`scalars` says of points, and their fields, times spectra.

    ``fields`` is (n, e), ``spectra`` (k, bands), ``out`` (n, bands); ``peaks`` (k,) are
    made the largest of each scalar. Few points at a time: while the memory takes the
    spectra of some, the scalars of the next are computed.
    """
    n, k = out.shape[0], spectra.shape[0]
    rows = k - fields.shape[1]
    own = np.zeros(k, dtype=np.float32)
    values = np.zeros((k, _CHUNK))
    for first in range(0, n, _CHUNK):
        m = min(_CHUNK, n - first)
        if m < _CHUNK:
            values = np.zeros((k, m))
        seen = visible[:, first : first + m].copy()
        # One by one: numba warns of tuples that begin with a function.
        scalars(
            points,
            normals,
            start + first,
            lights,
            reaches,
            eye,
            lobe,
            constants,
            indices,
            seen,
            values,
        )
        for j in range(rows, k):
            for i in range(m):
                values[j, i] = fields[first + i, j - rows]
        for j in range(k):
            peaks[j] = max(peaks[j], values[j].max())
        for i in range(m):
            for j in range(k):
                own[j] = values[j, i]
            _products(own, spectra, out[first + i])


@compiled()
def expand(pixels: Any, samples: Any, values: Any, spectra: Any, out: Any) -> None:
    """Write the mean over each pixel's samples of ``values`` times ``spectra``.

    ``pixels`` (m,) says, ascending, to which row of ``out`` (n, bands) each column of
    ``values`` (k, m) belongs; ``spectra`` is (k, bands). Rows without any are 0.
    """
    k = spectra.shape[0]
    mean = np.zeros(k, dtype=spectra.dtype)
    at, m, share = 0, pixels.size, 1 / samples
    for row in range(out.shape[0]):
        if at == m or pixels[at] != row:
            out[row, :] = 0
            continue
        for i in range(k):
            mean[i] = values[i, at] * share
        at += 1
        while at < m and pixels[at] == row:
            for i in range(k):
                mean[i] += values[i, at] * share
            at += 1
        _products(mean, spectra, out[row])


@compiled()
def expand_mapped(
    pixels: Any,
    samples: Any,
    lit: Any,
    light: Any,
    gloss: Any,
    shine: Any,
    body: Any,
    out: Any,
) -> None:
    """Write the mean over each pixel's samples where each has its own reflectance.

    As :func:`expand`, of body ⊙ (lit · light) + gloss · shine: ``body`` is (m,
    bands), ``lit`` (g, m) goes with ``light`` (g, bands), ``gloss`` (h, m) with
    ``shine`` (h, bands).
    """
    bands = out.shape[1]
    sums = np.zeros((3, bands))
    at, m = 0, pixels.size
    for row in range(out.shape[0]):
        sums[0, :] = 0
        while at < m and pixels[at] == row:
            _products(lit[:, at], light, sums[1])
            if gloss.shape[0] > 0:  # or the surface reflects nothing
                _products(gloss[:, at], shine, sums[2])
            for j in range(bands):
                # Fields of few spectra may be below 0 by their rounding.
                sums[0, j] += body[at, j] * max(sums[1, j], 0.0) + sums[2, j]
            at += 1
        for j in range(bands):
            out[row, j] = sums[0, j] / samples


@compiled()
def expand_tinted(
    pixels: Any,
    samples: Any,
    lit: Any,
    tints: Any,
    gloss: Any,
    shine: Any,
    out: Any,
) -> None:
    """Write the mean XYZ over each pixel's samples where each has its own reflectance.

    As :func:`expand`: ``lit`` is (g, m), ``tints`` (m, 3 g) what each of these gives
    in XYZ at the sample's skin, ``gloss`` (h, m) goes with ``shine`` (h, 3).
    """
    at, m, share = 0, pixels.size, 1 / samples
    n_lit, n_gloss = lit.shape[0], gloss.shape[0]
    for row in range(out.shape[0]):
        x = y = z = 0.0
        while at < m and pixels[at] == row:
            u = v = w = 0.0
            for i in range(n_lit):
                u += lit[i, at] * tints[at, 3 * i]
                v += lit[i, at] * tints[at, 3 * i + 1]
                w += lit[i, at] * tints[at, 3 * i + 2]
            # Fields of few spectra may be below 0 by their rounding.
            x, y, z = x + max(u, 0.0), y + max(v, 0.0), z + max(w, 0.0)
            for i in range(n_gloss):
                x += gloss[i, at] * shine[i, 0]
                y += gloss[i, at] * shine[i, 1]
                z += gloss[i, at] * shine[i, 2]
            at += 1
        out[row, 0], out[row, 1], out[row, 2] = x * share, y * share, z * share
