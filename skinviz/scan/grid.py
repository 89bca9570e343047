"""Triangles of a range grid: neighbours joined, but not over a depth jump.

A triangle that is seen at a grazing angle or is too long is a bridge over a jump:
that is how one looks from the scanner. Noise of range tilts triangles as well, so
that angles are judged after smoothing that reaches as far as the noise asks for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.scan import topology
from skinviz.scan.smoothing import range_noise, smoothed
from skinviz.scan.topology import Faces, Points

_ROUNDS = 16.0  # of smoothing where range errs by as much as rays are apart
_MOST_ROUNDS = 100
_DEVIATIONS = 2.0  # of a slope by noise; what is steeper before smoothing goes

Eye = NDArray[np.float64] | None
"""Where rays meet, (3,) [mm]; None if they are parallel to z, towards the sensor."""


def triangulate(
    points: NDArray[np.float64],
    max_incidence: float,
    eye: Eye = None,
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
    flat, faces = _joined(points, range_of(points, eye))
    towards = _cosines(flat, faces, eye)
    if towards.sum() < 0:  # grids may run either way round
        faces, towards = faces[:, ::-1], -towards
    noise = relative_noise(points, eye)
    steepest = np.arctan(np.tan(max_incidence) + _DEVIATIONS * np.sqrt(2) * noise)
    good = towards > np.cos(steepest)
    good &= _longest(flat, faces) <= max_stretch * _step(points)
    smooth = smoothed(flat, faces[good], smoothing_rounds(noise))
    good[good] = _cosines(smooth, faces[good], eye) > np.cos(max_incidence)
    return flat, faces[good], int((~good).sum())


def _joined(
    points: NDArray[np.float64], height: NDArray[np.float64]
) -> tuple[Points, Faces]:
    """Return a grid's returns and all triangles of neighbours, turned alike."""
    valid = np.isfinite(points).all(axis=-1)
    index = np.full(valid.shape, -1, dtype=np.int64)
    index[valid] = np.arange(valid.sum())
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
    return points[valid], faces[(faces >= 0).all(axis=1)]


def range_of(points: NDArray[np.float64], eye: Eye) -> NDArray[np.float64]:
    """Return the range of points (..., 3), up to its sign and origin. [mm]"""
    return points[..., 2] if eye is None else np.linalg.norm(points - eye, axis=-1)


def rays_towards(points: NDArray[np.float64], eye: Eye) -> NDArray[np.float64]:
    """Return the unit vectors from points (..., 3) towards the sensor."""
    if eye is None:
        return np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    rays = eye - points
    length = np.linalg.norm(rays, axis=-1, keepdims=True)
    return np.asarray(rays / np.where(length > 0, length, 1))


def _cosines(points: Points, faces: Faces, eye: Eye) -> NDArray[np.float64]:
    """Return the cosine of each face's incidence; zero where it has no area."""
    vectors = topology.face_vectors(points, faces)
    along = np.einsum(
        "ij,ij->i", vectors, rays_towards(points[faces].mean(axis=1), eye)
    )
    length = np.linalg.norm(vectors, axis=1)
    return np.asarray(along / np.where(length > 0, length, 1))


def relative_noise(points: NDArray[np.float64], eye: Eye) -> float:
    """Return the noise of a grid's range over the distance of its rays."""
    rays = rays_towards(points, eye)
    steps = []
    for axis in (0, 1):
        step, ray = np.diff(points, axis=axis), np.delete(rays, -1, axis=axis)
        along = np.einsum("ijk,ijk->ij", step, ray)
        steps.append(step - along[..., None] * ray)
    pitch = _median_length(steps)
    return range_noise(range_of(points, eye)) / pitch if pitch > 0 else 0.0


def smoothing_rounds(noise: float) -> int:
    """Return how many rounds of smoothing a grid's relative noise asks for."""
    return int(min(np.rint(_ROUNDS * noise), _MOST_ROUNDS))


def _longest(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return the longest edge of each face. [mm]"""
    corners = points[faces]
    edges = corners - np.roll(corners, 1, axis=1)
    return np.asarray(np.sqrt(np.einsum("ijk,ijk->ij", edges, edges).max(axis=1)))


def _step(points: NDArray[np.float64]) -> float:
    """Return the median distance of neighbours along a grid; inf if there are none."""
    return _median_length([np.diff(points, axis=axis) for axis in (0, 1)])


def _median_length(steps: list[NDArray[np.float64]]) -> float:
    """Return the median length of vectors (..., 3) that are known; inf for none."""
    length = np.concatenate([np.linalg.norm(s, axis=-1).ravel() for s in steps])
    length = length[np.isfinite(length)]
    return float(np.median(length)) if length.size else np.inf
