"""Rigid alignment of overlapping views, all poses solved for together.

Every view is matched with every other by nearest points; the squared distances
to the tangent planes are summed over all pairs and minimised over all poses at
once, so no error accumulates around the ring of views as it does when views are
aligned one after another. The first view keeps its pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.scan.partners import Pairs, Patch, Pose, match, require_overlap, spacing
from skinviz.scan.scan import transform

_SETTLED = 2e-3  # mm


@dataclass(frozen=True)
class Alignment:
    """Aligned poses and how well they agree.

    Attributes
    ----------
    poses : tuple of (4, 4) ndarray
        One per patch; the first is the one given.
    overlap : (n,) ndarray of float64
        Share of each patch's points that found a partner in another.
    residual : float
        RMS distance of partners to each other's tangent planes. [mm]
    moved : (n,) ndarray of float64
        How far each patch's centre was moved. [mm]
    iterations : int
        Rounds of matching and solving.
    settled : bool
        Whether the last round moved no patch by more than a few micrometres.
    """

    poses: tuple[Pose, ...]
    overlap: NDArray[np.float64]
    residual: float
    moved: NDArray[np.float64]
    iterations: int
    settled: bool


def align_patches(
    patches: tuple[Patch, ...],
    poses: tuple[Pose, ...],
    *,
    reach: float = 6.0,
    max_iterations: int = 60,
    samples: int = 4000,
) -> Alignment:
    """Refine poses until overlapping patches lie on each other.

    Multi-view point-to-plane ICP [1]_, Gauss–Newton on all poses together with
    Cauchy weights, the reach of matching shrinking towards the residual.

    Parameters
    ----------
    patches : tuple of Patch
        At least one; the first one's pose is kept.
    poses : tuple of (4, 4) ndarray
        Where the scanner believes they are, right to about ``reach``.
    reach : float
        Largest distance between partners at the start. [mm]
    max_iterations : int
        Rounds after which to stop.
    samples : int
        Points of each patch that look for partners.

    Returns
    -------
    alignment : Alignment
        Poses, overlap and residual.

    Raises
    ------
    MeshError
        If a patch overlaps no other within reach.

    References
    ----------
    .. [1] Y. Chen and G. Medioni, Image Vision Comput. 10:145 (1992).
    """
    from scipy.spatial import KDTree

    if len(patches) == 1:
        zero = np.zeros(1)
        return Alignment(poses, zero, 0.0, zero, 0, settled=True)
    trees = [KDTree(patch.points) for patch in patches]
    # Evenly spaced samples make the result independent of any random state.
    picks = [
        np.linspace(0, len(p.points) - 1, min(samples, len(p.points))).astype(int)
        for p in patches
    ]
    centres = [patch.points.mean(axis=0) for patch in patches]
    start = poses
    # Partners can be no nearer than the samples are apart, however good the poses.
    nearest = 2 * max(spacing(tree) for tree in trees)
    scale, residual, distance = reach / 3, np.inf, max(reach, nearest)
    iterations, settled = 0, False
    while iterations < max_iterations and not settled:
        iterations += 1
        pairs = match(patches, trees, picks, poses, distance)
        require_overlap(patches, pairs)
        step, residual = _solve(pairs, len(patches), scale)
        start_of_round = poses
        poses = tuple(map(_compose, step, poses))
        scale = max(1.5 * residual, 1e-6)
        distance = float(np.clip(6 * residual, nearest, distance))
        settled = max(map(_shift, start_of_round, poses, centres)) < _SETTLED
    pairs = match(patches, trees, picks, poses, distance)
    moved = np.array(list(map(_shift, start, poses, centres)))
    overlap = _overlap(pairs, picks)
    return Alignment(poses, overlap, residual, moved, iterations, settled)


def _overlap(pairs: list[Pairs], picks: list[NDArray[np.int_]]) -> NDArray[np.float64]:
    """Return which share of each patch's picked points has a partner in any other."""
    found = [
        np.unique(np.concatenate([p.index for p in pairs if p.moving == i])).size
        for i in range(len(picks))
    ]
    return np.array(found) / [pick.size for pick in picks]


def _solve(
    pairs: list[Pairs], n_patches: int, scale: float
) -> tuple[NDArray[np.float64], float]:
    """Return the joint Gauss–Newton step (n, 6) and the weighted RMS gap."""
    centre = np.mean(np.concatenate([p.points for p in pairs]), axis=0)
    normal = np.zeros((n_patches, 6, n_patches, 6))
    right = np.zeros((n_patches, 6))
    total, count = 0.0, 0.0
    for pair in pairs:
        row = np.hstack([np.cross(pair.points - centre, pair.normals), pair.normals])
        weight = 1 / (1 + (pair.gaps / scale) ** 2)
        block = (row * weight[:, None]).T @ row
        pull = row.T @ (weight * pair.gaps)
        i, j = pair.moving, pair.fixed
        normal[i, :, i] += block
        normal[j, :, j] += block
        normal[i, :, j] -= block
        normal[j, :, i] -= block
        right[i] -= pull
        right[j] += pull
        total += float(weight @ pair.gaps**2)
        count += float(weight.sum())
    size = 6 * (n_patches - 1)
    matrix = normal.reshape(6 * n_patches, -1)[6:, 6:]
    # A surface of revolution leaves a motion undetermined: hold it, don't blow up.
    matrix += 1e-9 * np.trace(matrix) / size * np.eye(size)
    twists = np.zeros((n_patches, 6))
    twists[1:] = np.linalg.solve(matrix, right[1:].reshape(-1)).reshape(-1, 6)
    # Translations are about the common centre; carry them to the origin.
    twists[:, 3:] -= np.cross(twists[:, :3], centre)
    return twists, float(np.sqrt(total / count))


def _shift(old: Pose, new: Pose, point: NDArray[np.float64]) -> float:
    """Return how far a change of pose moves a point. [mm]"""
    return float(np.linalg.norm(transform(new, point) - transform(old, point)))


def _compose(twist: NDArray[np.float64], pose: Pose) -> Pose:
    """Return a pose after a small rotation vector and translation."""
    from scipy.spatial.transform import Rotation

    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec(twist[:3]).as_matrix()
    motion[:3, 3] = twist[3:]
    return motion @ pose
