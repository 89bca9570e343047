"""What a laser scanner gets wrong: range and where it believes that it stands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.scan.scanner import Scanner


def with_faults(
    height: NDArray[np.float64],
    spread: NDArray[np.float64],
    scanner: Scanner,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return range with noise, depth-edge spikes, outliers and quantisation."""
    got = np.isfinite(height)
    noisy = height + scanner.noise * spread * rng.standard_normal(height.shape)
    edge = got & _beside_depth_edge(height, 5 * scanner.pitch)
    spiking = edge & (rng.random(height.shape) < scanner.spike_fraction)
    # Half a laser spot beyond the edge reads nearer or farther than the surface.
    side = np.where(rng.random(height.shape) < 0.5, -1.0, 1.0)
    noisy += np.where(spiking, side * rng.exponential(scanner.spike, height.shape), 0)
    stray = got & (rng.random(height.shape) < scanner.outlier_fraction)
    if np.any(got):
        span = rng.uniform(height[got].min(), height[got].max(), height.shape)
        noisy = np.where(stray, span, noisy)
    if scanner.resolution > 0:
        noisy = np.round(noisy / scanner.resolution) * scanner.resolution
    return noisy


def _beside_depth_edge(height: NDArray[np.float64], jump: float) -> NDArray[np.bool_]:
    """Return cells with a 4-neighbour that is missing or more than jump away."""
    filled = np.where(np.isfinite(height), height, -np.inf)
    padded = np.pad(filled, 1, constant_values=-np.inf)
    neighbours = (
        padded[:-2, 1:-1],
        padded[2:, 1:-1],
        padded[1:-1, :-2],
        padded[1:-1, 2:],
    )
    edge = np.zeros(height.shape, dtype=bool)
    for neighbour in neighbours:
        with np.errstate(invalid="ignore"):
            edge |= ~(np.abs(neighbour - filled) <= jump)
    return edge


def perturbed(
    frame: NDArray[np.float64], scanner: Scanner, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return a pose as the scanner believes it, off by a small rigid motion."""
    from scipy.spatial.transform import Rotation

    tilt = Rotation.from_rotvec(scanner.pose_tilt * rng.standard_normal(3))
    believed = frame.copy()
    believed[:3, :3] = tilt.as_matrix() @ frame[:3, :3]
    believed[:3, 3] += scanner.pose_shift * rng.standard_normal(3)
    return believed
