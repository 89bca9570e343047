"""A few of a picture's pixels, traced in full: what choices are judged by.

The pixels are drawn evenly over what is seen of the mesh, so that surface, outlines
within it, highlights and the edges of shadows all have their share; those that an
outline of the mesh crosses are drawn apart, for edges are judged apart.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import even_size, in_slices
from skinviz.rendering import kernels, trace
from skinviz.rendering.imager import contrast_white
from skinviz.rendering.painter import Painter
from skinviz.rendering.plan import MOST_SAMPLES, cells
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.stage import Stage
from skinviz.rendering.tolerance import (
    FEW,
    colour_differences,
    edge_allowance,
    percentile_bound,
)

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

FILLED, EDGES = 1100, 800
"""Pixels that are drawn, at most: with 1,100, two may differ by more than a bound."""

_CANDIDATES = 2 * FILLED  # that one ray each is cast for
_SEED = 20051  # of the draw: the same scene has the same pilot


@dataclass(frozen=True, eq=False)
class Sample:
    """Some pixels of a picture, with all of their rays.

    Attributes
    ----------
    pixels : (k,) ndarray
        Row × width + column, ascending.
    hits : Hits
        Of their 16 rays each, every ray a pixel of its own.
    """

    pixels: Whole
    hits: trace.Hits

    def colours(self, painter: Painter) -> Array:
        """Return XYZ of every ray (k, 16, 3) as a painter's plan has it; 0 of none."""
        flat = point_colours(painter, self.hits)
        return flat.reshape(self.pixels.size, MOST_SAMPLES, 3)


@dataclass(frozen=True, eq=False)
class Pilot:
    """What choices are judged by, on one stage.

    Attributes
    ----------
    stage : Stage
        The scene with the reference's plan.
    filled : Sample
        Pixels that all of their rays fill.
    edges : Sample
        Pixels at edges, that some rays miss.
    share : float
        Of the pixels that may show the mesh, how many do. [1]
    complete : bool
        Whether ``filled`` are all there are: then the largest difference counts.
    """

    stage: Stage
    filled: Sample
    edges: Sample
    share: float
    complete: bool

    @cached_property
    def white(self) -> Array:
        """The perfect diffuser under light 1 (3,)."""
        return white_xyz(self.stage.scene)

    @cached_property
    def one_each(self) -> trace.Hits:
        """The first ray of each filled pixel, every one a pixel of its own."""
        return _apart(self.stage, self.filled.pixels, 1)

    def judge(self, xyz: Array, reference: Array) -> float:
        """Return a bound on the 99th percentile of how filled pixels (k, 3) differ.

        Unlit ones do not count.
        """
        lit = reference[:, 1] > 0
        differences = colour_differences(xyz[lit], reference[lit], self.white)
        return percentile_bound(differences, all_of_them=self.complete)

    def edges_kept(self, xyz: Array, reference: Array, tolerance: float) -> bool:
        """Return whether edge pixels (k, 3) differ by no more than they may."""
        differences = colour_differences(xyz, reference, self.white)
        if self.complete or differences.size < EDGES // 8:
            bound = float(differences.max(initial=0.0))
        else:
            bound = float(np.percentile(differences, 99))
        return bound <= edge_allowance(tolerance)

    @cached_property
    def contrast_pixels(self) -> tuple[Whole, NDArray[np.bool_]]:
        """Neighbours (k, 4) of the filled pixels, and which of them to look at.

        Not to be looked at are those outside the picture or on an outline.
        """
        width, height = self.stage.sight.view.size
        row, column = np.divmod(self.filled.pixels, width)
        rows = row[:, None] + np.array([0, 0, -1, 1])
        columns = column[:, None] + np.array([-1, 1, 0, 0])
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        pixels = np.where(inside, rows * width + columns, 0)
        outlined = self.stage.sight.outlines.ravel()
        return pixels, inside & ~outlined[pixels]

    def contrasts(self, painter: Painter, own: Array, samples: int) -> Array:
        """Return how much each filled pixel differs from its neighbours (k,).

        With so many samples each, ``own`` (k, 16, 3) the filled pixels'.
        """
        pixels, looked_at = self.contrast_pixels
        asked = np.unique(pixels[looked_at])
        hits = _apart(self.stage, asked, samples)
        light = point_colours(painter, hits).reshape(asked.size, samples, 3)
        around = np.full((*pixels.shape, 3), -1.0)
        where = np.searchsorted(asked, pixels[looked_at])
        around[looked_at] = light.mean(axis=1)[where]
        mean = own[:, :samples].mean(axis=1, keepdims=True)
        out = np.zeros(len(own))
        kernels.neighbour_contrasts(
            np.concatenate([mean, around], axis=1), contrast_white(self.stage), out
        )
        return out


