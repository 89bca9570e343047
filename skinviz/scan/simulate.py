"""A laser range scanner, simulated on a known true shape.

The scanner sweeps a laser sheet across the object and watches it with a camera
at the triangulation angle, so a point is measured only where both see it.
Parallel rays stand for a scanner far from the hand. What it gets wrong, it gets
wrong as real ones do: noise that grows with range and incidence, spikes at depth
edges, missing grazing and dark returns, stray outliers, quantised range, imperfect
poses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import unit_vector
from skinviz.errors import ArgumentError
from skinviz.scan.caster import Caster
from skinviz.scan.checks import require_triangles
from skinviz.scan.faults import perturbed, with_faults
from skinviz.scan.scan import RangeView, Scan, transform
from skinviz.scan.scanner import Scanner

if TYPE_CHECKING:
    import pyvista

__all__ = ["Scanner", "directions_around", "simulate_scan"]

_MOST_RAYS = 20_000_000  # a view of them takes about 2 GB


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
        The true shape, triangles. [mm] Its point data ``albedo``, if it has any, say
        how much of the laser's light each point sends back. [1]
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
    albedo = _albedo(mesh, len(points))
    caster = Caster(points, faces)
    views = []
    for i, direction in enumerate(np.atleast_2d(np.asarray(directions))):
        frame = _sensor_frame(unit_vector(direction, "direction"), caster.origin)
        points, eye = _one_view(caster, frame, scanner, albedo, rng)
        believed = frame if i == 0 else perturbed(frame, scanner, rng)
        views.append(RangeView(f"view_{i:02d}", points, believed, eye))
    return Scan(views=tuple(views))


def _albedo(mesh: pyvista.PolyData, n_points: int) -> NDArray[np.float64]:
    """Return how much laser light each point sends back, 1 where not said."""
    if "albedo" not in mesh.point_data:
        return np.ones(n_points)
    albedo = np.asarray(mesh.point_data["albedo"], dtype=np.float64)
    if albedo.shape != (n_points,) or not ((albedo >= 0) & (albedo <= 1)).all():
        raise ArgumentError(
            "the mesh's point data 'albedo' must be numbers from 0 to 1"
        )
    return albedo


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


@dataclass(frozen=True)
class _Rays:
    """A view's rays in the sensor's frame: z towards it, the origin in the object."""

    starts: NDArray[np.float64]  # (rows, columns, 3), where the range is 0
    away: NDArray[np.float64]  # (rows, columns, 3), unit vectors
    before: float  # how far before its start each one begins
    eye: NDArray[np.float64] | None  # where they meet


def _rays(caster: Caster, frame: NDArray[np.float64], scanner: Scanner) -> _Rays:
    """Return the rays of a grid that covers the object."""
    local = caster.vertices @ frame[:3, :3]
    flat = local[:, :2]
    if np.isfinite(scanner.distance):
        if scanner.distance < 2 * caster.radius:
            raise ArgumentError(
                f"distance must be at least twice the object's radius of "
                f"{caster.radius:.4g} mm; got {scanner.distance:g} mm"
            )
        flat = flat / (1 - local[:, 2:] / scanner.distance)
    low, high = flat.min(axis=0) - scanner.pitch, flat.max(axis=0) + scanner.pitch
    columns = np.arange(low[0], high[0], scanner.pitch)
    rows = np.arange(low[1], high[1], scanner.pitch)
    if columns.size * rows.size > _MOST_RAYS:
        raise ArgumentError(
            f"a pitch of {scanner.pitch:g} mm takes {columns.size * rows.size:.1e} "
            f"rays a view; {_MOST_RAYS:.0e} at most"
        )
    grid = np.stack([*np.meshgrid(columns, rows), np.zeros((rows.size, columns.size))])
    grid = np.moveaxis(grid, 0, -1)
    if not np.isfinite(scanner.distance):
        down = np.broadcast_to([0.0, 0.0, -1.0], grid.shape)
        return _Rays(grid, down, 3 * caster.radius, None)
    eye = np.array([0.0, 0.0, scanner.distance])
    away = (grid - eye) / np.linalg.norm(grid - eye, axis=-1, keepdims=True)
    return _Rays(np.broadcast_to(eye, grid.shape), away, 0.0, eye)


def _one_view(
    caster: Caster,
    frame: NDArray[np.float64],
    scanner: Scanner,
    albedo: NDArray[np.float64],
    rng: np.random.Generator,
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Return one view's grid of points in the sensor's frame, and its eye."""
    rays = _rays(caster, frame, scanner)
    shape = rays.starts.shape[:2]
    world = transform(frame, rays.starts.reshape(-1, 3))
    away = rays.away.reshape(-1, 3) @ frame[:3, :3].T
    distance, face = caster.hits(world - rays.before * away, away)
    distance -= rays.before
    hit = face >= 0
    cosine = np.where(hit, -np.einsum("ij,ij->i", caster.normals[face], away), 0.0)
    # A back face is the inside of the open wrist: a real arm would be there.
    hit &= cosine > np.cos(scanner.max_incidence)
    ground = world + np.where(hit, distance, 0.0)[:, None] * away
    far = (
        distance / scanner.distance if rays.eye is not None else np.ones_like(distance)
    )
    weights = caster.weights(ground[hit], face[hit])
    bright = np.einsum("ij,ij->i", weights, albedo[caster.faces[face[hit]]])
    hit[hit] = bright * cosine[hit] >= scanner.min_return * far[hit] ** 2
    hit[hit] = ~_hidden(caster, frame, scanner, ground[hit])
    spread = np.where(hit, far**2 / np.where(hit, cosine, 1.0), 1.0)
    height = np.where(hit, -distance, np.nan).reshape(shape)
    height = with_faults(height, spread.reshape(shape), scanner, rng)
    points = rays.starts - height[..., None] * rays.away
    return points, rays.eye


def _hidden(
    caster: Caster,
    frame: NDArray[np.float64],
    scanner: Scanner,
    places: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Return which places the camera does not see."""
    x_axis, _, towards = frame[:3, :3].T
    if np.isfinite(scanner.distance):
        camera = frame[:3, 3] + scanner.distance * towards + scanner.baseline * x_axis
        seen_from = camera - places
        seen_from /= np.linalg.norm(seen_from, axis=1, keepdims=True)
    else:
        angle = scanner.triangulation_angle
        seen_from = np.cos(angle) * towards + np.sin(angle) * x_axis
    lift = 1e-4 * caster.radius
    blocked, _ = caster.hits(places + lift * seen_from, seen_from)
    return np.isfinite(blocked)
