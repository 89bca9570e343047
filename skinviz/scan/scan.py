"""What a scan is: range views with their poses, a mesh or bare points, in millimetres.

Reading files belongs in ``scan.formats``, cleaning in ``scan.clean``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import one_of
from skinviz.errors import MeshError

if TYPE_CHECKING:
    import pyvista

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 1e-3, "inch": 25.4}
"""Length of each accepted unit. [mm]"""


class MissingUnitError(MeshError):
    """Neither the file nor its reader's caller says what unit its lengths have."""


@dataclass(frozen=True)
class RangeView:
    """One view of a range scanner: a grid of points and where it was taken.

    Attributes
    ----------
    name : str
        What the view is called, usually its file name.
    points : (rows, columns, 3) ndarray of float64
        Points in the sensor's frame, NaN where there was no return. [mm]
    pose : (4, 4) ndarray of float64
        Rigid motion from the sensor's frame to the scan's.
    eye : (3,) ndarray of float64, optional
        Where the rays meet, in the sensor's frame. None if they are parallel to z,
        which then points towards the sensor. [mm]
    """

    name: str
    points: NDArray[np.float64]
    pose: NDArray[np.float64]
    eye: NDArray[np.float64] | None = None

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Grid cells with a return, shape (rows, columns)."""
        return np.asarray(np.isfinite(self.points).all(axis=-1))


@dataclass(frozen=True)
class PointCloud:
    """Points that no grid and no triangle joins.

    Attributes
    ----------
    points : (n, 3) ndarray of float64
        In the scan's frame. [mm]
    normals : (n, 3) ndarray of float64, optional
        Unit vectors, where the file has them.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Scan:
    """What a file of a scan or a mesh holds, in millimetres.

    Attributes
    ----------
    views : tuple of RangeView
        Views that keep their grid and pose.
    mesh : pyvista.PolyData or None
        Triangles, where the file had triangles.
    cloud : PointCloud or None
        Bare points, where the file had no more.
    source : str
        The file it came from.
    """

    views: tuple[RangeView, ...] = ()
    mesh: pyvista.PolyData | None = None
    source: str = field(default="", compare=False)
    cloud: PointCloud | None = None


def no_surface(cloud: PointCloud, source: str) -> MeshError:
    """Return the error that bare points meet where a surface is needed."""
    return MeshError(
        f"{source} has {len(cloud.points)} points but no faces and no grid to join "
        "them by; write the scan as range views (.conf, .ptx) or as a mesh in the "
        "scanner's program"
    )


def joined(scans: Sequence[Scan]) -> Scan:
    """Return the views of several scans as one; a single scan as it is.

    Raises
    ------
    MeshError
        If there is none, or one of several has no views.
    """
    if len(scans) == 1:
        return scans[0]
    bare = [scan.source for scan in scans if not scan.views]
    if bare or not scans:
        raise MeshError(
            f"{bare[0] if bare else 'no file'}: only files of range views can be "
            "cleaned together; give one mesh or one file of points at a time"
        )
    views = tuple(view for scan in scans for view in scan.views)
    return Scan(views=views, source=", ".join(scan.source for scan in scans))


def transform(
    pose: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Apply a rigid (4, 4) pose to points (..., 3)."""
    return points @ pose[:3, :3].T + pose[:3, 3]


def scale_to_millimetres(
    given: str | None, source: str, stated: str | None = None
) -> float:
    """Return the factor to mm, from the unit given or the one that a file states."""
    if given is not None:
        one_of(given, MILLIMETRES, "unit of length")
    if stated is not None and stated not in MILLIMETRES:
        raise MeshError(
            f"{source}: states {stated!r} as its unit of length, which is none of "
            f"{', '.join(MILLIMETRES)}; correct it or take it out"
        )
    if given is not None and stated is not None and given != stated:
        raise MeshError(
            f"{source}: the file states its unit as {stated}, and {given} was given; "
            "leave the unit out"
        )
    unit = given if given is not None else stated
    if unit is None:
        raise MissingUnitError(
            f"{source}: the format states no unit of length; say it with "
            f"unit= or --unit ({', '.join(MILLIMETRES)})"
        )
    return MILLIMETRES[unit]
