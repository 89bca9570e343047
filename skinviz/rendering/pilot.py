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

from skinviz._threads import even_size, in_slices, processors
from skinviz.rendering import contrasts, trace
from skinviz.rendering.imager import contrast_white
from skinviz.rendering.painter import Painter
from skinviz.rendering.plan import MOST_SAMPLES, cells
from skinviz.rendering.stage import Stage
from skinviz.rendering.tolerance import (
    FEW,
    colour_differences,
    is_lit,
    percentile_bound,
    percentile_floor,
)

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

FILLED, EDGES = 1100, 800
"""Pixels that are drawn: of 1,100, two may differ by more than a bound."""

_MOST_FILLED = 3000  # of large pictures, of which 13 may
_OF_HOW_MANY = 64  # pixels one is drawn

_SURELY_MANY = FEW + FEW // 2  # lit pixels by a count from weights, if not fewer

_MOST_DRAWN = 16 * FILLED  # pixels that one ray each is cast for
_AT_ONCE, _ALONE = 2**16, 2**13  # points of a thread, and too few for two of them
_SOME = 8  # pixels of a pilot, one of which is looked at first
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

    def part(self, which: Whole) -> Sample:
        """Return a sample of some of its pixels (k,), ascending."""
        rank = np.full(self.pixels.size, -1)
        rank[which] = np.arange(which.size)
        pixel, ray = np.divmod(self.hits.rays, MOST_SAMPLES)
        kept = np.flatnonzero(rank[pixel] >= 0)
        rays = rank[pixel[kept]] * MOST_SAMPLES + ray[kept]
        hits = dataclasses.replace(self.hits.part(kept), rays=rays)
        return Sample(self.pixels[which], hits.apart(which.size * MOST_SAMPLES))

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
    weights : (k,) ndarray of int64
        For how many pixels each of them stands.
    share : float
        Of the pixels that may show the mesh, how many do. [1]
    population : int
        How many filled pixels the picture has, about; exactly where these are all.
    """

    stage: Stage
    filled: Sample
    weights: Whole
    share: float
    population: int

    @property
    def complete(self) -> bool:
        """Whether the filled pixels are all that the picture has."""
        return self.filled.pixels.size >= self.population

    @cached_property
    def edges(self) -> Sample:
        """Pixels at edges, that some of their rays miss."""
        edges = np.flatnonzero(self.stage.sight.outlines)
        if edges.size > EDGES:
            rng = np.random.default_rng(_SEED)
            edges = np.sort(rng.choice(edges, EDGES, replace=False))
        return _traced(self.stage, edges, lambda n: (n > 0) & (n < MOST_SAMPLES))[0]

    @cached_property
    def white(self) -> Array:
        """The perfect diffuser under light 1 (3,)."""
        return self.stage.white

    @cached_property
    def one_each(self) -> trace.Hits:
        """The first ray of each filled pixel, every one a pixel of its own."""
        return _apart(self.stage, self.filled.pixels, 1)

    @cached_property
    def exact_full_light(self) -> Array:
        """XYZ (k, 3) of mapped skin of these rays under full light, by the model."""
        return self.full_light(self.stage.replanned(bounce_rays=0))

    def full_light(self, stage: Stage) -> Array:
        """Return XYZ (k, 3) of mapped skin under full light, as a stage has it."""
        hits = self.one_each
        out = np.zeros((hits.covered.size, 3))
        tints = stage.tints.at(hits).reshape(hits.rays.size, -1, 3)
        out[hits.rays] = tints.sum(axis=1)
        return out

    def judge(self, xyz: Array, reference: Array) -> float:
        """Return a bound on the 99th percentile of how filled pixels (k, 3) differ.

        Those unlit in both do not count. Nothing is told where few are lit and not
        all of them are drawn: then the largest difference would count.
        """
        lit = is_lit(xyz, reference)
        differences = colour_differences(xyz[lit], reference[lit], self.white)
        differences = np.repeat(differences, self.weights[lit])
        population = self.population - int(self.weights[~lit].sum())
        if population < _SURELY_MANY and not self.complete:
            return np.inf
        return percentile_bound(differences, population)

    @cached_property
    def some(self) -> tuple[Whole, Sample]:
        """A few of the filled pixels: which they are, and their rays."""
        which = np.arange(0, self.filled.pixels.size, _SOME)
        return which, self.filled.part(which)

    def floor(self, xyz: Array, reference: Array) -> float:
        """Return what :meth:`judge` of all filled pixels would be at least.

        ``xyz`` are ``some`` of them, ``reference`` is all.
        """
        which = self.some[0]
        lit = is_lit(xyz, reference[which])
        differences = colour_differences(xyz[lit], reference[which][lit], self.white)
        differences = np.repeat(differences, self.weights[which][lit])
        n = int(self.weights.sum())
        return percentile_floor(differences, n, self.population)

    def edge_difference(self, xyz: Array, reference: Array) -> float:
        """Return the 99th percentile of how edge pixels (k, 3) differ.

        The largest difference where the picture has few filled pixels, or few edges.
        """
        differences = colour_differences(xyz, reference, self.white)
        if self.population < FEW or differences.size < EDGES // 8:
            return float(differences.max(initial=0.0))
        return float(np.percentile(differences, 99))

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
        contrasts.neighbour_contrasts(
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
    in_slices(work, m, even_size(m, _AT_ONCE) if m > _ALONE else _ALONE)
    return out


def pilot_of(stage: Stage) -> Pilot:
    """Draw a pilot of a scene, and trace it."""
    rng = np.random.default_rng(_SEED)
    draw = _drawn(stage, rng)
    pixels, weights = _thinned(draw, rng)
    every = draw.every and pixels.size == np.count_nonzero(draw.seen)
    if every:  # only what an outline crosses can be filled where its one ray is not
        outlined = stage.sight.outlines.ravel()
        more = np.setdiff1d(draw.pixels[outlined[draw.pixels]], pixels)
        pixels = np.concatenate([pixels, more])
        weights = np.concatenate([weights, np.ones(more.size, np.int64)])
    order = np.argsort(pixels)
    filled, which = _traced(stage, pixels[order], lambda n: n == MOST_SAMPLES)
    share = float(draw.seen.mean()) if draw.seen.size else 0.0
    return Pilot(
        stage,
        filled,
        weights[order][which],
        share,
        filled.pixels.size if every else int(share * draw.population),
    )


@dataclass(frozen=True, eq=False)
class _Draw:
    """Pixels that may show the mesh, one ray cast for each.

    Attributes
    ----------
    pixels : (k,) ndarray
        Ascending.
    seen, lit : (k,) ndarray of bool
        Whether the ray finds skin, and a light that reaches it.
    population : int
        How many pixels may show the mesh.
    """

    pixels: Whole
    seen: NDArray[np.bool_]
    lit: NDArray[np.bool_]
    population: int

    @property
    def every(self) -> bool:
        """Whether these are all pixels that may show the mesh."""
        return self.pixels.size == self.population

    @property
    def enough(self) -> int:
        """How many pixels are to be traced in full: more of large pictures."""
        return int(np.clip(self.population / _OF_HOW_MANY, FILLED, _MOST_FILLED))


def _drawn(stage: Stage, rng: np.random.Generator) -> _Draw:
    """Draw pixels evenly, as many as it takes to have enough lit ones."""
    block, marked = stage.sight.blocks
    width, height = stage.sight.view.size
    wide = np.repeat(np.repeat(marked, block, axis=0), block, axis=1)
    pixels = np.flatnonzero(wide[:height, :width])
    draw = _cast_one(stage, pixels, 2 * FILLED, rng)
    lit = int(draw.lit.sum())
    if lit < draw.enough and not draw.every:
        wanted = draw.pixels.size * 1.3 * draw.enough / max(lit, 1)
        draw = _cast_one(stage, pixels, int(min(wanted, _MOST_DRAWN)), rng)
    return draw


def _cast_one(stage: Stage, pixels: Whole, n: int, rng: np.random.Generator) -> _Draw:
    """Draw about ``n`` of some pixels evenly, and cast one ray for each."""
    population = pixels.size
    step = population / n if n else 1.0
    if step > 1:
        first = np.floor(np.arange(n) * step).astype(np.int64)
        last = np.floor(np.arange(1, n + 1) * step).astype(np.int64)
        pixels = pixels[rng.integers(first, np.maximum(last, first + 1))]
    hits = trace.cast(stage.sight, stage.plan.cells[:1], pixels)
    lit = np.zeros(pixels.size, dtype=np.bool_)
    lit[hits.pixels] = _reached(stage, hits)
    return _Draw(pixels, hits.covered > 0, lit, population)


def _reached(stage: Stage, hits: trace.Hits) -> NDArray[np.bool_]:
    """Return whether any light reaches points (m,)."""
    if stage.scene.interreflection != "none":  # then some reaches all but everywhere
        return np.ones(hits.rays.size, dtype=np.bool_)
    lit = stage.replanned(bounce_rays=0).colours
    scalars = Painter(stage).scalars(lit, hits)
    return np.asarray(scalars[: len(lit.spectra.light)].max(axis=0) > 0)


def _thinned(draw: _Draw, rng: np.random.Generator) -> tuple[Whole, Whole]:
    """Return the pixels to be traced in full, and for how many each one stands.

    Lit ones are wanted. Of those that their one ray finds dark a part will do, for few
    of them are lit at all.
    """
    lit, dark = draw.pixels[draw.lit], draw.pixels[draw.seen & ~draw.lit]
    enough = draw.enough
    if draw.every and lit.size + dark.size <= 2 * enough:
        both = np.concatenate([lit, dark])
        return both, np.ones(both.size, np.int64)
    share = 1.0
    if lit.size > enough:
        share = enough / lit.size
        lit = rng.choice(lit, enough, replace=False)
    n_dark = min(dark.size, int(share * dark.size) + 1, enough // 4)
    stands = max(1, round(share * dark.size / n_dark)) if n_dark else 1
    dark = rng.choice(dark, n_dark, replace=False)
    weights = np.repeat([1, stands], [lit.size, dark.size])
    return np.concatenate([lit, dark]), weights


def _apart(stage: Stage, pixels: Whole, samples: int) -> trace.Hits:
    """Return what the first rays of pixels hit, every ray a pixel of its own."""
    hits = trace.cast(stage.sight, cells(samples), pixels)
    return hits.apart(pixels.size * samples)


def _traced(
    stage: Stage, pixels: Whole, wanted: Callable[[Whole], NDArray[np.bool_]]
) -> tuple[Sample, NDArray[np.bool_]]:
    """Trace all rays of pixels; return those ``wanted`` by how many hit the mesh.

    With them comes which these are.
    """
    _ = stage.geometry.embree, stage.sight.frame  # once, not in each thread
    halves = np.array_split(pixels, processors())
    with ThreadPoolExecutor(len(halves)) as pool:
        traced = pool.map(
            lambda own: trace.cast(stage.sight, cells(MOST_SAMPLES), own), halves
        )
        hits = trace.joined(list(traced), MOST_SAMPLES)
    which = wanted(hits.covered.astype(np.int64))
    rank = np.cumsum(which) - 1
    kept = np.flatnonzero(which[hits.pixels])
    pixel, ray = np.divmod(hits.rays[kept], MOST_SAMPLES)
    own = dataclasses.replace(hits.part(kept), rays=rank[pixel] * MOST_SAMPLES + ray)
    sample = Sample(pixels[which], own.apart(int(which.sum()) * MOST_SAMPLES))
    return sample, which
