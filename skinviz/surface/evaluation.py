"""Surfaces at vectors of any shape, by the lobes that pictures are made with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

_CHUNK = 2**14  # points whose vectors are held at once
_SHORTEST = 1e-12  # of L + V; light from behind the viewer's back has no H
_UNIT = 1e-6  # by which a unit vector's length may be off


def specular(lobe: Any, constants: Array, n: Array, *vectors: ArrayLike) -> Array:
    """Return a lobe times Fresnel's reflectance, of the broadcast shape.

    ``n`` are refractive indices; ``vectors`` are (..., 3): normals, towards the light
    and towards the viewer.
    """
    from skinviz.surface.kernels import specular as compiled

    arrays = unit_vectors(*vectors)
    shape = np.broadcast_shapes(n.shape, *(x.shape[:-1] for x in arrays))
    spread = shape or (1,)
    out = np.zeros(int(np.prod(spread)))
    index = np.broadcast_to(n, spread)
    for part, at in _chunks(spread):
        seen = cosines(*(np.broadcast_to(x, (*spread, 3))[at] for x in arrays))
        compiled(lobe, seen, constants, np.ascontiguousarray(index[at]), out[part])
    return out.reshape(shape)


def cosines(normals: Array, light: Array, view: Array) -> Array:
    """Return N·L, N·V, N·H, |N × H| and V·H (5, ...) of unit vectors (..., 3)."""
    total = light + view
    length = np.linalg.norm(total, axis=-1, keepdims=True)
    half = np.divide(total, length, out=np.zeros_like(total), where=length > _SHORTEST)
    facing = [(normals * x).sum(axis=-1) for x in (light, view, half)]
    sine = np.linalg.norm(np.cross(normals, half), axis=-1)
    tilted = np.minimum(length[..., 0] / 2, 1.0)
    return np.stack(np.broadcast_arrays(*facing, sine, tilted))


def unit_vectors(*vectors: ArrayLike) -> tuple[Array, ...]:
    """Return vectors (..., 3) as float64; refuse others than of length 1."""
    return tuple(
        _unit_vectors(x, name)
        for x, name in zip(vectors, ("normals", "light", "view"), strict=True)
    )


def _unit_vectors(value: ArrayLike, name: str) -> Array:
    """Return unit vectors, or say which is none."""
    array = as_numbers(value, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ArgumentError(f"{name} must be vectors (..., 3); got shape {array.shape}")
    with np.errstate(over="ignore"):
        length = np.sqrt(np.square(array).sum(axis=-1))
    wrong = ~(np.abs(length - 1) <= _UNIT)
    if wrong.any():
        first = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise ArgumentError(
            f"{name} must be unit vectors; that at index {first} has length "
            f"{length[first]:g}; divide each by its length"
        )
    return array


def _chunks(shape: tuple[int, ...]) -> Iterator[tuple[slice, Any]]:
    """Yield slices of the flat points, and where these are in an array of a shape."""
    size = int(np.prod(shape))
    for first in range(0, size, _CHUNK):
        part = slice(first, min(first + _CHUNK, size))
        yield part, np.unravel_index(np.arange(part.start, part.stop), shape)
