"""Interpolation in a table of evenly spaced nodes, compiled: cubic along each axis.

A value's place on its axis is s = scale · ln(1 + rate (value − low)/(high − low)), in
steps between nodes. Of the nodes nearest to it four are weighed by Lagrange's cubic,
those of all axes together, so that in k axes 4ᵏ nodes make one value.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz._compile import compiled, inlined
from skinviz._vector_math import logarithm

TAPS = 4
"""Nodes that are weighed along each axis."""

LOW, HIGH, RATE, SCALE, LAST, COLUMN = range(6)
"""What a row of axes tells; ``LAST`` is the number of the last node, 0 of no axis."""

_BLOCK = 128  # points whose weights stay near
# Of each axis the weights of four nodes, flat, so that loops over them are seen not to
# overlap.
_W0, _W1, _W2, _W3, _END = (_BLOCK * row for row in range(5))


@compiled()
def interpolate(
    values: Any, bounds: Any, axes: Any, strides: Any, table: Any, out: Any
) -> int:
    """Write the interpolated channels (m, c); return how many values lie outside.

    ``values`` (m, p), ``bounds`` (2, p) between which they are, ``axes`` (k, 6) with
    k ≥ 2 as above, ``strides`` (k,) from node to node in the flat ``table``; those of
    the last axis are the channels.
    """
    k, width = axes.shape[0], out.shape[1]
    lead = TAPS ** (k - 2)
    rows, begin = np.zeros(k * _END), np.zeros(_BLOCK)
    weights, starts = np.zeros(lead), np.zeros(lead, np.int64)
    line = np.zeros(TAPS * width, table.dtype)
    outside = 0
    for first in range(0, values.shape[0], _BLOCK):
        n = min(_BLOCK, values.shape[0] - first)
        outside += _outside(values, bounds, first, n)
        _place(values, axes, strides, first, n, rows, begin)
        for i in range(n):
            _leading(rows, begin, strides, i, weights, starts)
            _gather(rows, (k - 2) * _END + i, strides, weights, starts, table, line)
            _finish(rows, (k - 1) * _END + i, line, first + i, out)
    return outside


@inlined
def _outside(values: Any, bounds: Any, first: int, n: int) -> int:
    """Return how many values of a block are not within their bounds, or NaN."""
    found = 0
    for column in range(values.shape[1]):
        low, high = bounds[0, column], bounds[1, column]
        for i in range(n):
            v = values[first + i, column]
            found += not ((v >= low) & (v <= high))
    return found


@inlined
def _place(
    values: Any, axes: Any, strides: Any, first: int, n: int, rows: Any, begin: Any
) -> None:
    """Fill in a block's four weights on each axis, and where its first nodes begin."""
    begin[:] = 0.0
    for k in range(axes.shape[0]):
        at = k * _END
        low, rate, scale = axes[k, LOW], axes[k, RATE], axes[k, SCALE]
        span, furthest = axes[k, HIGH] - low, axes[k, LAST] - (TAPS - 1)
        column, step = int(axes[k, COLUMN]), float(strides[k])
        for i in range(n):
            v = values[first + i, column] - low
            v = v if v > 0 else 0.0
            rows[at + i] = v if v < span else span
        for i in range(n):
            s = scale * logarithm(1 + rate * (rows[at + i] / span))
            node = np.floor(s) - 1
            node = node if node > 0 else 0.0
            node = node if node < furthest else furthest
            t = s - node
            a, b, c = t - 1, t - 2, t - 3
            begin[i] += node * step
            rows[at + _W0 + i] = a * b * c * (-1 / 6)
            rows[at + _W1 + i] = t * b * c * 0.5
            rows[at + _W2 + i] = t * a * c * -0.5
            rows[at + _W3 + i] = t * a * b * (1 / 6)


@inlined
def _leading(
    rows: Any, begin: Any, strides: Any, i: int, weights: Any, starts: Any
) -> None:
    """Fill in weights and first entries of a point for all axes but the last two."""
    weights[0], starts[0] = 1.0, int(begin[i])
    count = 1
    for axis in range(strides.size - 2):
        for tap in range(TAPS - 1, -1, -1):  # the first last: it overwrites
            w = rows[axis * _END + _W0 + tap * _BLOCK + i]
            for j in range(count):
                weights[tap * count + j] = weights[j] * w
                starts[tap * count + j] = starts[j] + tap * strides[axis]
        count *= TAPS


@inlined
def _gather(
    rows: Any, at: int, strides: Any, weights: Any, starts: Any, table: Any, line: Any
) -> None:
    """Sum up all axes but the last into ``line``, its four nodes times channels."""
    kind = table.dtype.type
    # Indices without a sign need not be looked at for being negative.
    step: Any = np.uint64(strides[strides.size - 2])
    size: Any = np.uint64(line.size)
    for j in range(weights.size):
        w = weights[j]
        w0, w1 = kind(w * rows[at + _W0]), kind(w * rows[at + _W1])
        w2, w3 = kind(w * rows[at + _W2]), kind(w * rows[at + _W3])
        a: Any = np.uint64(starts[j])
        b, c, d = a + step, a + step + step, a + step + step + step
        if j == 0:
            for q in range(size):
                upper = w2 * table[c + q] + w3 * table[d + q]
                line[q] = (w0 * table[a + q] + w1 * table[b + q]) + upper
        else:
            for q in range(size):
                upper = w2 * table[c + q] + w3 * table[d + q]
                line[q] += (w0 * table[a + q] + w1 * table[b + q]) + upper


@inlined
def _finish(rows: Any, at: int, line: Any, i: int, out: Any) -> None:
    """Sum up the last axis."""
    kind, width = line.dtype.type, out.shape[1]
    w0, w1 = kind(rows[at + _W0]), kind(rows[at + _W1])
    w2, w3 = kind(rows[at + _W2]), kind(rows[at + _W3])
    for q in range(width):
        upper = w2 * line[2 * width + q] + w3 * line[3 * width + q]
        out[i, q] = (w0 * line[q] + w1 * line[width + q]) + upper
