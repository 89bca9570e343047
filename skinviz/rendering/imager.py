"""From a stage to the light of its pixels, some thousands of them at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import even_size, in_slices
from skinviz.rendering import contrasts
from skinviz.rendering.expansion import as_single
from skinviz.rendering.painter import Painter
from skinviz.rendering.plan import MOST_SAMPLES
from skinviz.rendering.stage import Lit, Stage

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Whole = NDArray[np.int64]
Advance = Callable[[int], object]

Box = tuple[int, int, int, int]
"""Left, top, right and bottom of pixels, the last two not among them."""

_RAYS = 2**16  # that a thread casts in one go
_NUMBERS = 2**22  # of reflectance that it holds, where each point has its own


@dataclass(frozen=True, eq=False)
class Image:
    """What is seen in the pixels of a picture.

    Attributes
    ----------
    xyz : (n, 3) ndarray of float32
        Light from the mesh.
    covered, rays : (n,) ndarray of uint8
        How many of a pixel's rays hit the mesh, of how many.
    """

    xyz: Single
    covered: NDArray[np.uint8]
    rays: NDArray[np.uint8]


def image_of(stage: Stage, advance: Advance | None = None) -> Image:
    """Return the colours of all pixels, row after row.

    Where the plan refines, pixels that an outline crosses and those that differ much
    from a neighbour have all the samples of the grid.
    """
    plan, painter = stage.plan, Painter(stage)
    width, height = stage.sight.view.size
    n = width * height
    rays = np.full(n, plan.samples, np.uint8)
    if plan.refine is not None:
        rays[stage.sight.outlines.ravel()] = MOST_SAMPLES
    image = Image(np.zeros((n, 3), np.float32), np.zeros(n, np.uint8), rays)
    size, marked = stage.sight.blocks
    blocks = np.argwhere(marked)

    def work(part: slice) -> None:
        pixels = pixels_of(blocks[part], size, width, height)
        for samples in {plan.samples, MOST_SAMPLES}:
            own = pixels[rays[pixels] == samples]
            if own.size:
                _draw(painter, own, samples, image)

    painter.prepare()
    step = _step(stage.colours, len(blocks), plan.samples * size**2)
    in_slices(work, len(blocks), step, _telling(advance, blocks, size, (width, height)))
    if plan.refine is not None and plan.samples < MOST_SAMPLES:
        _refine(painter, image)
    return image


def pixel_radiance(
    stage: Stage,
    box: Box,
    rays: NDArray[np.uint8],
    out: Single,
    advance: Advance | None = None,
) -> None:
    """Write the radiance (k, bands) of a box's pixels, row after row.

    ``rays`` (height, width) are those that the picture's pixels have.
    """
    lit, painter = stage.bands, Painter(stage)
    matrix = as_single(lit.spectra.products(lit.fields.spectra))
    left, top, right, bottom = box
    counts = rays[top:bottom, left:right].ravel()

    def work(part: slice) -> None:
        row, column = np.divmod(np.arange(part.start, part.stop), right - left)
        pixels = (row + top) * stage.sight.view.size[0] + column + left
        for samples in np.unique(counts[part]):
            own = np.flatnonzero(counts[part] == samples)
            hits = painter.cast(pixels[own], int(samples))
            if own.size == pixels.size:
                painter.radiance(hits, int(samples), matrix, out[part])
            else:
                light = np.zeros((own.size, out.shape[1]), dtype=np.float32)
                painter.radiance(hits, int(samples), matrix, light)
                out[part.start + own] = light

    _ = stage.geometry.embree, stage.sight.blocks  # once, not in each thread
    step = _step(lit, counts.size, int(counts.max(initial=1)))
    in_slices(work, counts.size, step, advance)


def contrast_white(stage: Stage) -> Array:
    """Return the white (3,) by which contrasts are judged."""
    white = stage.white
    return white if white.min() > 0.01 * white[1] else np.full(3, white[1])


def pixels_of(blocks: Whole, size: int, width: int, height: int) -> Whole:
    """Return the pixels (k,) of some blocks, those of one block in a row."""
    within = np.arange(size)
    rows = blocks[:, :1] * size + within
    columns = blocks[:, 1:] * size + within
    pixels = rows[:, :, None] * width + columns[:, None, :]
    inside = (rows < height)[:, :, None] & (columns < width)[:, None, :]
    return np.asarray(pixels[inside])


def _telling(
    advance: Advance | None, blocks: Whole, size: int, shape: tuple[int, int]
) -> Advance | None:
    """Return what tells of pixels done when it is told of blocks, in their order.

    Pixels of blocks that cannot show the mesh are done at once.
    """
    if advance is None:
        return None
    corner = np.minimum((blocks + 1) * size, np.array(shape[::-1]))
    counts = (corner - blocks * size).prod(axis=1)
    ends = np.cumsum(counts)
    advance(shape[0] * shape[1] - int(counts.sum()))
    done = 0

    def told(n: int) -> None:
        nonlocal done
        before = ends[done - 1] if done else 0
        done += n
        advance(int(ends[done - 1] - before))

    return told


def _draw(painter: Painter, pixels: Whole, samples: int, image: Image) -> None:
    """Write what is seen of pixels (k,), with as many samples each."""
    hits = painter.cast(pixels, samples)
    image.xyz[pixels] = painter.colours(hits, samples)
    image.covered[pixels] = hits.covered
    image.rays[pixels] = samples


def _refine(painter: Painter, image: Image) -> None:
    """Draw pixels with all samples that differ much from a neighbour.

    So are those drawn that are filled in part, though no outline crosses them.
    """
    plan = painter.stage.plan
    width, height = painter.stage.sight.view.size
    shape = (height, width)
    rough = np.zeros(shape, dtype=np.bool_)
    xyz, rays = image.xyz.reshape(*shape, 3), image.rays.reshape(shape)
    white, contrast = contrast_white(painter.stage), plan.refine

    def look(part: slice) -> None:
        rows = (part.start, part.stop)
        contrasts.contrasts(xyz, rays, plan.samples, white, contrast, *rows, rough)

    in_slices(look, height, even_size(height, max(1, _RAYS // width)))
    partly = (image.covered > 0) & (image.covered < image.rays)
    chosen = np.flatnonzero(rough.ravel() | (partly & (image.rays < MOST_SAMPLES)))

    def work(part: slice) -> None:
        _draw(painter, chosen[part], MOST_SAMPLES, image)

    step = _step(painter.stage.colours, chosen.size, MOST_SAMPLES)
    in_slices(work, chosen.size, step)


def _step(lit: Lit, n: int, samples: int) -> int:
    """Return how many of ``n`` pixels a thread takes at once."""
    rays = _RAYS
    if lit.spectra.body is None:
        rays = min(rays, _NUMBERS // lit.spectra.wavelengths.size)
    return even_size(n, max(1, rays // samples))
