"""Who looks at a scene: directions, distance, and which part fills the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, in_range, unit_vector
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

LARGEST_PICTURE = 16384
"""Longest side that a picture may have. [pixels]"""

_MOST_PIXELS = 2**26
_BYTES = 16  # a pixel's XYZ, coverage and colour
_MARGIN = 1.06


@dataclass(frozen=True, eq=False)
class Camera:
    """A viewer, far or near.

    Attributes
    ----------
    direction : (3,) array
        From the mesh towards the viewer; scaled to length 1.
    up : (3,) array
        Shown upwards; any direction across ``direction``.
    size : (int, int)
        Width and height of the picture. [pixels]
    distance : float
        From the target to the eye; ``inf`` for parallel rays. [mm], > 0
    target : (3,) array or None
        The point shown in the middle. [mm] None: the middle of the mesh as seen.
    height : float or None
        Height of what the picture shows, in the plane through the target. [mm]
        None: the whole mesh, with a margin of 6 %.
    """

    direction: Array
    up: Array
    size: tuple[int, int] = (1024, 1024)
    distance: float = np.inf
    target: Array | None = None
    height: float | None = None

    def __post_init__(self) -> None:
        """Normalise the directions; refuse impossible ones, sizes and distances."""
        towards = unit_vector(self.direction, "camera direction")
        up = unit_vector(self.up, "camera up")
        across = up - (up @ towards) * towards
        if np.linalg.norm(across) < 1e-6:
            raise ArgumentError("camera up must not be parallel to its direction")
        object.__setattr__(self, "direction", towards)
        object.__setattr__(self, "up", unit_vector(across, "camera up"))
        object.__setattr__(self, "size", _picture_size(self.size))
        if self.distance != np.inf:
            distance = in_range(self.distance, 1e-3, 1e9, "camera distance", "mm")
            object.__setattr__(self, "distance", distance)
        if self.height is not None:
            height = in_range(self.height, 1e-6, 1e9, "camera height", "mm")
            object.__setattr__(self, "height", height)
        if self.target is not None:
            target = as_numbers(self.target, "camera target")
            if target.shape != (3,) or not np.isfinite(target).all():
                raise ArgumentError(
                    f"camera target must be three finite numbers; got {self.target!r}"
                )
            object.__setattr__(self, "target", target)

    def view(self, points: Array) -> View:
        """Return what is seen of points (n, 3), in numbers that rays are made of.

        Raises
        ------
        ArgumentError
            If the eye is among or behind points that are to fill the picture.
        """
        right = np.cross(self.up, self.direction)
        axes = np.stack([right, self.up, self.direction])
        seen = axes @ points.T  # an axis a row: their extremes are found quickly
        target = self.target
        if target is None:
            target = (seen.min(axis=1) + seen.max(axis=1)) / 2 @ axes
        height = self.height or self._whole(seen - (axes @ target)[:, None])
        return View(
            target,
            right,
            self.up,
            self.direction,
            self.distance,
            height / self.size[1],
            self.size,
        )

    def _whole(self, seen: Array) -> float:
        """Return the height [mm] that shows all points, seen (3, n) from the target."""
        depth = seen[2].max()
        if depth >= self.distance * (1 - 1e-3):
            raise ArgumentError(
                f"the camera, {self.distance:g} mm from its target, is not in front of "
                f"the whole mesh, which reaches {depth:.4g} mm towards it; move "
                "it farther away, or say with height what it shows"
            )
        width, height = self.size
        flat = seen[:2]
        if np.isfinite(self.distance):
            flat = flat / (1 - seen[2] / self.distance)
        across, along = np.maximum(flat.max(axis=1), -flat.min(axis=1))
        return float(max(2 * along, 2 * across * height / width) * _MARGIN) or 1.0


@dataclass(frozen=True, eq=False)
class View:
    """A camera aimed at a mesh.

    Attributes
    ----------
    target : (3,) ndarray
        The point in the middle of the picture. [mm]
    right, up, direction : (3,) ndarray
        Of the picture, and from the target to the eye; at right angles.
    distance : float
        From target to eye. [mm], ``inf`` for parallel rays
    pixel : float
        Side of a pixel in the plane through the target. [mm]
    size : (int, int)
        Width and height. [pixels]
    """

    target: Array
    right: Array
    up: Array
    direction: Array
    distance: float
    pixel: float
    size: tuple[int, int]

    @property
    def homogeneous(self) -> Array:
        """Where the eye is: (x, y, z, 1) [mm], or (x, y, z, 0) at infinity."""
        if self.distance == np.inf:
            return np.array([*self.direction, 0.0])
        return np.array([*(self.target + self.distance * self.direction), 1.0])

    def on_plane(self, points: ArrayLike) -> Array:
        """Return where points (..., 3) are seen in the target's plane (..., 2). [mm]"""
        offset = np.asarray(points, dtype=np.float64) - self.target
        flat = offset @ np.stack([self.right, self.up], axis=1)
        if self.distance == np.inf:
            return np.asarray(flat)
        nearness = 1 - (offset @ self.direction) / self.distance
        return np.asarray(flat / nearness[..., None])

    def project(self, points: ArrayLike) -> Array:
        """Return the pixels (..., 2), column and row from the top left, of points."""
        width, height = self.size
        flat = self.on_plane(points) * np.array([1, -1]) / self.pixel
        return np.asarray(flat + np.array([width / 2, height / 2]))


def _picture_size(size: object) -> tuple[int, int]:
    """Return width and height as two counts of pixels."""
    if not isinstance(size, list | tuple) or len(size) != 2:
        raise ArgumentError(f"camera size must be (width, height); got {size!r}")
    for pixels in size:
        in_range(pixels, 1, 2**31, "camera size", "pixels")
        if pixels != int(pixels):
            raise ArgumentError(f"camera size must be whole pixels; got {size!r}")
    width, height = (int(pixels) for pixels in size)
    if max(width, height) > LARGEST_PICTURE or width * height > _MOST_PIXELS:
        raise ArgumentError(
            f"camera size {width} x {height} is {width * height / 1e6:.3g} million "
            f"pixels, which take {width * height * _BYTES / 2**30:.3g} GiB; at most "
            f"{LARGEST_PICTURE} a side and {_MOST_PIXELS / 1e6:.0f} million: draw "
            "parts, with target and height"
        )
    return width, height
