"""What is uneven about skin, made by rules: mottling, veins, redness, fine relief.

Pigments are changed at the vertices, so that a textured skin is a pigment map like any
other; only the relief, finer than any mesh, is left to where rays meet the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan import topology
from skinviz.scene.geodesics import Surface, surface_of
from skinviz.scene.landmarks import FINGERS, hand_of, landmarks
from skinviz.scene.noise import network, smooth_noise
from skinviz.scene.relief import Relief, require_seed
from skinviz.scene.scene import Scene, Skin

Array = NDArray[np.float64]

_LIMITS = {
    "melanin_mottling": (0.0, 2.0, ""),
    "blood_mottling": (0.0, 2.0, ""),
    "mottling_mm": (0.1, 1e3, "mm"),
    "veins": (0.0, 1.0, ""),
    "vein_width_mm": (0.2, 20.0, "mm"),
    "knuckle_redness": (0.0, 20.0, ""),
    "crease_redness": (0.0, 20.0, ""),
    "relief_um": (0.0, 500.0, "µm"),
    "relief_mm": (0.05, 50.0, "mm"),
}
_PER_SIZE = 1.5  # edges in a spot's size, at least: fewer do not show it
_MESH_ACROSS, _MESH_ALONG = 0.11, 0.26  # of the hand's length, cells between veins
_OTHERWISE = "veins and knuckle_redness are for hands; leave them out"
_CREASE = 2.5  # mm, over which a fold is felt
_KNUCKLE = 0.035  # of the hand's length, the reach of its redness


@dataclass(frozen=True)
class SkinTexture:
    """How uneven skin is; every amount is 0, which is even, by default.

    Attributes
    ----------
    melanin_mottling : float
        Relative standard deviation of w_m. [1]
    blood_mottling : float
        Relative standard deviation of w_h and w_dh together. [1]
    mottling_mm : float
        Size of the spots of both. [mm]
    veins : float
        What veins on the back of the hand add to w_dh in their middle. [1]
    vein_width_mm : float
        Across a vein, from half of that to half. [mm]
    knuckle_redness : float
        What is added to w_h over the knuckles, as a share of it. [1]
    crease_redness : float
        What is added to w_h in deep folds, as a share of it. [1]
    relief_um : float
        Depth of the furrows of fine relief. [µm]
    relief_mm : float
        From furrow to furrow. [mm]
    seed : int
        Which of all such skins.
    """

    melanin_mottling: float = 0.0
    blood_mottling: float = 0.0
    mottling_mm: float = 4.0
    veins: float = 0.0
    vein_width_mm: float = 3.0
    knuckle_redness: float = 0.0
    crease_redness: float = 0.0
    relief_um: float = 0.0
    relief_mm: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse amounts out of their ranges."""
        for name, (low, high, unit) in _LIMITS.items():
            in_range(getattr(self, name), low, high, name, unit)
        object.__setattr__(self, "seed", require_seed(self.seed))

    @property
    def told(self) -> str:
        """What differs from even skin, in words."""
        said = (
            f"{field.name} {getattr(self, field.name):g}"
            for field in fields(self)
            if getattr(self, field.name) != field.default
        )
        return ", ".join(said)


def textured(
    scene: Scene, texture: SkinTexture, surface: Surface | None = None
) -> Scene:
    """Return a scene with uneven skin.

    Parameters
    ----------
    scene : Scene
        Its skin may be uniform or differ over the mesh already.
    texture : SkinTexture
        How uneven.
    surface : Surface, optional
        Of the scene's mesh, where it is at hand.

    Returns
    -------
    scene : Scene
        With parameters at every vertex, and with fine relief.

    Raises
    ------
    ArgumentError
        If the model has no such pigments, or they come out of its bounds.
    MeshError
        If the mesh is too coarse for the spots or veins, or veins or knuckles are
        asked for and it is not a hand.

    Notes
    -----
    Mottling multiplies by exp(σ g − σ²/2), g a smooth field of standard deviation 1:
    the mean stays, nothing is negative. Veins are a network on the hand's back that
    fades towards the fingers and the palm. Folds are where the surface lies deeper
    than it does after smoothing over 2.5 mm.
    """
    surface = surface or surface_of(scene.mesh)
    relief = Relief(texture.relief_um, texture.relief_mm, texture.seed)
    changed = scene.replace(relief=relief)
    if not _wanted(texture):
        return changed
    names = [parameter.name for parameter in scene.skin.model.parameters]
    n = scene.mesh.n_points
    values = np.array(np.broadcast_to(scene.skin.values, (n, len(names))))
    columns = {name: values[:, k] for k, name in enumerate(names)}
    _require_pigments(scene.skin, columns)
    _require_fine(surface, texture)
    seeds = np.random.SeedSequence(texture.seed).spawn(4)
    rngs = [np.random.default_rng(seed) for seed in seeds]
    columns["w_m"] *= _mottles(surface, texture, texture.melanin_mottling, rngs[0])
    blood = _mottles(surface, texture, texture.blood_mottling, rngs[1])
    redness = 1 + texture.knuckle_redness * _knuckles(scene, surface, texture)
    if texture.crease_redness:
        redness += texture.crease_redness * _folds(surface)
    columns["w_h"] *= blood * redness
    columns["w_dh"] *= blood
    if texture.veins:
        columns["w_dh"] += texture.veins * _veins(scene, surface, texture, rngs[2])
    history = (*scene.skin.history, f"texture: {texture.told}")
    return changed.replace(skin=Skin(scene.skin.model, values, history))


