"""Which points of views lie on each other, and what is asked of those that do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.scan import transform

Pose = NDArray[np.float64]
"""A rigid motion (4, 4)."""

_NORMALS_AGREE = np.cos(np.deg2rad(35))
_MIN_PAIRS = 50


@dataclass(frozen=True)
class Patch:
    """One view's surface samples for alignment, in the sensor's frame.

    Attributes
    ----------
    name : str
        The view's name, for messages.
    points, normals : (n, 3) ndarray of float64
        Surface points [mm] and unit normals.
    steady : (n,) ndarray of bool
        False on the patch's rim and at grazing incidence, where a nearest point
        says nothing.
    """

    name: str
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    steady: NDArray[np.bool_]


@dataclass(frozen=True)
class Pairs:
    """Points of one patch and their partners' tangent planes on another."""

    moving: int
    fixed: int
    index: NDArray[np.int_]
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    gaps: NDArray[np.float64]


def match(
    patches: tuple[Patch, ...],
    trees: list[Any],  # scipy types a KDTree by its box's size
    picks: list[NDArray[np.int_]],
    poses: tuple[Pose, ...],
    distance: float,
) -> list[Pairs]:
    """Find partners between every ordered pair of patches, in the world frame."""
    found = []
    for i, (patch, pick) in enumerate(zip(patches, picks, strict=True)):
        world = transform(poses[i], patch.points[pick])
        facing = patch.normals[pick] @ poses[i][:3, :3].T
        for j, other in enumerate(patches):
            if i == j:
                continue
            rotation = poses[j][:3, :3]
            local = (world - poses[j][:3, 3]) @ rotation
            gap, k = trees[j].query(local, distance_upper_bound=distance, workers=-1)
            near = np.flatnonzero(np.isfinite(gap))
            k = k[near]
            normals = other.normals[k] @ rotation.T
            good = other.steady[k] & (
                np.einsum("ij,ij->i", facing[near], normals) > _NORMALS_AGREE
            )
            near, k, normals = near[good], k[good], normals[good]
            partner = transform(poses[j], other.points[k])
            points = world[near]
            gaps = np.einsum("ij,ij->i", points - partner, normals)
            found.append(Pairs(i, j, near, points, normals, gaps))
    return found


def require_overlap(patches: tuple[Patch, ...], pairs: list[Pairs]) -> None:
    """Refuse a patch that no other overlaps: its pose would be a guess."""
    counts = np.zeros(len(patches), dtype=int)
    for pair in pairs:
        counts[[pair.moving, pair.fixed]] += pair.index.size
    if counts.min() < _MIN_PAIRS:
        lonely = patches[int(counts.argmin())].name
        raise MeshError(
            f"view {lonely!r} overlaps no other view ({counts.min()} matched points, "
            f"{_MIN_PAIRS} needed); check its pose in the .conf file or leave it out"
        )


def spacing(tree: Any) -> float:
    """Return the median distance of points to their nearest neighbour. [mm]"""
    gaps, _ = tree.query(tree.data[:: max(1, tree.n // 2000)], k=2)
    return float(np.median(gaps[:, 1]))
