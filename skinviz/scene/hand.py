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
from skinviz.scene.sections import narrowest, sections

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

_SECTIONS = 24
_HARDLY_WIDER = 1.02
_WRIST = 0.15  # of the hand's length: as much of the arm lies as the hand does
_PASSES = 2

_NO_HAND = (
    "; give the view's and the lights' directions instead of angles, or cut away "
    "what is no hand"
)


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

    The hand is what lies beyond the narrowest section between palm and forearm, if
    there is a forearm. Its longest axis points away from the arm's opening; the
    thumb, which reaches farthest to one side, lies on the palm's side of the
    thinnest axis.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A hand, open at the wrist or along the forearm. [mm]

    Returns
    -------
    frame : HandFrame
        Back, fingers and side.

    Raises
    ------
    MeshError
        If the mesh has no opening, is a sheet, or no thumb can be told from its shape.
    """
    return measure_hand(mesh).frame


def measure_hand(mesh: pyvista.PolyData) -> Hand:
    """Find a hand's directions, side, length and wrist from its shape alone.

    Seen from its back with the fingers up, a right hand has its thumb on the left.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A hand, open at the wrist or along the forearm, its faces outwards. [mm]

    Returns
    -------
    hand : Hand
        What was found.

    Raises
    ------
    MeshError
        If the mesh has no opening, is a sheet, or no thumb can be told from its shape.
    """
    points, faces = require_triangles(mesh, "mesh")
    loop = wrist_loop(points, faces)
    if loop is None:
        raise MeshError(
            "the mesh has no opening at the wrist, so the direction of its fingers "
            "is unknown; give the view's and the lights' directions instead of angles"
        )
    opening, width = points[loop].mean(axis=0), topology.widest(points[loop])
    if width > np.linalg.norm(points - opening, axis=1).max():
        raise MeshError(f"the mesh is open as wide as it reaches: no hand{_NO_HAND}")
    shape = _hand_alone(points, faces, loop)
    frame, thumb = _frame(shape)
    along = (points - opening) @ frame.fingers
    arm = _arm_length(
        points,
        faces,
        frame,
        along,
        first=float(along[loop].max()),
        wrist=float((shape.wrist - opening) @ frame.fingers),
    )
    return Hand(
        frame,
        side="right" if thumb @ frame.side < 0 else "left",
        length=float(along.max()) - arm,
        arm=arm,
        wrist=loop,
        wrist_centre=opening,
        wrist_width=width,
    )


@dataclass(frozen=True)
class _Shape:
    """A hand's part of a mesh, and how it lies."""

    points: Array
    faces: NDArray[np.int64]
    wrist: Array  # the centre of the narrowest section
    axes: Array  # thinnest, wide, long: its columns, the last towards the fingers


def _hand_alone(
    points: Array, faces: NDArray[np.int64], loop: NDArray[np.int64]
) -> _Shape:
    """Return what of a mesh is hand, with a little of the arm."""
    opening = points[loop].mean(axis=0)
    shape = _Shape(points, faces, opening, _axes(points, faces, opening))
    for _ in range(_PASSES):  # the arm may lie otherwise than the hand does
        axis = shape.axes[:, 2]
        along = points @ axis
        end = narrowest(points, faces, axis, float(along[loop].max()))
        if end is None:
            return _Shape(points, faces, opening, _axes(points, faces, opening))
        wrist = sections(points, faces, along, [end])[0].centre
        least = end - _WRIST * (along.max() - end)
        hand = faces[(along[faces] > least).all(axis=1)]
        shape = _Shape(points, hand, wrist, _axes(points, hand, wrist))
    return shape


def _axes(points: Array, faces: NDArray[np.int64], wrist: Array) -> Array:
    """Return a surface's thinnest, wide and long axis, the last away from its wrist."""
    # By area, not by vertex: meshes are often finer at the nails.
    area = topology.face_areas(points, faces)
    if area.sum() == 0:
        raise MeshError(f"the mesh has no area and is no hand{_NO_HAND}")
    middles = points[faces].mean(axis=1)
    centre = np.average(middles, axis=0, weights=area)
    spread = middles - centre
    _, axes = np.linalg.eigh((spread * area[:, None]).T @ spread)
    if (centre - wrist) @ axes[:, 2] < 0:
        axes[:, 2] = -axes[:, 2]
    return np.asarray(axes)


def _frame(shape: _Shape) -> tuple[HandFrame, Array]:
    """Return a hand's frame and the direction in which its thumb reaches."""
    faces, (thin, wide, long) = shape.faces, shape.axes.T
    points = shape.points - shape.wrist
    used = points[np.unique(faces)]
    along, across = used @ long, used @ wide
    length = along.max()
    middle = (along > 0.05 * length) & (along < 0.75 * length)
    reach = across[middle]
    if middle.sum() == 0 or abs(reach.max() + reach.min()) < 0.12 * length:
        raise MeshError(f"the mesh has no thumb to tell palm from back by{_NO_HAND}")
    outwards = np.sign(reach.max() + reach.min())
    reaching = outwards * across
    thumb = middle & (reaching > np.quantile(reaching[middle], 0.95))
    area = topology.face_areas(points, faces)
    middles = points[faces].mean(axis=1)
    depth = used @ thin - np.average(middles @ thin, weights=area)
    palm = thin * np.sign(depth[thumb].mean())
    back = _mean_back_normal(points, faces, -palm, middles @ long / length)
    fingers = long - (long @ back) * back
    fingers /= np.linalg.norm(fingers)
    return HandFrame(back, fingers, np.cross(fingers, back)), outwards * wide


def _arm_length(
    points: Array,
    faces: NDArray[np.int64],
    frame: HandFrame,
    along: Array,
    *,
    first: float,
    wrist: float,
) -> float:
    """Return where the arm's narrow part ends and the hand begins to widen. [mm]

    ``first`` and ``wrist``, the end of the opening and the narrowest section, are
    heights ``along`` the fingers. Around the wrist the mesh is cut by planes across
    the fingers; the narrow part ends with the last section that is hardly wider than
    the narrowest.
    """
    hand = float(along.max()) - wrist
    low, high = max(first, wrist - _WRIST * hand), wrist + 0.4 * hand
    if low >= high:
        return max(first, 0.0)
    heights = np.linspace(low, high, _SECTIONS + 2)[1:-1]
    cuts = sections(points, faces, along, heights)
    widths = np.array([cut.width(frame.side) for cut in cuts])
    narrow = np.flatnonzero(widths <= _HARDLY_WIDER * widths.min())
    return float(heights[narrow[-1]])


def _mean_back_normal(
    points: Array, faces: NDArray[np.int64], guess: Array, share: Array
) -> Array:
    """Return the area-weighted mean normal of the hand's back, wrist to knuckles."""
    vectors = topology.face_vectors(points, faces)
    facing = vectors @ guess > 0.5 * np.linalg.norm(vectors, axis=1)
    back = vectors[facing & (share > 0.0) & (share < 0.36)].sum(axis=0)
    length = np.linalg.norm(back)
    return np.asarray(back / length if length > 0 else guess)
