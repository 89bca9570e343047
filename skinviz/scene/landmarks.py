"""Points of a hand that people name, found on its mesh by shape alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scene.geodesics import Surface, surface_of
from skinviz.scene.hand import Hand, measure_hand
from skinviz.scene.peaks import ground_of, peaks_of

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

FINGERS = ("thumb", "index", "middle", "ring", "little")
"""From the thumb's side to the other."""

OF_HAND = ("back", "palm", "thenar", "hypothenar", "wrist", "inner_wrist")
OF_FINGER = (
    *("fingertip", "nail_bed", "pad", "joint"),
    *("finger_palm", "finger_root", "knuckle"),
)
"""Points that each finger has: its name and an underscore go in front."""

_PALM_SIDE = ("palm", "thenar", "hypothenar", "pad", "finger_palm", "finger_root")


def _members(names: Sequence[str]) -> tuple[str, ...]:
    """Return the points that some names stand for, each finger's with its name."""
    fingers = [f"{f}_{name}" for name in names if name in OF_FINGER for f in FINGERS]
    return (*(name for name in names if name in OF_HAND), *fingers)


GROUPS = {
    **{place: _members([place]) for place in OF_FINGER},
    "palm_side": _members(_PALM_SIDE),
    "back_side": _members(["back", "joint", "knuckle"]),
}
"""Names that stand for several points."""

NAMES = _members([*OF_HAND, *OF_FINGER])
"""All points."""

# Along a finger from its tip, in lengths from its tip to the web beside it; on the back
# or the palm side.
_PLACES = {
    "nail_bed": (0.09, True),
    "pad": (0.15, False),
    "joint": (0.75, True),
    "finger_palm": (0.6, False),
    "finger_root": (1.2, False),
    "knuckle": (1.35, True),
}
_THUMB = {"joint": 0.5, "finger_palm": 0.6, "finger_root": 1.0, "knuckle": 1.05}
_THUMB_TURN = np.deg2rad(60)  # of its nail about its axis, away from the others'
_LEAST_FINGER = 0.1  # of the hand's length, from tip to web
_OTHERWISE = "give points as vertices or coordinates instead of names"
_BESIDE = 0.02  # of the hand's length, within which vertices are beside a line


@dataclass(frozen=True, eq=False)
class _Finger:
    """A finger's tip, its way from the hand, and which way its nail looks."""

    tip: int
    axis: Array
    back: Array
    length: float


def landmarks(
    mesh: pyvista.PolyData, surface: Surface | None = None
) -> Mapping[str, int]:
    """Find the points of a hand that people name.

    Fingertips are where the distance along the surface from the wrist is largest;
    each finger reaches down to the web beside it, and its other points lie at usual
    shares of that length on its back or its palm side. The thumb's nail is taken to
    be turned by 60° from the others'.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A hand, open at the wrist, five fingers apart. [mm]
    surface : Surface, optional
        Of the mesh, where it is at hand from :func:`surface_of`.

    Returns
    -------
    landmarks : mapping of str to int
        Vertices, by ``NAMES``: ``back``, ``palm``, ``thenar`` and ``hypothenar`` (the
        balls of thumb and little finger), ``wrist``, ``inner_wrist``; and of each of
        ``thumb``, ``index``, ``middle``, ``ring`` and ``little``, as
        ``index_fingertip``: ``fingertip``, ``nail_bed``, ``pad``, ``joint`` (the
        middle one's back),
        ``finger_palm`` (opposite), ``finger_root`` (its palm end) and ``knuckle``.

    Raises
    ------
    MeshError
        If the mesh has no opening, no thumb, or not five fingers that are apart.
    """
    hand = hand_of(mesh, _OTHERWISE)
    surface = surface or surface_of(mesh)
    fingers = _fingers(surface, hand)
    found: dict[str, int] = {}
    for name, finger in fingers.items():
        found[f"{name}_fingertip"] = finger.tip
        for place, (usual, behind) in _PLACES.items():
            share = _THUMB.get(place, usual) if name == "thumb" else usual
            line = surface.points[finger.tip] - share * finger.length * finger.axis
            towards = finger.back if behind else -finger.back
            found[f"{name}_{place}"] = _outermost(surface, hand, line, towards)
    found |= _of_hand(surface, hand, found)
    return MappingProxyType(found)


