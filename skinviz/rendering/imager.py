"""From a stage to the light of its pixels, some thousands of them at a time."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import even_size, in_slices
from skinviz.rendering import kernels, trace
from skinviz.rendering.expansion import as_single, expand_mapped, require_single
from skinviz.rendering.stage import Stage

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Advance = Callable[[int], object]

Box = tuple[int, int, int, int]
"""Left, top, right and bottom of pixels, the last two not among them."""

_RAYS = 2**16  # that a thread casts in one go
_NUMBERS = 2**22  # of reflectance that it holds, where each point has its own


def pixel_colours(
    stage: Stage, box: Box, advance: Advance | None = None
) -> tuple[Single, NDArray[np.uint8]]:
    """Return XYZ (k, 3) of a box's pixels, and how many of their rays hit (k,)."""
    n = _count(box)
    xyz, covered = np.zeros((n, 3), np.float32), np.zeros(n, np.uint8)
    spectra = stage.spectra
    matrix = spectra.products(stage.fields.spectra) @ spectra.colour

    def work(part: slice) -> None:
        hits = _cast(stage, box, part)
        covered[part] = hits.covered
        if spectra.body is not None:
            _expand(stage, hits, matrix, xyz[part])
            return
        radiance = np.zeros((len(hits.covered), len(spectra.colour)))
        _expand_mapped(stage, hits, radiance)
        xyz[part] = radiance @ spectra.colour

    in_slices(work, n, _step(stage, n), advance)
    return xyz, covered


def pixel_radiance(
    stage: Stage, box: Box, out: Single, advance: Advance | None = None
) -> None:
    """Write the radiance (k, bands) of a box's pixels, row after row."""
    spectra = stage.spectra
    matrix = as_single(spectra.products(stage.fields.spectra))

    def work(part: slice) -> None:
        hits = _cast(stage, box, part)
        if spectra.body is not None:
            _expand(stage, hits, matrix, out[part])
        else:
            _expand_mapped(stage, hits, out[part])

    n = _count(box)
    in_slices(work, n, _step(stage, n), advance)


def _count(box: Box) -> int:
    """Return how many pixels a box has."""
    left, top, right, bottom = box
    return (right - left) * (bottom - top)


def _step(stage: Stage, n: int) -> int:
    """Return how many of ``n`` pixels a thread takes at once; make what all use."""
    _ = stage.geometry.embree, stage.sight.blocks  # once, not in each thread
    rays = _RAYS
    if stage.spectra.body is None:
        rays = min(rays, _NUMBERS // stage.scene.wavelengths.size)
    return even_size(n, max(1, rays // stage.plan.samples))


def _cast(stage: Stage, box: Box, part: slice) -> trace.Hits:
    """Cast the rays of some of a box's pixels."""
    left, top, right, _ = box
    row, column = np.divmod(np.arange(part.start, part.stop), right - left)
    row, column = row + top, column + left
    block, marked = stage.sight.blocks
    asked = np.flatnonzero(marked[row // block, column // block])
    pixels = (row * stage.sight.view.size[0] + column)[asked]
    hits = trace.cast(stage.sight, stage.plan.cells, pixels)
    covered = np.zeros(row.size, dtype=np.uint8)
    covered[asked] = hits.covered
    return dataclasses.replace(hits, pixels=asked[hits.pixels], covered=covered)


def _scalars(stage: Stage, hits: trace.Hits) -> Array:
    """Return the scalars (rows + fields, m) of the points hit."""
    geometry, lighting, fields = stage.geometry, stage.lighting, stage.fields
    out = np.zeros((lighting.rows + len(fields.spectra), hits.pixels.size))
    visible = None
    if stage.plan.shadows:
        visible = trace.visibility(
            geometry, lighting, hits.lifted, hits.normals, hits.facets
        )
    lighting.scalars(hits.points, hits.normals, out, visible=visible)
    if len(fields.spectra):
        out[lighting.rows :] = trace.at_corners(geometry, hits, fields.values)
    return out


def _expand(
    stage: Stage, hits: trace.Hits, matrix: NDArray[np.floating], out: Single
) -> None:
    """Write the mean over pixels of scalars times the rows of a matrix."""
    scalars = _scalars(stage, hits)
    require_single(scalars, matrix)
    kernels.expand(hits.pixels, stage.plan.samples, scalars, matrix, out)


def _expand_mapped(stage: Stage, hits: trace.Hits, out: NDArray[np.floating]) -> None:
    """Write the radiance of pixels whose points each have their own pigments."""
    scene = stage.scene
    model = scene.skin.model
    low, high = np.array([(p.lower, p.upper) for p in model.parameters]).T
    values = trace.at_corners(stage.geometry, hits, scene.skin.values).T
    values = np.clip(values, low, high)  # which means go beyond by rounding
    body = model.diffuse(values, scene.wavelengths)
    scalars = _scalars(stage, hits)
    samples = stage.plan.samples
    expand_mapped(stage, scalars, body, rows=hits.pixels, samples=samples, out=out)
