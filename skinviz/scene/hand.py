"""Which way a hand lies: its fingers, its back, its thumb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HandFrame:
    """Three directions at right angles that people name on a hand.

    Attributes
    ----------
    back : (3,) ndarray
        Mean normal of the back of the hand: the direction of angle 0.
    fingers : (3,) ndarray
        From the wrist to the fingertips, across ``back``.
    side : (3,) ndarray
        ``fingers × back``: to the right for a viewer of the back, fingers up.
    """

    back: Array
    fingers: Array
    side: Array

    def direction(self, angle: float) -> Array:
        """Return the direction at an angle from the back's normal.

        Positive angles lean to the viewer's left, negative to the right. [rad]
        """
        return np.asarray(np.cos(angle) * self.back - np.sin(angle) * self.side)


def hand_frame(mesh: pyvista.PolyData) -> HandFrame:
    """Find how a hand mesh lies from its shape alone.

    The longest axis points away from the wrist's opening; the thumb, which
    reaches farthest to one side, lies on the palm's side of the thinnest axis.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A hand, open at the wrist. [mm]

    Returns
    -------
    frame : HandFrame
        Back, fingers and side.

    Raises
    ------
    MeshError
        If the mesh has no opening, or no thumb can be told from its shape.
    """
    points, faces = require_triangles(mesh, "mesh")
    loops = topology.boundary_loops(faces)
    if not loops:
        raise MeshError(
            "the mesh has no opening at the wrist, so the direction of its fingers "
            "is unknown; give the view's and the lights' directions instead of angles"
        )
    widest = max(loops, key=lambda loop: float(np.ptp(points[loop], axis=0).max()))
    wrist = points[widest].mean(axis=0)
    # By area, not by vertex: meshes are often finer at the nails.
    area = topology.face_areas(points, faces)
    middles = points[faces].mean(axis=1)
    centre = np.average(middles, axis=0, weights=area)
    centred = points - centre
    spread = middles - centre
    _, axes = np.linalg.eigh((spread * area[:, None]).T @ spread)
    thin, wide, long = axes.T
    long = long * np.sign((centre - wrist) @ long)
    along = (points - wrist) @ long
    across = (points - wrist) @ wide
    depth = centred @ thin
    length = along.max()
    middle = (along > 0.2 * length) & (along < 0.8 * length)
    reach = across[middle]
    if abs(reach.max() + reach.min()) < 0.1 * length:
        raise MeshError(
            "the mesh has no thumb to tell palm from back by; give the view's and "
            "the lights' directions instead of angles"
        )
    outwards = across * np.sign(reach.max() + reach.min())
    thumb = middle & (outwards > np.quantile(outwards[middle], 0.95))
    palm = thin * np.sign(depth[thumb].mean())
    back = _mean_back_normal(points, faces, -palm, (middles - wrist) @ long)
    fingers = long - (long @ back) * back
    fingers /= np.linalg.norm(fingers)
    return HandFrame(back, fingers, np.cross(fingers, back))


def _mean_back_normal(
    points: Array, faces: NDArray[np.int64], guess: Array, along: Array
) -> Array:
    """Return the area-weighted mean normal of the hand's back, wrist to knuckles."""
    vectors = topology.face_vectors(points, faces)
    share = along / along.max()
    facing = vectors @ guess > 0.5 * np.linalg.norm(vectors, axis=1)
    back = vectors[facing & (share > 0.15) & (share < 0.45)].sum(axis=0)
    length = np.linalg.norm(back)
    return np.asarray(back / length if length > 0 else guess)
