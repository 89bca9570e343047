"""Bare points: what all their readers share, and PLY files without faces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.checks import to_millimetres
from skinviz.scan.formats.content import stated_unit
from skinviz.scan.formats.ply import Ply, columns
from skinviz.scan.scan import PointCloud, scale_to_millimetres

_NORMALS = ("nx", "ny", "nz")
_UNIT_LENGTH = 0.02  # normals are written with two digits at least


def point_cloud(
    points: NDArray[np.float64],
    path: Path,
    unit: str | None,
    *,
    stated: str | None = None,
    normals: NDArray[np.float64] | None = None,
) -> PointCloud:
    """Return points, and what may be their normals, in mm, or refuse them."""
    if len(points) == 0:
        raise MeshError(f"{path} has no points")
    scale = scale_to_millimetres(unit, str(path), stated)
    placed = to_millimetres(points, scale, str(path))
    if normals is None:
        return PointCloud(placed)
    if not are_normals(normals):
        raise MeshError(f"{path}: its normals are not of length 1; leave them out")
    return PointCloud(placed, normals / np.linalg.norm(normals, axis=1, keepdims=True))


def are_normals(vectors: NDArray[np.float64]) -> bool:
    """Return whether all vectors (n, 3) have length 1, as colours never do."""
    with np.errstate(over="ignore"):  # of what is then no normal
        length = np.linalg.norm(vectors, axis=1)
    return bool((np.abs(length - 1) < _UNIT_LENGTH).all())


def cloud_from_ply(ply: Ply, path: Path, unit: str | None) -> PointCloud:
    """Return the points of a PLY file without faces. [mm]"""
    vertex = ply.elements.get("vertex")
    points = columns(vertex, "xyz", path)
    has_normals = vertex is not None and all(k in vertex.scalars for k in _NORMALS)
    return point_cloud(
        points,
        path,
        unit,
        stated=stated_unit(ply.comments),
        normals=columns(vertex, _NORMALS, path) if has_normals else None,
    )