def point_colours(painter: Painter, hits: trace.Hits) -> Array:
    """Return XYZ (n, 3) of rays that are pixels of their own."""
    out = np.zeros((hits.covered.size, 3))
    painter.prepare()

    def work(part: slice) -> None:
        own = hits.part(part)
        out[hits.rays[part]] = painter.colours(own, 1)

    m = hits.rays.size
    in_slices(work, m, even_size(m, 2**16))
    return out


def pilot_of(stage: Stage) -> Pilot:
    """Draw a pilot of a scene, and trace it."""
    rng = np.random.default_rng(_SEED)
    candidates, drawn = _candidates(stage, rng)
    seen = trace.cast(stage.sight, stage.plan.cells[:1], candidates).covered > 0
    hit = candidates[seen]
    outlined = stage.sight.outlines.ravel()
    # Only what an outline crosses can be filled where its one ray is not.
    edges = np.flatnonzero(outlined)
    few = bool(drawn == 1 and hit.size < FEW + edges.size)
    if few:
        hit = np.union1d(hit, candidates[outlined[candidates]])
    elif hit.size > FILLED:
        hit = np.sort(rng.choice(hit, FILLED, replace=False))
    if edges.size > EDGES and not few:
        edges = np.sort(rng.choice(edges, EDGES, replace=False))
    _ = stage.geometry.embree, stage.sight.frame  # once, not in each thread
    with ThreadPoolExecutor(2) as pool:
        rims = pool.submit(
            _traced, stage, edges, lambda n: (n > 0) & (n < MOST_SAMPLES)
        )
        filled = _traced(stage, hit, lambda n: n == MOST_SAMPLES)
    complete = few and filled.pixels.size < FEW
    return Pilot(
        stage, filled, rims.result(), float(seen.mean()) if seen.size else 0.0, complete
    )


def _candidates(stage: Stage, rng: np.random.Generator) -> tuple[Whole, int]:
    """Return pixels (k,) drawn evenly from those that may show the mesh.

    With them comes of how many each is one: 1 where these are all.
    """
    block, marked = stage.sight.blocks
    width, height = stage.sight.view.size
    wide = np.repeat(np.repeat(marked, block, axis=0), block, axis=1)
    pixels = np.flatnonzero(wide[:height, :width])
    step = -(-pixels.size // _CANDIDATES)
    if step <= 1:
        return pixels, 1
    first = np.arange(0, pixels.size - step + 1, step)
    return pixels[first + rng.integers(0, step, first.size)], step


def _apart(stage: Stage, pixels: Whole, samples: int) -> trace.Hits:
    """Return what the first rays of pixels hit, every ray a pixel of its own."""
    hits = trace.cast(stage.sight, cells(samples), pixels)
    return hits.apart(pixels.size * samples)


def _traced(
    stage: Stage, pixels: Whole, wanted: Callable[[Whole], NDArray[np.bool_]]
) -> Sample:
    """Trace all rays of pixels; return those ``wanted`` by how many hit the mesh."""
    hits = trace.cast(stage.sight, cells(MOST_SAMPLES), pixels)
    which = wanted(hits.covered.astype(np.int64))
    rank = np.cumsum(which) - 1
    kept = np.flatnonzero(which[hits.pixels])
    pixel, ray = np.divmod(hits.rays[kept], MOST_SAMPLES)
    own = dataclasses.replace(hits.part(kept), rays=rank[pixel] * MOST_SAMPLES + ray)
    return Sample(pixels[which], own.apart(int(which.sum()) * MOST_SAMPLES))
