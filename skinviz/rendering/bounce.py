"""Light that one part of the mesh throws on another: one diffuse bounce.

At every vertex the hemisphere is searched along fixed directions, spread as the
cosine; where one meets the mesh's outside, the light that leaves there diffusely is
gathered (PHYSICS: E·R·R', with R' of the part that throws it).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import in_slices
from skinviz.rendering import rays, trace
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.lighting import Lighting, Spectra
from skinviz.rendering.plan import Plan
from skinviz.scene.scene import Scene

Array = NDArray[np.float64]

_RAYS = 2**16  # that a thread casts in one go
_RANK = 1e-7  # of the largest, below which a field's share is left out


@dataclass(frozen=True, eq=False)
class Fields:
    """Light on the vertices as a few numbers each times a few spectra.

    Attributes
    ----------
    values : (n_vertices, e) ndarray
        Of each vertex; e is 0 where there is no such light.
    spectra : (e, bands) ndarray
        What they are multiplied by: α times irradiance over π.
    """

    values: Array
    spectra: Array


def fields_of(
    scene: Scene, geometry: Geometry, lighting: Lighting, spectra: Spectra, plan: Plan
) -> Fields:
    """Return the light that the mesh throws on its own vertices, if declared."""
    n, bands = len(geometry.points), scene.wavelengths.size
    if scene.interreflection == "none":
        return Fields(np.zeros((n, 0)), np.zeros((0, bands)))
    lit = np.zeros((lighting.rows, n))
    points, normals = geometry.components
    visible = trace.vertex_visibility(geometry, lighting) if plan.shadows else None
    lighting.scalars(points, normals, lit, visible=visible)
    leaving = lit[: len(lighting.lights)].T
    if spectra.body is not None:
        gathered = gather(geometry, leaving, plan.bounce_rays)
        return Fields(gathered, scene.diffuse_scale * spectra.light * spectra.body)
    body = scene.skin.model.diffuse(scene.skin.values, scene.wavelengths)
    gathered = gather(geometry, body * (leaving @ spectra.light), plan.bounce_rays)
    # Each vertex has a spectrum of its own, of which a few suffice to mix them all:
    # the right singular vectors, from the small matrix that has them too.
    squares, vectors = np.linalg.eigh(gathered.T @ gathered)
    few = vectors[:, squares > _RANK**2 * squares[-1]]
    return Fields(gathered @ few, scene.diffuse_scale * few.T)


def gather(geometry: Geometry, leaving: Array, n_rays: int) -> Array:
    """Return the mean over each vertex's hemisphere of what leaves other vertices.

    Parameters
    ----------
    geometry : Geometry
        The mesh.
    leaving : (n, k) ndarray
        Radiance that leaves each vertex, the same in all directions.
    n_rays : int
        Directions a vertex looks in.

    Returns
    -------
    gathered : (n, k) ndarray
        Irradiance from the mesh itself over π, in the unit of ``leaving``.
    """
    gathered = np.zeros_like(leaving)
    local = _cosine_directions(n_rays)
    tree = geometry.embree  # built before there are threads

    def work(part: slice) -> None:
        m = (part.stop - part.start) * n_rays
        origins, directions = (np.zeros((m, 3), dtype=np.float32) for _ in range(2))
        rays.hemispheres(
            *(geometry.points[part], geometry.normals[part], local),
            *(origins, directions),
        )
        met = tree.run(origins, directions, query="INTERSECT", output=True)
        rays.gather(
            *(met["primID"], met["u"], met["v"], met["Ng"], directions),
            *(geometry.faces, leaving, gathered[part]),
        )

    in_slices(work, len(leaving), max(1, _RAYS // n_rays))
    return gathered


def _cosine_directions(n: int) -> Array:
    """Return n directions (n, 3) about z, their density as the cosine: a spiral."""
    height = np.sqrt((np.arange(n) + 0.5) / n)  # cos² is uniform
    turn = np.arange(n) * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
