"""The wrist: where a scan of a hand ends for want of an arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.scan import topology
from skinviz.scan.merge import Merged
from skinviz.scan.topology import Faces, Points


def wrist_loop(points: Points, faces: Faces) -> NDArray[np.int64] | None:
    """Return the points around the widest opening of a hand mesh, or None.

    A scan may have other holes, with more points even; none is as wide.
    """
    loops = topology.boundary_loops(faces)
    if not loops:
        return None
    return max(loops, key=lambda loop: float(np.ptp(points[loop], axis=0).max()))


def cut_wrist(
    merged: Merged, region: NDArray[np.int64], trim: float
) -> tuple[Points, Faces]:
    """Remove an unmeasured cap and cut the surface plane behind it.

    Parameters
    ----------
    merged : Merged
        The closed surface.
    region : (k,) ndarray
        The cap's faces.
    trim : float
        How far inside the cap's rim to cut: the merged surface bends towards the
        cap before it runs out of evidence. [mm]

    Returns
    -------
    points, faces : (n, 3), (m, 3) ndarray
        The surface on the hand's side of a plane through the cap's rim.
    """
    cap = merged.faces[region]
    rim = merged.points[np.unique(topology.boundary_edges(cap))]
    centre = rim.mean(axis=0)
    _, axes = np.linalg.eigh((rim - centre).T @ (rim - centre))
    normal = axes[:, 0]
    measured = merged.points[merged.supported].mean(axis=0)
    if (measured - centre) @ normal < 0:
        normal = -normal
    deepest = float(((rim - centre) @ normal).max())
    origin = centre + (deepest + trim) * normal
    mesh = topology.polydata(merged.points, merged.faces)
    half = mesh.clip(normal=-normal, origin=origin).triangulate()
    points, faces = topology.arrays(half)
    return topology.compact(points, topology.largest_piece(len(points), faces))