def _wanted(texture: SkinTexture) -> bool:
    """Return whether anything of a texture changes pigments."""
    return any(
        (
            *(texture.melanin_mottling, texture.blood_mottling, texture.veins),
            *(texture.knuckle_redness, texture.crease_redness),
        )
    )


def _mottles(
    surface: Surface, texture: SkinTexture, amount: float, rng: np.random.Generator
) -> Array:
    """Return factors (n,) of mean 1 with a relative standard deviation."""
    if amount == 0:
        return np.ones(len(surface.points))
    sigma = np.sqrt(np.log1p(amount**2))  # of the logarithm
    noise = smooth_noise(surface.points, texture.mottling_mm, rng)
    return np.asarray(np.exp(sigma * noise - sigma**2 / 2))


def _knuckles(scene: Scene, surface: Surface, texture: SkinTexture) -> Array:
    """Return how much vertices (n,) belong to a knuckle or a finger's joint, 0 to 1."""
    if texture.knuckle_redness == 0:
        return np.zeros(len(surface.points))
    reach = _KNUCKLE * hand_of(scene.mesh, _OTHERWISE).length
    found = landmarks(scene.mesh, surface)
    sites = [found[f"{f}_{place}"] for f in FINGERS for place in ("knuckle", "joint")]
    nearness = np.exp(-0.5 * np.square(surface.distances(sites) / reach))
    return np.asarray(1 - np.prod(1 - nearness, axis=0))


def _folds(surface: Surface) -> Array:
    """Return how deep vertices (n,) lie in folds, 0 to 1.

    By how far an even spread of 2.5 mm moves them outwards.
    """
    from scipy.sparse import diags
    from scipy.sparse.linalg import splu

    area = np.maximum(surface.areas, 1e-9)
    system = (diags(area) + _CREASE**2 * surface.laplacian).tocsc()
    spread = splu(system).solve(area[:, None] * surface.points)
    depth = np.einsum("ij,ij->i", spread - surface.points, surface.normals)
    return np.asarray(np.tanh(np.maximum(depth, 0) / _CREASE * 2))


def _veins(
    scene: Scene, surface: Surface, texture: SkinTexture, rng: np.random.Generator
) -> Array:
    """Return how much of a vein is under vertices (n,), 0 to 1."""
    hand = hand_of(scene.mesh, _OTHERWISE)
    frame, length = hand.frame, hand.length
    offset = surface.points - hand.wrist_centre
    across, along = offset @ frame.side, offset @ frame.fingers - hand.arm
    bent = 0.02 * length
    wander = [smooth_noise(surface.points, 0.08 * length, rng) for _ in range(2)]
    across, bend = across + bent * wander[0], bent * wander[1]
    stretch = _MESH_ALONG / _MESH_ACROSS
    cell = _MESH_ACROSS * length
    flat = np.stack([across, (along + bend) / stretch, np.zeros_like(across)], axis=1)
    # One number of the seed, as a place in the network: of one plane of its cells.
    start = rng.uniform(0, 1000, 3)
    distance = cell * network(flat / cell + start, texture.seed)
    half = texture.vein_width_mm / 2
    vein = np.exp(-np.log(2) * np.square(distance / half))
    facing = _step(surface.normals @ frame.back, 0.25, 0.8)
    knuckles = 0.5 * length
    reach = 1 - _step(along, knuckles - 0.12 * length, knuckles)
    strength = _step(smooth_noise(surface.points, 0.12 * length, rng), -1.6, 0.0)
    return np.asarray(vein * facing * reach * strength)


def _step(values: Array, low: float, high: float) -> Array:
    """Return 0 below a range, 1 above, and a smooth step between."""
    x = np.clip((values - low) / (high - low), 0, 1)
    return np.asarray(x * x * (3 - 2 * x))


def _require_pigments(skin: Skin, columns: dict[str, Array]) -> None:
    """Refuse a model without the pigments that texture is made of."""
    lacking = {"w_m", "w_h", "w_dh"} - columns.keys()
    if lacking:
        raise ArgumentError(
            f"the {skin.model.name} model has no {', '.join(sorted(lacking))} to be "
            "uneven"
        )


def _require_fine(surface: Surface, texture: SkinTexture) -> None:
    """Refuse spots and veins that the mesh's vertices cannot show."""
    edge = float(np.median(topology.edge_lengths(surface.points, surface.faces)))
    sizes: Sequence[tuple[str, float, float]] = (
        ("mottling_mm", texture.mottling_mm, texture.melanin_mottling),
        ("mottling_mm", texture.mottling_mm, texture.blood_mottling),
        ("vein_width_mm", texture.vein_width_mm, texture.veins),
    )
    for name, size, amount in sizes:
        if amount and size < _PER_SIZE * edge:
            raise MeshError(
                f"{name} {size:g} is too fine for the mesh, whose edges are "
                f"{edge:.3g} mm; take at least {_PER_SIZE * edge:.2g} or a finer mesh "
                "(skinviz clean --edge-length)"
            )
