"""A laser range scanner, simulated on a known true shape.

The scanner sweeps a laser sheet across the object and watches it with a camera
at the triangulation angle, so a point is measured only where both see it.
Parallel rays stand for a scanner far from the hand. What it gets wrong, it gets
wrong as real ones do: noise that grows with incidence, spikes at depth edges,
missing grazing returns, stray outliers, quantised range, imperfect poses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import in_range, unit_vector
from skinviz.errors import ArgumentError
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles
from skinviz.scan.scan import RangeView, Scan

if TYPE_CHECKING:
    import pyvista

_MOST_RAYS = 20_000_000  # a view of them takes about 2 GB


@dataclass(frozen=True)
class Scanner:
    """How the simulated scanner samples and errs.

    Attributes
    ----------
    pitch : float
        Distance between neighbouring rays. [mm]
    triangulation_angle : float
        Angle between laser and camera. [rad]
    noise : float
        Standard deviation of range at normal incidence; grows as 1/cos. [mm]
    resolution : float
        Step to which range is rounded. [mm]
    max_incidence : float
        Returns beyond this angle from the normal are lost. [rad]
    spike : float
        Mean length of the spikes at depth edges. [mm]
    spike_fraction : float
        Share of the points beside a depth edge that spike.
    outlier_fraction : float
        Share of all points replaced by a stray range.
    pose_shift : float
        Standard deviation of each component of a pose's translation error. [mm]
    pose_tilt : float
        Standard deviation of each component of a pose's rotation error. [rad]
    """

    pitch: float = 0.8
    triangulation_angle: float = np.deg2rad(20)
    noise: float = 0.1
    resolution: float = 0.01
    max_incidence: float = np.deg2rad(75)
    spike: float = 2.0
    spike_fraction: float = 0.3
    outlier_fraction: float = 0.001
    pose_shift: float = 0.5
    pose_tilt: float = np.deg2rad(0.3)

    def __post_init__(self) -> None:
        """Refuse what no scanner could be."""
        in_range(self.pitch, 1e-3, 1e3, "pitch", "mm")
        in_range(self.triangulation_angle, 0, np.pi / 3, "triangulation angle", "rad")
        in_range(self.max_incidence, 0, np.pi / 2, "max incidence", "rad")
        for name in ("noise", "resolution", "spike", "pose_shift", "pose_tilt"):
            in_range(getattr(self, name), 0, 1e3, name)
        for name in ("spike_fraction", "outlier_fraction"):
            in_range(getattr(self, name), 0, 1, name)


def directions_around(
    n_views: int, axis: ArrayLike, start: ArrayLike
) -> NDArray[np.float64]:
    """Return directions to look from: a ring around an axis, tilted in turns.

    Alternate views lean towards and away from the axis' end, so that fingertips
    and the sides of fingers are seen as well as back and palm.

    Parameters
    ----------
    n_views : int
        How many, at least 3.
    axis : (3,) array_like
        The long axis of the object.
    start : (3,) array_like
        The first direction; its part along the axis is dropped.

    Returns
    -------
    directions : (n_views, 3) ndarray of float64
        Unit vectors from the object towards the scanner.
    """
    if n_views < 3:
        raise ArgumentError(f"n_views must be at least 3 to go around; got {n_views}")
    along = unit_vector(axis, "axis")
    first = np.asarray(start, dtype=np.float64)
    first = unit_vector(first - (first @ along) * along, "start (across the axis)")
    second = np.cross(along, first)
    turn = 2 * np.pi * np.arange(n_views) / n_views
    # 35 degrees towards the tips on odd views, 10 degrees away on even ones.
    lean = np.where(np.arange(n_views) % 2, np.deg2rad(35), np.deg2rad(-10))
    ring = np.outer(np.cos(turn), first) + np.outer(np.sin(turn), second)
    return np.asarray(np.cos(lean)[:, None] * ring + np.outer(np.sin(lean), along))


def simulate_scan(
    mesh: pyvista.PolyData,
    directions: ArrayLike,
    scanner: Scanner,
    rng: np.random.Generator,
) -> Scan:
    """Scan a true shape from several directions, with a scanner's faults.

    Parameters
    ----------
    mesh : pyvista.PolyData
        The true shape, triangles. [mm]
    directions : (n, 3) array_like
        From the object towards the scanner, one per view.
    scanner : Scanner
        How it samples and errs.
    rng : numpy.random.Generator
        The source of every random error.

    Returns
    -------
    scan : Scan
        Views in their own frames with the poses that the scanner believes; the
        first pose is exact, so the scan keeps the true shape's frame.
    """
    points, faces = require_triangles(mesh, "the true shape")
    caster = _Caster(points, faces)
    views = []
    for i, direction in enumerate(np.atleast_2d(np.asarray(directions))):
        frame = _sensor_frame(unit_vector(direction, "direction"), caster.origin)
        points = _one_view(caster, frame, scanner, rng)
        believed = frame if i == 0 else _perturbed(frame, scanner, rng)
        views.append(RangeView(f"view_{i:02d}", points, believed))
    return Scan(views=tuple(views))


class _Caster:
    """Embree's nearest-hit and occlusion queries on one mesh, parallel rays."""

    def __init__(self, vertices: NDArray[np.float64], faces: topology.Faces) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        # Near the origin float32 keeps a micrometre on a hand.
        self.origin = vertices.mean(axis=0)
        self.vertices = vertices - self.origin
        self.faces = faces
        self.radius = float(np.linalg.norm(self.vertices, axis=1).max())
        self.scene = EmbreeScene()
        TriangleMesh(
            self.scene,
            self.vertices.astype(np.float32),
            np.ascontiguousarray(faces, dtype=np.int32),
        )
        vectors = topology.face_vectors(self.vertices, faces)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        zero = np.zeros_like(vectors)
        self.normals = np.divide(vectors, length, out=zero, where=length > 0)

    def hits(
        self, origins: NDArray[np.float64], direction: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int_]]:
        """Return distance (inf for none) and face index (-1) of nearest hits."""
        start = np.ascontiguousarray(origins - self.origin, dtype=np.float32)
        along = np.broadcast_to(direction.astype(np.float32), start.shape)
        result = self.scene.run(start, np.ascontiguousarray(along), output=True)
        face = result["primID"].astype(np.int_)
        distance = np.where(face >= 0, result["tfar"], np.inf)
        return distance.astype(np.float64), face


