"""Which way a hand lies, how long it is, and whether it is the right or the left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles
from skinviz.scan.wrist import wrist_loop

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

_SECTIONS = 24
_HARDLY_WIDER = 1.02


@dataclass(frozen=True)
class HandFrame:
    """Three directions at right angles that people name on a hand.

    Attributes
    ----------
    back : (3,) ndarray
        Mean normal of the back of the hand: the direction of angle 0.
    fingers : (3,) ndarray
        From the wrist to the fingertips, across ``back``.
    side : (3,) ndarray
        ``fingers × back``: to the right for a viewer of the back, fingers up.
    """

    back: Array
    fingers: Array
    side: Array

    def direction(self, angle: float) -> Array:
        """Return the direction at an angle from the back's normal.

        Positive angles lean to the viewer's left, negative to the right. [rad]
        """
        return np.asarray(np.cos(angle) * self.back - np.sin(angle) * self.side)


@dataclass(frozen=True)
class Hand:
    """What is found of a hand from its shape alone.

    Attributes
    ----------
    frame : HandFrame
        Its back, fingers and side.
    side : str
        ``"right"`` or ``"left"``.
    length : float
        Along ``fingers``, from the narrow part of the wrist to the fingertip. [mm]
    arm : float
        Along ``fingers``, from the wrist's opening to that narrow part. [mm]
    wrist : (k,) ndarray of int64
        The points around the wrist's opening.
    wrist_centre : (3,) ndarray
        Their mean. [mm]
    wrist_width : float
        The largest distance between two of them. [mm]
    """

    frame: HandFrame
    side: str
    length: float
    arm: float
    wrist: NDArray[np.int64]
    wrist_centre: Array
    wrist_width: float


def hand_frame(mesh: pyvista.PolyData) -> HandFrame:
    """Find how a hand mesh lies from its shape alone.

    The longest axis points away from the wrist's opening; the thumb, which
    reaches farthest to one side, lies on the palm's side of the thinnest axis.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A hand, open at the wrist. [mm]

    Returns
    -------
    frame : HandFrame
        Back, fingers and side.

    Raises
    ------
    MeshError
        If the mesh has no opening, or no thumb can be told from its shape.
    """
    return measure_hand(mesh).frame


def measure_hand(mesh: pyvista.PolyData) -> Hand:
    """Find a hand's directions, side, length and wrist from its shape alone.

    Seen from its back with the fingers up, a right hand has its thumb on the left.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A hand, open at the wrist, its faces outwards. [mm]

    Returns
    -------
    hand : Hand
        What was found.

    Raises
    ------
    MeshError
        If the mesh has no opening, or no thumb can be told from its shape.
    """
    points, faces = require_triangles(mesh, "mesh")
    loop = wrist_loop(points, faces)
    if loop is None:
        raise MeshError(
            "the mesh has no opening at the wrist, so the direction of its fingers "
            "is unknown; give the view's and the lights' directions instead of angles"
        )
    wrist = points[loop].mean(axis=0)
    frame, thumb = _frame(points, faces, wrist)
    along = (points - wrist) @ frame.fingers
    edges, _ = topology.edge_counts(faces)
    arm = _arm_length(along, points @ frame.side, loop, edges)
    return Hand(
        frame,
        side="right" if thumb @ frame.side < 0 else "left",
        length=float(along.max()) - arm,
        arm=arm,
        wrist=loop,
        wrist_centre=wrist,
        wrist_width=_widest(points[loop]),
    )


def _frame(
    points: Array, faces: NDArray[np.int64], wrist: Array
) -> tuple[HandFrame, Array]:
    """Return a hand's frame and the direction in which its thumb reaches."""
    # By area, not by vertex: meshes are often finer at the nails.
    area = topology.face_areas(points, faces)
    middles = points[faces].mean(axis=1)
    centre = np.average(middles, axis=0, weights=area)
    spread = middles - centre
    _, axes = np.linalg.eigh((spread * area[:, None]).T @ spread)
    thin, wide, long = axes.T
    long = long * np.sign((centre - wrist) @ long)
    along = (points - wrist) @ long
    across = (points - wrist) @ wide
    length = along.max()
    middle = (along > 0.2 * length) & (along < 0.8 * length)
    reach = across[middle]
    if middle.sum() == 0 or abs(reach.max() + reach.min()) < 0.1 * length:
        raise MeshError(
            "the mesh has no thumb to tell palm from back by; give the view's and "
            "the lights' directions instead of angles"
        )
    outwards = np.sign(reach.max() + reach.min())
    reaching = outwards * across
    thumb = middle & (reaching > np.quantile(reaching[middle], 0.95))
    palm = thin * np.sign(((points - centre) @ thin)[thumb].mean())
    back = _mean_back_normal(points, faces, -palm, (middles - wrist) @ long)
    fingers = long - (long @ back) * back
    fingers /= np.linalg.norm(fingers)
    return HandFrame(back, fingers, np.cross(fingers, back)), outwards * wide


def _arm_length(
    along: Array, across: Array, loop: NDArray[np.int64], edges: NDArray[np.int64]
) -> float:
    """Return where the arm's narrow part ends and the hand begins to widen. [mm]

    The half next to the opening is cut by planes across the fingers; the narrow
    part ends with the last section that is hardly wider than the narrowest.
    """
    first, last = float(along[loop].max()), float(along.max()) / 2
    if first >= last:
        return max(first, 0.0)
    heights = np.linspace(first, last, _SECTIONS + 2)[1:-1]
    a, b = edges.T
    widths = np.full(_SECTIONS, np.inf)
    for i, height in enumerate(heights):
        cut = (along[a] < height) != (along[b] < height)
        if cut.any():
            low, high = a[cut], b[cut]
            share = (height - along[low]) / (along[high] - along[low])
            widths[i] = np.ptp(across[low] + share * (across[high] - across[low]))
    narrow = np.flatnonzero(widths <= _HARDLY_WIDER * widths.min())
    return float(heights[narrow[-1]])


def _widest(points: Array) -> float:
    """Return the largest distance between two points of a ring. [mm]"""
    few = points[:: max(1, len(points) // 1000)]
    return float(np.linalg.norm(few[:, None] - few, axis=-1).max())


def _mean_back_normal(
    points: Array, faces: NDArray[np.int64], guess: Array, along: Array
) -> Array:
    """Return the area-weighted mean normal of the hand's back, wrist to knuckles."""
    vectors = topology.face_vectors(points, faces)
    share = along / along.max()
    facing = vectors @ guess > 0.5 * np.linalg.norm(vectors, axis=1)
    back = vectors[facing & (share > 0.15) & (share < 0.45)].sum(axis=0)
    length = np.linalg.norm(back)
    return np.asarray(back / length if length > 0 else guess)
