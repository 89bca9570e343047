"""What is on the bench while a scan is cleaned: it changes from step to step."""

from __future__ import annotations

from dataclasses import dataclass

from skinviz.errors import MeshError
from skinviz.scan.checks import require_hand_size, require_triangles
from skinviz.scan.merge import Merged
from skinviz.scan.partners import Patch, Pose
from skinviz.scan.scan import PointCloud, RangeView, Scan, no_surface
from skinviz.scan.topology import Faces, Points

Counts = dict[str, float | int]
"""What a step found and changed, by name."""


@dataclass(frozen=True)
class Surface:
    """A triangle mesh as arrays.

    Attributes
    ----------
    points : (n, 3) ndarray of float64
        [mm]
    faces : (m, 3) ndarray of int64
        Corners of the triangles.
    """

    points: Points
    faces: Faces


@dataclass(frozen=True)
class Workpiece:
    """What a scan has become so far; a step reads some of it and puts some in.

    Attributes
    ----------
    source : str
        What it is called in messages.
    views : tuple of RangeView
        Raw views.
    patches : tuple of Patch
        Their trustworthy parts, each in its sensor's frame.
    poses : tuple of (4, 4) ndarray
        Where the patches lie.
    cloud : PointCloud, optional
        Oriented points in the scan's frame.
    merged : Merged, optional
        A closed surface that knows where it is supported.
    surface : Surface, optional
        A mesh.
    """

    source: str
    views: tuple[RangeView, ...] = ()
    patches: tuple[Patch, ...] = ()
    poses: tuple[Pose, ...] = ()
    cloud: PointCloud | None = None
    merged: Merged | None = None
    surface: Surface | None = None


def workpiece(scan: Scan) -> Workpiece:
    """Return a scan as it lies before the first step.

    Raises
    ------
    MeshError
        If there is nothing in it, or points that have no normals.
    """
    source = scan.source or "scan"
    if scan.views:
        return Workpiece(source, views=scan.views)
    if scan.mesh is not None:
        points, faces = require_triangles(scan.mesh, scan.source or "mesh")
        require_hand_size(points, scan.source or "mesh")
        return Workpiece(source, surface=Surface(points, faces))
    if scan.cloud is None:
        raise MeshError(f"{source} has neither views nor a mesh")
    if scan.cloud.normals is None:
        raise no_surface(scan.cloud, source)
    require_hand_size(scan.cloud.points, source)
    return Workpiece(source, cloud=scan.cloud)
