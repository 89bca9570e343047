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
from skinviz.scene.anatomy import folds, knuckles, veins
from skinviz.scene.geodesics import Surface, surface_of
from skinviz.scene.noise import smooth_noise
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
    vein_width_mm: float = 4.0
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
    if texture.relief_um:
        relief = Relief(texture.relief_um, texture.relief_mm, texture.seed)
        scene = scene.replace(relief=relief)
    if not _wanted(texture):
        return scene
    names = [parameter.name for parameter in scene.skin.model.parameters]
    n = scene.mesh.n_points
    values = np.array(np.broadcast_to(scene.skin.values, (n, len(names))))
    columns = {name: values[:, k] for k, name in enumerate(names)}
    _require_pigments(scene.skin, columns)
    _require_fine(surface, texture)
    of_melanin, of_blood, of_veins = np.random.SeedSequence(texture.seed).spawn(3)
    size = texture.mottling_mm
    blood = _mottles(surface, texture.blood_mottling, size, of_blood)
    columns["w_m"] *= _mottles(surface, texture.melanin_mottling, size, of_melanin)
    columns["w_h"] *= blood * _redness(scene, surface, texture)
    columns["w_dh"] *= blood
    if texture.veins:
        width = texture.vein_width_mm
        columns["w_dh"] += texture.veins * veins(scene.mesh, surface, width, of_veins)
    history = (*scene.skin.history, f"texture: {texture.told}")
    return scene.replace(skin=Skin(scene.skin.model, values, history))


def _wanted(texture: SkinTexture) -> bool:
    """Return whether anything of a texture changes pigments."""
    return any(
        (
            *(texture.melanin_mottling, texture.blood_mottling, texture.veins),
            *(texture.knuckle_redness, texture.crease_redness),
        )
    )


def _mottles(
    surface: Surface, amount: float, size: float, seed: np.random.SeedSequence
) -> Array:
    """Return factors (n,) of mean 1, their standard deviation the amount."""
    if amount == 0:
        return np.ones(len(surface.points))
    sigma = np.sqrt(np.log1p(amount**2))  # of the logarithm
    noise = smooth_noise(surface.points, size, np.random.default_rng(seed))
    return np.asarray(np.exp(sigma * noise - sigma**2 / 2))


def _redness(scene: Scene, surface: Surface, texture: SkinTexture) -> Array:
    """Return factors (n,) of w_h, above 1 at knuckles and in folds."""
    factors = np.ones(len(surface.points))
    if texture.knuckle_redness:
        factors += texture.knuckle_redness * knuckles(scene.mesh, surface)
    if texture.crease_redness:
        factors += texture.crease_redness * folds(surface)
    return factors


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
