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
_LEAST = 1e-300  # added to squares whose root divides: 0 stays 0, never 0/0


@inlined
def _towards(x: Any, y: Any, z: Any, to: Any) -> tuple[float, float, float, float]:
    """Return the unit vector from a point to a homogeneous one, and its distance²."""
    dx, dy, dz = to[0] - to[3] * x, to[1] - to[3] * y, to[2] - to[3] * z
    square = dx * dx + dy * dy + dz * dz + _LEAST
    scale = 1 / np.sqrt(square)
    return dx * scale, dy * scale, dz * scale, square


@inlined
def _cosines(
    points: Any,
    normals: Any,
    start: Any,
    n: Any,
    light: Any,
    reach: Any,
    eye: Any,
    rows: Any,
) -> None:
    """Fill in N·L, N·V, N·H, |N × H|, V·H and the fall-off with distance."""
    NL, NV, NH, SH, VH, fall = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    for i in range(n):
        x, y, z = points[0, start + i], points[1, start + i], points[2, start + i]
        nx, ny, nz = normals[0, start + i], normals[1, start + i], normals[2, start + i]
        lx, ly, lz, square = _towards(x, y, z, light)
        vx, vy, vz, _ = _towards(x, y, z, eye)
        hx, hy, hz = lx + vx, ly + vy, lz + vz
        length = np.sqrt(hx * hx + hy * hy + hz * hz)
        scale = 1 / (length + _LEAST)
        hx, hy, hz = hx * scale, hy * scale, hz * scale
        cx, cy, cz = ny * hz - nz * hy, nz * hx - nx * hz, nx * hy - ny * hx
        NL[i] = nx * lx + ny * ly + nz * lz
        NV[i] = nx * vx + ny * vy + nz * vz
        NH[i] = nx * hx + ny * hy + nz * hz
        SH[i] = np.sqrt(cx * cx + cy * cy + cz * cz)
        VH[i] = min(length / 2, 1.0)
        fall[i] = reach / square if light[3] != 0 else 1.0


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
    rows = np.zeros((7, BLOCK))
    for first in range(0, n, BLOCK):
        m = min(BLOCK, n - first)
        for k in range(n_lights):
            _cosines(
                points, normals, start + first, m, lights[k], reaches[k], eye, rows
            )
            lobe(
                *(rows[0, :m], rows[1, :m], rows[2, :m], rows[3, :m], rows[4, :m]),
                *(constants, rows[6, :m]),
            )
            if visible.size:
                for i in range(m):
                    rows[5, i] *= visible[k, first + i]
            for i in range(m):
                out[k, first + i] = max(rows[0, i], 0.0) * rows[5, i]
            for j in range(n_indices):
                row = n_lights + k * n_indices + j
                index = indices[j]
                for i in range(m):
                    F = fresnel(rows[4, i], index)
                    out[row, first + i] = rows[6, i] * F * rows[5, i]


@compiled()
def expand(pixels: Any, samples: Any, values: Any, spectra: Any, out: Any) -> None:
    """Write the mean over each pixel's samples of ``values`` times ``spectra``.

    ``pixels`` (m,) says, ascending, to which row of ``out`` (n, bands) each column of
    ``values`` (k, m) belongs; ``spectra`` is (k, bands). Rows without any are 0.
    """
    k, bands = spectra.shape
    mean = np.zeros(k, dtype=spectra.dtype)
    at, m = 0, pixels.size
    for row in range(out.shape[0]):
        if at == m or pixels[at] != row:
            for j in range(bands):
                out[row, j] = 0
            continue
        mean[:] = 0
        while at < m and pixels[at] == row:
            for i in range(k):
                mean[i] += values[i, at] / samples
            at += 1
        _products(mean, spectra, out[row])


@inlined
def _products(mean: Any, spectra: Any, row: Any) -> None:
    """Write the sum of scalars times spectra."""
    for j in range(row.size):
        row[j] = mean[0] * spectra[0, j]
    for i in range(1, mean.size):
        if mean[i] != 0:
            for j in range(row.size):
                row[j] += mean[i] * spectra[i, j]


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
            _products(gloss[:, at], shine, sums[2])
            for j in range(bands):
                sums[0, j] += body[at, j] * sums[1, j] + sums[2, j]
            at += 1
        for j in range(bands):
            out[row, j] = sums[0, j] / samples
