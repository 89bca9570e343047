"""From a stage to the light of its vertices, some thousands of them at a time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import even_size, in_slices
from skinviz.rendering import trace
from skinviz.rendering.stage import Lit, Stage
from skinviz.rendering.tints import ModelTints, mixing_of, vertex_pigments

Array = NDArray[np.float64]
Visible = NDArray[np.uint8] | None

_SLICE = 2**16  # vertices that a thread shades in one go


def each_slice(stage: Stage, lit: Lit, use: Callable[[slice, Visible], None]) -> None:
    """Call ``use`` on slices of the vertices, with the lights that all of them see."""
    visible = seen_lights(stage, lit)
    n = len(stage.geometry.points)
    in_slices(lambda part: use(part, visible), n, even_size(n, _SLICE))


def seen_lights(stage: Stage, lit: Lit) -> Visible:
    """Return which lights (n_lights, n) the vertices see; None: all."""
    if not stage.plan.shadows:
        return None
    return trace.vertex_visibility(stage.geometry, lit.lighting)


def vertex_scalars(stage: Stage, lit: Lit, part: slice, visible: Visible) -> Array:
    """Return the scalars (rows + e, m) of some vertices."""
    fields = lit.fields
    out = np.zeros((lit.rows + len(fields.spectra), part.stop - part.start))
    seen = None if visible is None else np.ascontiguousarray(visible[:, part])
    points, normals = stage.geometry.components
    lit.lighting.scalars(points, normals, out, part.start, seen)
    out[lit.rows :] = fields.values[part].T
    return out


def vertex_xyz(stage: Stage) -> Array:
    """Return XYZ of every vertex (n, 3); no spectra are formed of uniform skin."""
    lit = stage.colours
    xyz = np.zeros((len(stage.geometry.points), 3))
    mapped = lit.spectra.body is None
    exact = ModelTints(stage, mixing_of(lit)) if mapped else None
    shine = lit.spectra.shine @ lit.spectra.colour

    def use(part: slice, visible: Visible) -> None:
        scalars = vertex_scalars(stage, lit, part, visible)
        if exact is None:
            xyz[part] = scalars.T @ lit.matrix
            return
        n_lights = len(lit.spectra.light)
        diffuse = np.concatenate([scalars[:n_lights], scalars[lit.rows :]])
        tints = exact.of(vertex_pigments(stage.scene)[part])
        tinted = np.einsum("gm,mgc->mc", diffuse, tints.reshape(len(tints), -1, 3))
        # Fields of few spectra may be below 0 by their rounding.
        xyz[part] = np.maximum(tinted, 0) + scalars[n_lights : lit.rows].T @ shine

    each_slice(stage, lit, use)
    return xyz
