"""Plane sections of a mesh across an axis, and where an arm is narrowest by them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_COUNT = 64
_NARROWED = 0.75  # of the hand's largest section: the wrist has begun
_WIDENED = 1.15  # of the narrowest section since: the forearm has
_HAND = 0.3  # of the largest section of all: smaller ones are still fingers


@dataclass(frozen=True)
class Section:
    """Where a plane cuts a mesh.

    Attributes
    ----------
    starts, ends : (k, 3) ndarray
        Ends of the cut of each triangle, all running the same way round. [mm]
    """

    starts: Array
    ends: Array

    @property
    def centre(self) -> Array:
        """The mean of the cuts, each by its length. [mm]"""
        length = np.linalg.norm(self.ends - self.starts, axis=1)
        if length.sum() == 0:
            return np.asarray(self.starts.mean(axis=0))
        return np.asarray(
            np.average((self.starts + self.ends) / 2, axis=0, weights=length)
        )

    def area(self, axis: Array) -> float:
        """Return the area inside, the plane's normal given. [mm²]"""
        if len(self.starts) == 0:
            return 0.0
        middle = self.centre
        around = np.cross(self.starts - middle, self.ends - middle)
        return float(abs(around.sum(axis=0) @ axis) / 2)

    def width(self, direction: Array) -> float:
        """Return how far it reaches along a direction. [mm]"""
        return float(np.ptp(self.starts @ direction)) if len(self.starts) else np.inf


def sections(
    points: Array, faces: NDArray[np.int64], height: Array, levels: ArrayLike
) -> list[Section]:
    """Return where a mesh is cut at several heights.

    Parameters
    ----------
    points, faces : (n, 3), (m, 3) ndarray
        The mesh. [mm]
    height : (n,) ndarray
        Of the points. [mm]
    levels : (k,) array_like
        Where to cut. [mm]
    """
    a, b, c = height[faces].T
    low = np.minimum(np.minimum(a, b), c)
    high = np.maximum(np.maximum(a, b), c)
    return [
        _section(points, faces[(low <= level) & (high > level)], height - level)
        for level in np.asarray(levels, dtype=np.float64)
    ]


def _section(points: Array, faces: NDArray[np.int64], height: Array) -> Section:
    """Return where faces that all reach to both sides of height 0 are cut there."""
    above = height[faces] > 0
    alone = above.sum(axis=1) == 1
    # The corner that is alone on its side of the plane, then the other two in turn.
    first = np.argmax(above == alone[:, None], axis=1)
    a, b, c = (faces[np.arange(len(faces)), (first + k) % 3] for k in range(3))
    share_b = (height[a] / (height[a] - height[b]))[:, None]
    share_c = (height[a] / (height[a] - height[c]))[:, None]
    on_b = points[a] + share_b * (points[b] - points[a])
    on_c = points[a] + share_c * (points[c] - points[a])
    up = alone[:, None]
    return Section(np.where(up, on_b, on_c), np.where(up, on_c, on_b))


def narrowest(
    points: Array, faces: NDArray[np.int64], axis: Array, opening: float
) -> float | None:
    """Return where along an axis a hand ends and its arm is narrowest. [mm]

    From the fingertips on sections grow until the palm, shrink until the wrist and
    grow again along the forearm. None if they do not shrink before the opening.

    Parameters
    ----------
    points, faces : (n, 3), (m, 3) ndarray
        A hand. [mm]
    axis : (3,) ndarray
        From the opening to the fingertips.
    opening : float
        Its opening's end, along the axis. [mm]
    """
    along = points @ axis
    heights = np.linspace(float(along.max()), opening, _COUNT + 2)[1:-1]
    cuts = sections(points, faces, along, heights)
    areas = np.array([cut.area(axis) for cut in cuts])
    largest = np.maximum.accumulate(areas)
    wrist = (areas < _NARROWED * largest) & (largest > _HAND * areas.max())
    if not wrist.any():
        return None
    begin = int(wrist.argmax())
    rest = np.where(areas > 0, areas, np.inf)[begin:]  # a gap is no wrist
    risen = rest > _WIDENED * np.minimum.accumulate(rest)
    end = int(risen.argmax()) if risen.any() else len(rest)
    return float(heights[begin + int(rest[:end].argmin())])
