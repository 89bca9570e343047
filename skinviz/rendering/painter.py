"""From rays to colours, as a plan has it: what all of a stage's pixels go through."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering import kernels, trace
from skinviz.rendering.expansion import expand_mapped, require_single
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.lighting import Lighting, body_at
from skinviz.rendering.plan import cells
from skinviz.rendering.stage import Lit, Stage
from skinviz.rendering.tints import pigments_at
from skinviz.rendering.vertices import vertex_xyz

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Whole = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Painter:
    """A stage, and what its plan has computed before there are pixels.

    Attributes
    ----------
    stage : Stage
        What is lit, seen and how finely.
    lit_at : callable
        Which lights (n_lights, m) nothing hides from points that are hit.
    """

    stage: Stage
    lit_at: Callable[[Geometry, Lighting, trace.Hits], NDArray[np.uint8]] = (
        trace.visibility_of
    )

    @cached_property
    def vertex_xyz(self) -> Array:
        """XYZ of the vertices (n, 3), where light is computed there."""
        return vertex_xyz(self.stage)

    def prepare(self) -> None:
        """Compute what all threads use once, not in each of them."""
        stage = self.stage
        _ = stage.geometry.embree, stage.sight.blocks, stage.colours.matrix
        if stage.plan.shading == "vertices":
            _ = self.vertex_xyz
        elif stage.colours.spectra.body is None and stage.plan.basis == "shared":
            _ = stage.tints

    def cast(self, pixels: Whole, samples: int) -> trace.Hits:
        """Cast the first rays of pixels (k,): row × width + column, in any order.

        Those that cannot show the mesh are not traced.
        """
        sight = self.stage.sight
        block, marked = sight.blocks
        row, column = np.divmod(pixels, sight.view.size[0])
        asked = np.flatnonzero(marked[row // block, column // block])
        hits = trace.cast(sight, cells(samples), pixels[asked])
        covered = np.zeros(pixels.size, dtype=np.uint8)
        covered[asked] = hits.covered
        within = hits.rays - hits.pixels * samples
        own = asked[hits.pixels]
        return dataclasses.replace(
            hits, rays=own * samples + within, pixels=own, covered=covered
        )

    def scalars(self, lit: Lit, hits: trace.Hits) -> Array:
        """Return the scalars (rows + fields, m) of the points hit."""
        geometry, lighting, fields = self.stage.geometry, lit.lighting, lit.fields
        out = np.zeros((lit.rows + len(fields.spectra), hits.pixels.size))
        visible = None
        if self.stage.plan.shadows:
            visible = self.lit_at(geometry, lighting, hits)
        lighting.scalars(hits.points, hits.normals, out, visible=visible)
        if len(fields.spectra):
            out[lit.rows :] = trace.at_corners(geometry, hits, fields.values)
        return out

    def colours(self, hits: trace.Hits, samples: int) -> Single:
        """Return XYZ (k, 3) of pixels, the mean over their samples."""
        plan, lit = self.stage.plan, self.stage.colours
        out = np.zeros((hits.covered.size, 3), dtype=np.float32)
        if plan.shading == "vertices":
            own = trace.at_corners(self.stage.geometry, hits, self.vertex_xyz)
            require_single(own, np.eye(3))
            kernels.expand(hits.pixels, samples, own, np.eye(3), out)
            return out
        scalars = self.scalars(lit, hits)
        require_single(scalars, lit.matrix)
        if lit.spectra.body is not None:
            kernels.expand(hits.pixels, samples, scalars, lit.matrix, out)
        elif plan.basis == "points":
            radiance = np.zeros((hits.covered.size, lit.spectra.wavelengths.size))
            self._expand_mapped(lit, hits, samples, radiance, scalars)
            out[:] = radiance @ lit.spectra.colour
        else:
            self._expand_tinted(lit, hits, samples, out, scalars)
        return out

    def radiance(
        self,
        hits: trace.Hits,
        samples: int,
        matrix: NDArray[np.floating],
        out: Single,
    ) -> None:
        """Write the spectral radiance (k, bands) of pixels.

        ``matrix`` are the products of the stage's bands, as float32.
        """
        lit = self.stage.bands
        scalars = self.scalars(lit, hits)
        if lit.spectra.body is None:
            self._expand_mapped(lit, hits, samples, out, scalars)
        else:
            require_single(scalars, matrix)
            kernels.expand(hits.pixels, samples, scalars, matrix, out)

    def _expand_tinted(
        self, lit: Lit, hits: trace.Hits, samples: int, out: Single, scalars: Array
    ) -> None:
        """Write XYZ of pixels whose points each have their own tint."""
        n_lights = len(lit.spectra.light)
        kernels.expand_tinted(
            *(hits.pixels, samples),
            np.concatenate([scalars[:n_lights], scalars[lit.rows :]]),
            self.stage.tints.at(hits),
            np.ascontiguousarray(scalars[n_lights : lit.rows]),
            *(lit.spectra.shine @ lit.spectra.colour, out),
        )

    def _expand_mapped(
        self,
        lit: Lit,
        hits: trace.Hits,
        samples: int,
        out: NDArray[Any],
        scalars: Array,
    ) -> None:
        """Write the radiance of pixels whose points each have their own pigments."""
        values = pigments_at(self.stage, hits)
        body = body_at(self.stage.scene, values, lit.spectra.wavelengths)
        expand_mapped(lit, scalars, body, rows=hits.pixels, samples=samples, out=out)