def hand_of(mesh: pyvista.PolyData, otherwise: str) -> Hand:
    """Return what is found of a hand, or say what to do where it is none."""
    try:
        return measure_hand(mesh)
    except MeshError as error:
        why = str(error).partition(";")[0]
        raise MeshError(f"{why}; {otherwise}") from error


def _of_hand(surface: Surface, hand: Hand, found: Mapping[str, int]) -> dict[str, int]:
    """Return the points between wrist and knuckles."""
    back, points = hand.frame.back, surface.points
    wrist = hand.wrist_centre + hand.arm * hand.frame.fingers
    knuckles = [found[f"{name}_knuckle"] for name in FINGERS[1:]]
    middle = (wrist + points[knuckles].mean(axis=0)) / 2
    thumb = (wrist + points[found["thumb_knuckle"]]) / 2
    little = (wrist + points[found["little_knuckle"]]) / 2
    places = (
        *(("back", middle, back), ("palm", middle, -back)),
        *(("thenar", thumb, -back), ("hypothenar", little, -back)),
        *(("wrist", wrist, back), ("inner_wrist", wrist, -back)),
    )
    return {
        name: _outermost(surface, hand, place, towards)
        for name, place, towards in places
    }


def _fingers(surface: Surface, hand: Hand) -> dict[str, _Finger]:
    """Return the five fingers by name."""
    reach = surface.distance_to(hand.wrist)
    reach[~np.isfinite(reach)] = 0.0
    tips, passes, into = peaks_of(surface, reach)
    kept = reach[tips] - passes > _LEAST_FINGER * hand.length
    if kept.sum() != len(FINGERS):
        raise MeshError(
            f"the mesh has {kept.sum()} fingers that are apart, five are needed; "
            f"{_OTHERWISE}"
        )
    tips, webs = tips[kept], passes[kept]
    # A finger ends where the next one begins, also the one that reaches farthest.
    for other, web in zip(into[kept], passes[kept], strict=True):
        webs = np.where(tips == other, np.maximum(webs, web), webs)
    frame, points = hand.frame, surface.points
    away = points[tips] - (hand.wrist_centre + hand.arm * frame.fingers)
    turn = np.arctan2(away @ frame.side, away @ frame.fingers)
    order = np.argsort(turn if hand.side == "right" else -turn)
    found = {}
    for name, k in zip(FINGERS, order, strict=True):
        tip, web = int(tips[k]), float(webs[k])
        own = ground_of(surface, reach, tip, web)
        root = points[own & (reach < web + 0.25 * (reach[tip] - web))].mean(axis=0)
        axis = (points[tip] - root) / np.linalg.norm(points[tip] - root)
        # From the web's height along the axis, not along the curved skin.
        length = float(np.linalg.norm(points[tip] - root)) / 0.875
        found[name] = _Finger(tip, axis, _nail_side(name, hand, axis), length)
    return found


def _nail_side(name: str, hand: Hand, axis: Array) -> Array:
    """Return which way a finger's nail looks, across its axis."""
    back = hand.frame.back
    if name == "thumb":
        outwards = -hand.frame.side if hand.side == "right" else hand.frame.side
        back = np.cos(_THUMB_TURN) * back + np.sin(_THUMB_TURN) * outwards
    across = back - (back @ axis) * axis
    return np.asarray(across / np.linalg.norm(across))


def _outermost(surface: Surface, hand: Hand, place: Array, towards: Array) -> int:
    """Return the vertex nearest to the line from a place in a direction, facing it.

    Where the line leaves the hand several times, it is the first time: a finger that
    is bent over the palm is not the palm.
    """
    offset = surface.points - place
    along = offset @ towards
    beside = np.linalg.norm(offset - along[:, None] * towards, axis=1)
    reach = _BESIDE * hand.length
    facing = (surface.normals @ towards > 0.3) & (along > -reach)
    near = np.flatnonzero(facing & (beside < reach) & (along < 0.3 * hand.length))
    if near.size == 0:
        near = np.flatnonzero(surface.normals.any(axis=1))
        return int(near[np.linalg.norm(offset[near], axis=1).argmin()])
    return int(near[(beside[near] + 0.2 * np.abs(along[near])).argmin()])
