"""From one range view to a trustworthy patch of triangles.

Neighbouring grid cells are joined unless the triangle is seen at a grazing angle
or is too long: that is how a bridge over a depth jump looks from the scanner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.align import Patch
from skinviz.scan.scan import RangeView
from skinviz.scan.topology import Faces, Points

_NORMAL_SMOOTHING_ROUNDS = 3


@dataclass(frozen=True)
class PatchCounts:
    """What was found and dropped in making one view's patch."""

    returns: int
    bridges: int
    island_faces: int
    rim_faces: int
    faces: int


def triangulate(
    points: NDArray[np.float64],
    max_incidence: float,
    eye: NDArray[np.float64] | None = None,
    max_stretch: float = np.inf,
) -> tuple[Points, Faces, int]:
    """Join neighbouring returns of a grid into triangles, without bridges.

    Parameters
    ----------
    points : (rows, columns, 3) ndarray
        Grid in the sensor's frame, NaN for no return. [mm]
    max_incidence : float
        Triangles seen at a larger angle from their normal are dropped. [rad]
    eye : (3,) ndarray, optional
        Where the rays meet; None if they are parallel to z, which points towards
        the sensor. [mm]

    Returns
    -------
    points, faces : (n, 3), (m, 3) ndarray
        The returns and the triangles that face the sensor.
    n_bridges : int
        Triangles dropped as too grazing or too long.
    """
    valid = np.isfinite(points).all(axis=-1)
    index = np.full(valid.shape, -1, dtype=np.int64)
    index[valid] = np.arange(valid.sum())
    height = points[..., 2] if eye is None else np.linalg.norm(points - eye, axis=-1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    down = np.abs(height[:-1, :-1] - height[1:, 1:])
    up = np.abs(height[:-1, 1:] - height[1:, :-1])
    # The diagonal with the smaller step; with one corner missing, the whole one.
    first = (np.nan_to_num(down, nan=np.inf) <= np.nan_to_num(up, nan=np.inf)).ravel()
    split_first = [(a, b, c), (a, c, d)]
    split_second = [(a, b, d), (b, c, d)]
    faces = np.concatenate(
        [np.stack([k.ravel() for k in t], axis=1)[first] for t in split_first]
        + [np.stack([k.ravel() for k in t], axis=1)[~first] for t in split_second]
    )
    faces = faces[(faces >= 0).all(axis=1)]
    flat = points[valid]
    normals = topology.face_vectors(flat, faces)
    towards = normals[:, 2] if eye is None else _towards(eye, flat, faces, normals)
    if towards.sum() < 0:  # grids may run either way round
        faces, towards = faces[:, ::-1], -towards
    length = np.linalg.norm(normals, axis=1)
    good = towards > np.cos(max_incidence) * length
    good &= _longest(flat, faces) <= max_stretch * _step(points)
    return flat, faces[good], int((~good).sum())


def _longest(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return the longest edge of each face. [mm]"""
    corners = points[faces]
    edges = corners - np.roll(corners, 1, axis=1)
    return np.asarray(np.sqrt(np.einsum("ijk,ijk->ij", edges, edges).max(axis=1)))


def _step(points: NDArray[np.float64]) -> float:
    """Return the median distance of neighbours along a grid; inf if there are none."""
    steps = [np.linalg.norm(np.diff(points, axis=k), axis=-1).ravel() for k in (0, 1)]
    both = np.concatenate(steps)
    both = both[np.isfinite(both)]
    return float(np.median(both)) if both.size else np.inf


def _towards(
    eye: NDArray[np.float64], points: Points, faces: Faces, vectors: Points
) -> NDArray[np.float64]:
    """Return the part of each face's vector that points to where the rays meet."""
    rays = eye - points[faces].mean(axis=1)
    length = np.linalg.norm(rays, axis=1)
    along = np.einsum("ij,ij->i", vectors, rays)
    return np.asarray(along / np.where(length > 0, length, 1))


def drop_islands(n_points: int, faces: Faces, min_faces: int) -> Faces:
    """Drop connected pieces of fewer than ``min_faces`` triangles."""
    if len(faces) == 0:
        return faces
    labels = topology.face_components(n_points, faces)
    return faces[np.bincount(labels)[labels] >= min_faces]


def erode_rim(faces: Faces, rings: int) -> Faces:
    """Drop the triangles that touch the boundary, as often as told."""
    for _ in range(rings):
        rim = np.unique(topology.boundary_edges(faces))
        faces = faces[~np.isin(faces, rim).any(axis=1)]
    return faces


def make_patch(
    view: RangeView,
    *,
    max_incidence: float = np.deg2rad(75),
    max_stretch: float = np.inf,
    min_island: int = 200,
    rim_rings: int = 1,
) -> tuple[Patch, Faces, PatchCounts]:
    """Turn a range view into a patch: triangles, no bridges, islands or rim.

    Parameters
    ----------
    view : RangeView
        The grid.
    max_incidence : float
        Angle beyond which a triangle counts as a bridge. [rad]
    max_stretch : float
        Triangles with a longer edge, in median steps of the grid, are bridges too.
    min_island : int
        Pieces of fewer triangles are outliers.
    rim_rings : int
        Rings of triangles taken off the boundary, where spikes live.

    Returns
    -------
    patch : Patch
        Points and smoothed normals in the sensor's frame.
    faces : (m, 3) ndarray
        Its triangles.
    counts : PatchCounts
        What was dropped.

    Raises
    ------
    MeshError
        If nothing is left.
    """
    points, all_faces, bridges = triangulate(
        view.points, max_incidence, view.eye, max_stretch
    )
    kept = drop_islands(len(points), all_faces, min_island)
    inner = drop_islands(len(points), erode_rim(kept, rim_rings), min_island)
    if len(inner) == 0:
        raise MeshError(
            f"view {view.name!r} has no surface left: {len(points)} returns gave "
            f"{len(all_faces)} triangles, none in a piece of {min_island} or more; "
            "check that it is a range grid of the object, or leave it out"
        )
    points, faces = topology.compact(points, inner)
    interior = np.ones(len(points), dtype=bool)
    interior[np.unique(topology.boundary_edges(faces))] = False
    patch = Patch(view.name, points, _smooth_normals(points, faces), interior)
    counts = PatchCounts(
        returns=int(view.valid.sum()),
        bridges=bridges,
        island_faces=len(all_faces) - len(kept),
        rim_faces=len(kept) - len(inner),
        faces=len(faces),
    )
    return patch, faces, counts


def _smooth_normals(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return vertex normals averaged over neighbours, against range noise."""
    from scipy.sparse import coo_matrix

    edges, _ = topology.edge_counts(faces)
    n = len(points)
    ones = np.ones(len(edges))
    half = coo_matrix((ones, (edges[:, 0], edges[:, 1])), (n, n)).tocsr()
    neighbours = half + half.T
    normals = topology.vertex_normals(points, faces)
    for _ in range(_NORMAL_SMOOTHING_ROUNDS):
        normals = normals + 0.3 * (neighbours @ normals)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals
