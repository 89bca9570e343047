"""A scene made ready: everything that its points and pixels have in common."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.bounce import Fields, fields_of
from skinviz.rendering.geometry import Geometry, geometry_of
from skinviz.rendering.lighting import (
    Lighting,
    Spectra,
    lighting_of,
    spectra_of,
    uniform_body,
)
from skinviz.rendering.plan import Plan
from skinviz.rendering.sight import Sight
from skinviz.scene.lights import Light
from skinviz.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Stage:
    """A scene, and what follows from it once for all of its points.

    Attributes
    ----------
    scene : Scene
        What is lit and seen.
    plan : Plan
        How finely.
    sight : Sight
        Its mesh, and who looks at it.
    lighting : Lighting
        What depends on place.
    spectra : Spectra
        What depends on wavelength.
    fields : Fields
        Light that the mesh throws on itself.
    """

    scene: Scene
    plan: Plan
    sight: Sight
    lighting: Lighting
    spectra: Spectra
    fields: Fields

    @property
    def geometry(self) -> Geometry:
        """The mesh."""
        return self.sight.geometry

    def relit(self, lights: Iterable[Light]) -> Stage:
        """Return the stage under other lights: what a light that moves costs."""
        scene = self.scene.replace(lights=tuple(lights))
        return _lit(scene, self.plan, self.sight, self.spectra.body)


def stage_of(
    scene: Scene, plan: Plan | None = None, geometry: Geometry | None = None
) -> Stage:
    """Make a scene ready.

    Parameters
    ----------
    scene : Scene
        What is lit and seen.
    plan : Plan, optional
        How finely; ``Plan()`` by default.
    geometry : Geometry, optional
        Of the scene's mesh, where it is at hand from :func:`geometry_of`.

    Returns
    -------
    stage : Stage
        To be shaded or traced.

    Raises
    ------
    MeshError
        If the mesh is empty, has no extent or a vertex that is not finite.
    ArgumentError
        If a light stands at the mesh's centroid, or the eye within the mesh's reach
        where all of it is to be seen.
    """
    geometry = geometry or geometry_of(scene.mesh)
    sight = Sight(geometry, scene.camera.view(geometry.in_mm))
    return _lit(scene, plan or Plan(), sight, uniform_body(scene))


def _lit(scene: Scene, plan: Plan, sight: Sight, body: Array | None) -> Stage:
    """Return the stage with what its lights and skin make of it."""
    lighting = lighting_of(scene, sight)
    spectra = spectra_of(scene, body)
    fields = fields_of(scene, sight.geometry, lighting, spectra, plan)
    return Stage(scene, plan, sight, lighting, spectra, fields)