def _sensor_frame(
    towards: NDArray[np.float64], origin: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the sensor's pose: z towards it, at the given origin."""
    helper = np.eye(3)[np.argmin(np.abs(towards))]
    x = unit_vector(np.cross(helper, towards), "sensor x axis")
    frame = np.eye(4)
    frame[:3, :3] = np.column_stack([x, np.cross(towards, x), towards])
    frame[:3, 3] = origin
    return frame


def _one_view(
    caster: _Caster,
    frame: NDArray[np.float64],
    scanner: Scanner,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return one view's grid of points (rows, columns, 3) in the sensor's frame."""
    x_axis, _, towards = frame[:3, :3].T
    local = (caster.vertices + caster.origin - frame[:3, 3]) @ frame[:3, :3]
    low, high = local.min(axis=0) - scanner.pitch, local.max(axis=0) + scanner.pitch
    columns = np.arange(low[0], high[0], scanner.pitch)
    rows = np.arange(low[1], high[1], scanner.pitch)
    if columns.size * rows.size > _MOST_RAYS:
        raise ArgumentError(
            f"a pitch of {scanner.pitch:g} mm takes {columns.size * rows.size:.1e} "
            f"rays a view; {_MOST_RAYS:.0e} at most"
        )
    grid = np.stack(np.meshgrid(columns, rows), axis=-1)
    top = 3 * caster.radius
    start = np.concatenate([grid, np.full((*grid.shape[:2], 1), top)], axis=-1)
    world = start.reshape(-1, 3) @ frame[:3, :3].T + frame[:3, 3]
    distance, face = caster.hits(world, -towards)
    hit = face >= 0
    cosine = np.where(hit, caster.normals[face] @ towards, 0.0)
    # A back face is the inside of the open wrist: a real arm would be there.
    hit &= cosine > np.cos(scanner.max_incidence)
    camera = (
        np.cos(scanner.triangulation_angle) * towards
        + np.sin(scanner.triangulation_angle) * x_axis
    )
    ground = world - np.where(hit, distance, 0.0)[:, None] * towards
    lift = 1e-4 * caster.radius
    blocked, _ = caster.hits(ground[hit] + lift * camera, camera)
    hit[np.flatnonzero(hit)[np.isfinite(blocked)]] = False
    shape = grid.shape[:2]
    height = np.where(hit, top - distance, np.nan).reshape(shape)
    height = _with_faults(height, cosine.reshape(shape), scanner, rng)
    return (
        np.concatenate([grid, height[..., None]], axis=-1)
        * np.where(np.isnan(height), np.nan, 1.0)[..., None]
    )


def _with_faults(
    height: NDArray[np.float64],
    cosine: NDArray[np.float64],
    scanner: Scanner,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return range with noise, depth-edge spikes, outliers and quantisation."""
    got = np.isfinite(height)
    sigma = scanner.noise / np.where(got, cosine, 1.0)
    noisy = height + sigma * rng.standard_normal(height.shape)
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


def _perturbed(
    frame: NDArray[np.float64], scanner: Scanner, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return a pose as the scanner believes it, off by a small rigid motion."""
    from scipy.spatial.transform import Rotation

    tilt = Rotation.from_rotvec(scanner.pose_tilt * rng.standard_normal(3))
    believed = frame.copy()
    believed[:3, :3] = tilt.as_matrix() @ frame[:3, :3]
    believed[:3, 3] += scanner.pose_shift * rng.standard_normal(3)
    return believed
