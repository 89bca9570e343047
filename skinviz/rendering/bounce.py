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
from skinviz.rendering.lighting import Lighting, Spectra, body_at
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
    scene: Scene,
    geometry: Geometry,
    lighting: Lighting,
    spectra: Spectra,
    plan: Plan,
    *,
    wanted: NDArray[np.bool_],
) -> Fields:
    """Return the light that the mesh throws on its own vertices, if declared.

    It is gathered at the vertices ``wanted`` (n,), and 0 elsewhere. What they throw
    has cast shadows, whatever the plan has where the eye looks.
    """
    n = len(geometry.points)
    if scene.interreflection == "none" or plan.bounce_rays == 0:
        return Fields(np.zeros((n, 0)), np.zeros((0, spectra.wavelengths.size)))
    leaving = lit_vertices(geometry, lighting)
    if spectra.body is not None:
        gathered = gather(geometry, leaving, plan.bounce_rays, wanted)
        return Fields(gathered, scene.diffuse_scale * spectra.light * spectra.body)
    values = np.broadcast_to(scene.skin.values, (n, scene.skin.values.shape[-1]))
    body = body_at(scene, values, spectra.wavelengths)
    shares, few = _few_spectra(body * (leaving @ spectra.light))
    gathered = gather(geometry, shares, plan.bounce_rays, wanted)
    return Fields(gathered, scene.diffuse_scale * few)


def lit_vertices(geometry: Geometry, lighting: Lighting) -> Array:
    """Return what each light gives each vertex (n, n_lights), without wavelength."""
    lit = np.zeros((lighting.rows, len(geometry.points)))
    points, normals = geometry.components
    visible = trace.vertex_visibility(geometry, lighting)
    lighting.scalars(points, normals, lit, visible=visible)
    return lit[: len(lighting.lights)].T


def _few_spectra(leaving: Array) -> tuple[Array, Array]:
    """Return spectra (n, J) as mixtures (n, e) of a few (e, J): light adds up linearly.

    These are the right singular vectors, from the small matrix that has them too.
    """
    squares, vectors = np.linalg.eigh(leaving.T @ leaving)
    few = vectors[:, squares > _RANK**2 * squares[-1]]
    return leaving @ few, few.T


def gather(
    geometry: Geometry,
    leaving: Array,
    n_rays: int,
    wanted: NDArray[np.bool_] | None = None,
) -> Array:
    """Return the mean over each vertex's hemisphere of what leaves other vertices.

    Parameters
    ----------
    geometry : Geometry
        The mesh.
    leaving : (n, k) ndarray
        Radiance that leaves each vertex, the same in all directions.
    n_rays : int
        Directions a vertex looks in.
    wanted : (n,) ndarray of bool, optional
        At which vertices; all by default.

    Returns
    -------
    gathered : (n, k) ndarray
        Irradiance from the mesh itself over π, in the unit of ``leaving``; 0 at
        vertices that are not wanted.
    """
    gathered = np.zeros_like(leaving)
    which = np.arange(len(leaving)) if wanted is None else np.flatnonzero(wanted)
    local = _cosine_directions(n_rays)
    tree = geometry.embree  # built before there are threads

    def work(part: slice) -> None:
        own = which[part]
        origins, directions = np.zeros((2, own.size * n_rays, 3), dtype=np.float32)
        rays.hemispheres(
            *(geometry.points[own], geometry.normals[own], local),
            *(origins, directions),
        )
        met = tree.run(origins, directions, query="INTERSECT", output=True)
        found = np.zeros((own.size, leaving.shape[1]))
        rays.gather(
            *(met["primID"], met["u"], met["v"], met["Ng"], directions),
            *(geometry.faces, leaving, found),
        )
        gathered[own] = found

    in_slices(work, which.size, max(1, _RAYS // n_rays))
    return gathered


def _cosine_directions(n: int) -> Array:
    """Return n directions (n, 3) about z, their density as the cosine: a spiral."""
    height = np.sqrt((np.arange(n) + 0.5) / n)  # cos² is uniform
    turn = np.arange(n) * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
