"""What diffuse light becomes in XYZ at points of mapped skin, point by point.

Each of a point's g diffuse scalars, of lights and of what the mesh throws on itself,
goes with a spectrum; times the skin's reflectance and summed over wavelengths it is
three numbers. A point's tint is these 3 g numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import in_slices
from skinviz.rendering import rays, trace
from skinviz.rendering.lighting import body_at
from skinviz.scene.scene import Scene
from skinviz.skin.table import ReflectanceTable, reflectance_table

if TYPE_CHECKING:
    from skinviz.rendering.stage import Lit, Stage

Array = NDArray[np.float64]

TABLE_SHARE = 3e-4
"""Largest error of a table's XYZ, as a share of white: a ΔE of 0.03 in light skin."""

_LEAST_WHITE = 0.01
_NUMBERS = 2**22  # of reflectance that a thread holds


class Tints(Protocol):
    """Where tints come from."""

    def at(self, hits: trace.Hits) -> NDArray[Any]:
        """Return the tints (m, 3 g) at points."""


@dataclass(frozen=True, eq=False)
class ModelTints:
    """Tints from the skin's model, at the pigments of each point.

    Attributes
    ----------
    stage : Stage
        What is lit.
    mixing : (J, 3 g) ndarray
        By which reflectance becomes a tint.
    """

    stage: Stage
    mixing: Array

    def at(self, hits: trace.Hits) -> NDArray[Any]:
        """Return the tints (m, 3 g) at points."""
        return self.of(pigments_at(self.stage, hits))

    def of(self, values: Array) -> Array:
        """Return the tints (m, 3 g) of pigments (m, p)."""
        wavelengths = self.stage.colours.spectra.wavelengths
        out = np.zeros((len(values), self.mixing.shape[1]))

        def work(part: slice) -> None:
            body = body_at(self.stage.scene, values[part], wavelengths)
            out[part] = body @ self.mixing

        in_slices(work, len(values), max(1, _NUMBERS // wavelengths.size))
        return out


@dataclass(frozen=True, eq=False)
class TableTints:
    """Tints from a table of the model over the pigments that occur."""

    stage: Stage
    table: ReflectanceTable

    def at(self, hits: trace.Hits) -> NDArray[Any]:
        """Return the tints (m, 3 g) at points."""
        return self.table.at(pigments_at(self.stage, hits))


@dataclass(frozen=True, eq=False)
class VertexTints:
    """Tints of the vertices (n, 3 g), interpolated over triangles."""

    stage: Stage
    values: NDArray[Any]

    def at(self, hits: trace.Hits) -> NDArray[Any]:
        """Return the tints (m, 3 g) at points."""
        out = np.zeros((hits.triangles.size, self.values.shape[1]), self.values.dtype)
        faces = self.stage.geometry.faces
        rays.interpolate_rows(hits.triangles, faces, hits.weights, self.values, out)
        return out


def tints_of(stage: Stage) -> Tints:
    """Return where the tints of a stage's points come from, as its plan says."""
    plan, lit = stage.plan, stage.colours
    exact = ModelTints(stage, mixing_of(lit))
    dtype = np.float32 if plan.arithmetic == "single" else np.float64
    if plan.reflectance == "table":
        return TableTints(stage, table_of(stage, exact.mixing, dtype))
    if plan.reflectance == "vertices":
        return VertexTints(stage, vertex_tints(stage, exact).astype(dtype))
    return exact


def mixing_of(lit: Lit) -> Array:
    """Return the matrix (J, 3 g) by which reflectance becomes a point's tint."""
    diffuse = np.concatenate([lit.spectra.light, lit.fields.spectra])
    mixed = diffuse[:, :, None] * lit.spectra.colour
    return np.ascontiguousarray(mixed.transpose(1, 0, 2).reshape(len(mixed[0]), -1))


def vertex_tints(stage: Stage, exact: ModelTints) -> Array:
    """Return the tints of the vertices (n, 3 g), 0 where none are wanted."""
    values = vertex_pigments(stage.scene)
    out = np.zeros((len(values), exact.mixing.shape[1]))
    out[stage.wanted] = exact.of(values[stage.wanted])
    return out


def table_of(stage: Stage, mixing: Array, dtype: Any) -> ReflectanceTable:
    """Return a table of tints over the pigments of a scene."""
    values = vertex_pigments(stage.scene)
    white = np.abs(mixing).sum(axis=0)
    white = np.maximum(white, _LEAST_WHITE * white.max())  # a laser may have no Z
    return reflectance_table(
        stage.scene.skin.model,
        values.min(axis=0),
        values.max(axis=0),
        stage.colours.spectra.wavelengths,
        mixing,
        tolerance=TABLE_SHARE * white,
        dtype=dtype,
    )


def vertex_pigments(scene: Scene) -> Array:
    """Return the skin's parameters at every vertex (n, p)."""
    values = scene.skin.values
    return np.broadcast_to(values, (scene.mesh.n_points, values.shape[-1]))


def pigments_at(stage: Stage, hits: trace.Hits) -> Array:
    """Return the skin's parameters (m, p) at points."""
    scene = stage.scene
    values = scene.skin.values
    if values.ndim == 1:
        return np.broadcast_to(values, (hits.triangles.size, values.size))
    low, high = values.min(axis=0), values.max(axis=0)
    own = trace.at_corners(stage.geometry, hits, values).T
    return np.clip(own, low, high)  # which means go beyond by rounding
