"""Where on a hand skin has veins, redder joints and folds: fields of 0 to 1."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.scene.geodesics import Surface
from skinviz.scene.landmarks import FINGERS, hand_of, landmarks
from skinviz.scene.noise import network, smooth_noise

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

# Of the hand's length:
_FIELD = (0.11, 0.26)  # that veins run round, across and along
_WANDER, _BENT = 0.08, 0.02  # how far apart veins bend, and how far
_FADE = 0.12  # where they come and go
_LAST, _FULL = 0.5, 0.38  # from the wrist, where they have ended, and begin to
_KNUCKLE = 0.035  # the reach of its redness

_FOLD = 2.5  # mm, over which a fold is felt
_SMALLEST_AREA = 1e-9  # mm²
_OTHERWISE = "veins and knuckle_redness are for hands; leave them out"


def knuckles(mesh: pyvista.PolyData, surface: Surface) -> Array:
    """Return how much vertices (n,) belong to a knuckle or a finger's middle joint.

    Raises
    ------
    MeshError
        If the mesh is not a hand with five fingers.
    """
    reach = _KNUCKLE * hand_of(mesh, _OTHERWISE).length
    found = landmarks(mesh, surface)
    sites = [found[f"{f}_{place}"] for f in FINGERS for place in ("knuckle", "joint")]
    nearness = np.exp(-0.5 * np.square(surface.distances(sites) / reach))
    return np.asarray(1 - np.prod(1 - nearness, axis=0))


def folds(surface: Surface) -> Array:
    """Return how deep vertices (n,) lie in folds.

    By how far outwards they go when places are evened out, as heat is, over 2.5 mm.
    """
    from scipy.sparse import diags
    from scipy.sparse.linalg import splu

    area = np.maximum(surface.areas, _SMALLEST_AREA)
    system = (diags(area) + _FOLD**2 * surface.laplacian).tocsc()
    even = splu(system).solve(area[:, None] * surface.points)
    depth = np.einsum("ij,ij->i", even - surface.points, surface.normals)
    return np.asarray(np.tanh(2 / _FOLD * np.maximum(depth, 0)))


def veins(
    mesh: pyvista.PolyData, surface: Surface, width: float, seed: np.random.SeedSequence
) -> Array:
    """Return how much of a vein vertices (n,) have under them.

    Veins are a network, seen on the hand's back as drawn on a plane, that bends, comes
    and goes, and ends before the fingers. ``width`` is across one, from half to half.
    [mm]

    Raises
    ------
    MeshError
        If the mesh is not a hand.
    """
    hand = hand_of(mesh, _OTHERWISE)
    frame, length, rng = hand.frame, hand.length, np.random.default_rng(seed)

    def noise(size: float) -> Array:
        return smooth_noise(surface.points, size * length, rng)

    offset = surface.points - hand.wrist_centre
    across, along = offset @ frame.side, offset @ frame.fingers - hand.arm
    bent = _BENT * length * np.stack([noise(_WANDER), noise(_WANDER)], axis=1)
    plane = np.stack([across, along], axis=1) + bent
    distance = network(plane, length * np.array(_FIELD), int(rng.integers(2**31)))
    vein = np.exp(-np.log(2) * np.square(2 * distance / width))
    facing = _step(surface.normals @ frame.back, 0.25, 0.8)
    ended = _step(along / length, _FULL, _LAST)
    return np.asarray(vein * facing * (1 - ended) * _step(noise(_FADE), -1.6, 0.0))


def _step(values: Array, low: float, high: float) -> Array:
    """Return 0 below a range, 1 above, and a smooth step between."""
    x = np.clip((values - low) / (high - low), 0, 1)
    return np.asarray(x * x * (3 - 2 * x))
