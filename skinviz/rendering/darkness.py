"""Why a picture is empty or black: what a scene's maker wants to be told."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering import trace
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.stage import Stage

_PIXELS = 2**12  # that are looked at for a reason
_SHARE = 0.01  # of what is seen; less are rims, which light from behind just reaches


def why_dark(
    stage: Stage, xyz: NDArray[np.float32], covered: NDArray[np.uint8]
) -> Iterator[str]:
    """Yield what is wrong with a picture that is all but black, as sentences.

    Parameters
    ----------
    stage : Stage
        What was shown.
    xyz, covered : (n, 3), (n,) ndarray
        What was seen.
    """
    if not covered.any():
        yield "the picture is empty: no ray meets the mesh; check target and height"
        return
    pixels = np.flatnonzero(covered)
    if np.count_nonzero(xyz[:, 1]) > _SHARE * pixels.size:
        return
    pixels = pixels[:: -(-pixels.size // _PIXELS)]
    hits = trace.cast(stage.sight, stage.plan.cells, pixels)
    if hits.pixels.size == 0:
        yield _only_inside(stage.geometry)
        return
    missed = [
        _why_missed(stage, hits, k) for k in range(len(stage.colours.lighting.lights))
    ]
    yield from filter(None, missed)
    if None in missed and not xyz.any():
        yield _why_absorbed(stage)


def _only_inside(geometry: Geometry) -> str:
    """Return what to do where only the backs of triangles are seen."""
    if _inside_out(geometry):
        return (
            "the picture is black: the mesh's normals point inwards, so only its "
            "inside is seen; turn its faces over (skinviz clean does)"
        )
    return (
        "the picture is black: only the inside of the mesh is seen; look from its "
        "other side, or turn its faces over"
    )


def _why_missed(stage: Stage, hits: trace.Hits, k: int) -> str | None:
    """Return why a light does not reach what is seen; None if it does."""
    light = stage.colours.lighting.lights[k]
    if light[3] and abs(stage.geometry.winding(light[:3])) > 0.5:
        return f"light {k + 1} is inside the mesh and lights nothing that is seen"
    towards = light[:3, None] - light[3] * hits.points
    facing = np.einsum("xn,xn->n", hits.normals, towards) > 0
    if facing.mean() <= _SHARE:
        return f"light {k + 1} is behind everything that the camera sees"
    if stage.plan.shadows:
        visible = trace.visibility(
            stage.geometry,
            stage.colours.lighting,
            hits.lifted,
            hits.normals,
            hits.facets,
        )
        if visible[k].mean() <= _SHARE:
            return f"the mesh hides light {k + 1} from everything that the camera sees"
    return None


def _why_absorbed(stage: Stage) -> str:
    """Return why nothing is seen of light that reaches the mesh."""
    if stage.scene.diffuse_scale == 0:
        return (
            "the picture is black: diffuse_scale is 0, and the surface reflects "
            "nothing towards the camera"
        )
    return (
        "the picture is black: the skin absorbs all of the light that reaches it, or "
        "leaves less than float32 holds; check the skin and the exposure"
    )


def _inside_out(geometry: Geometry) -> bool:
    """Return whether a mesh's faces look to its inside."""
    a, b, c = (geometry.points[geometry.faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a - geometry.centroid, np.cross(b - a, c - a))
    return bool(volume < -1e-9)  # that of a plate is 0 but for rounding
