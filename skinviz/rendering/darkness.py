"""Why a picture is empty or black: what a scene's maker wants to be told."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.geometry import Geometry
from skinviz.rendering.stage import Stage


def why_dark(
    stage: Stage, xyz: NDArray[np.float32], covered: NDArray[np.uint8]
) -> Iterator[str]:
    """Yield what is wrong with a picture without light, as sentences.

    Parameters
    ----------
    stage : Stage
        What was shown.
    xyz, covered : (n, 3), (n,) ndarray
        What was seen.
    """
    geometry, lights = stage.geometry, stage.lighting.lights
    if not covered.any():
        yield "the picture is empty: no ray meets the mesh; check target and height"
        return
    if xyz.any():
        return
    if _inside_out(geometry):
        yield (
            "the picture is black: the mesh's normals point inwards, so only its "
            "inside is seen; turn its faces over (skinviz clean does)"
        )
        return
    for number, light in enumerate(lights, 1):
        if light[3] and abs(geometry.winding(light[:3])) > 0.5:
            yield f"light {number} is inside the mesh and lights nothing that is seen"
        else:
            yield f"light {number} is behind everything that the camera sees"
    if stage.scene.diffuse_scale == 0:
        yield "diffuse_scale is 0: only the surface's own reflection is left"


def _inside_out(geometry: Geometry) -> bool:
    """Return whether a mesh's faces look to its inside."""
    a, b, c = (geometry.points[geometry.faces[:, k]] for k in range(3))
    return bool(np.einsum("ij,ij->", a - geometry.centroid, np.cross(b - a, c - a)) < 0)
