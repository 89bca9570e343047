"""The scene: frozen descriptions of what is to be computed, with no computation."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import as_numbers, as_wavelengths, in_range, one_of
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan.checks import require_triangles
from skinviz.scene.camera import Camera
from skinviz.scene.changes import changed_values, told
from skinviz.scene.lights import Light
from skinviz.scene.relief import SMOOTH, Relief
from skinviz.skin.model import SkinModel
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.adaptation import ADAPTATIONS
from skinviz.spectra.colorimetry import OBSERVERS
from skinviz.spectra.display import SRGB, Display
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS
from skinviz.surface.surface import Surface

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

INTERREFLECTIONS = ("none", "diffuse")
"""``"none"``: the paper's local model; ``"diffuse"``: one bounce between parts."""

BACKGROUND = (46, 46, 46)
"""A dark neutral surround. [8-bit sRGB]"""


@dataclass(frozen=True, eq=False)
class Skin:
    """A model of skin and its parameters, on the whole mesh or at each vertex.

    Attributes
    ----------
    model : SkinModel
        The model.
    values : (p,) or (n_vertices, p) ndarray
        Its parameters.
    history : tuple of str
        How they came to be what they are, a line each: maps, textures, changes.
    """

    model: SkinModel
    values: Array
    history: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Store the values as float64; refuse other shapes and impossible values."""
        p = len(self.model.parameters)
        values = as_numbers(self.values, "skin values")
        if values.ndim not in (1, 2) or values.shape[-1] != p:
            raise ArgumentError(
                f"skin values must have shape ({p},) or (n_vertices, {p}); got "
                f"{values.shape}"
            )
        self.model.checked(values)
        object.__setattr__(self, "values", values)

    @classmethod
    def from_fit(cls, fit: SkinFit) -> Skin:
        """Return the skin that one spectrum's fit describes.

        Raises
        ------
        FitError
            If the fit did not converge.
        ArgumentError
            If the fit is of a batch.
        """
        fit.raise_for_status()
        if fit.values.ndim != 1:
            raise ArgumentError(
                f"a skin takes the fit of one spectrum; this is of {fit.values.shape}"
            )
        return cls(fit.model, fit.values)

    def changed(self, **changes: str | float) -> Skin:
        """Return the skin with some quantities changed, everywhere on it.

        Parameters
        ----------
        **changes : str or float
            ``melanin``, ``oxyhaemoglobin``, ``deoxyhaemoglobin``, ``haemoglobin`` and
            ``saturation``: ``"x2"`` multiplies, ``"+0.01"`` adds, a number sets; see
            :func:`skinviz.scene.changes.changed_values`.

        Raises
        ------
        ArgumentError
            If a quantity is unknown, or becomes negative or out of its bounds.
        """
        if not changes:
            return self
        values = changed_values(self.model, self.values, changes)
        return Skin(self.model, values, (*self.history, f"changed: {told(changes)}"))


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that a picture depends on.

    Attributes
    ----------
    mesh : pyvista.PolyData
        Triangles. [mm]
    skin : Skin
        Body reflectance, uniform or per vertex.
    surface : Surface
        Reflection at the surface, by any of the models.
    lights : tuple of DirectionalLight or PointLight
        At least one. The first sets the scale: the perfect diffuser facing it,
        lit by it alone, has Y = 1 × exposure.
    camera : Camera
        The view.
    diffuse_scale : float
        α of eq. (10); 1 is a Lambertian surface. [1]
    exposure : float
        Scale of the picture. [1]
    wavelengths : (n,) ndarray
        Where spectra are computed. [nm]
    observer : str
        "cie1931" or "cie1964".
    interreflection : {"none", "diffuse"}
        Whether light that one part of the mesh throws on another is computed, one
        diffuse bounce of it.
    background : (int, int, int)
        Surround of the mesh in pictures; no light comes from it. [8 bits, of the
        display]
    display : Display
        What pictures are made for.
    white : {"none", "cat16"}
        Whether the display's white stands for the perfect diffuser under light 1,
        to which eyes adapt, or colours are left as they are.
    relief : Relief
        Furrows that tilt the normals where rays meet the mesh; smooth by default.
    """

    mesh: pyvista.PolyData
    skin: Skin
    surface: Surface
    lights: tuple[Light, ...]
    camera: Camera
    diffuse_scale: float = 1.0
    exposure: float = 1.0
    wavelengths: Array = field(default_factory=lambda: PAPER_WAVELENGTHS)
    observer: str = "cie1931"
    interreflection: str = "none"
    background: tuple[int, int, int] = BACKGROUND
    display: Display = SRGB
    white: str = "none"
    relief: Relief = SMOOTH
    _checked: pyvista.PolyData | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Refuse meshes without triangles, no light, and mismatched pigments."""
        if self._checked is not self.mesh:  # a replaced light costs no look at it
            require_triangles(self.mesh, "the scene's mesh")
            if not self.mesh.is_all_triangles:
                object.__setattr__(self, "mesh", self.mesh.triangulate())
            object.__setattr__(self, "_checked", self.mesh)
        if not self.lights:
            raise ArgumentError("a scene needs at least one light")
        object.__setattr__(self, "lights", tuple(self.lights))
        values = self.skin.values
        if values.ndim == 2 and len(values) != self.mesh.n_points:
            raise MeshError(
                f"pigments at {len(values)} vertices, the mesh has {self.mesh.n_points}"
            )
        in_range(self.diffuse_scale, 0.0, 1e6, "diffuse_scale")
        in_range(self.exposure, 1e-30, 1e30, "exposure")
        one_of(self.observer, OBSERVERS, "observer")
        one_of(self.interreflection, INTERREFLECTIONS, "interreflection")
        one_of(self.white, ADAPTATIONS, "white")
        _require_rgb8(self.background)
        object.__setattr__(self, "wavelengths", as_wavelengths(self.wavelengths))

    def replace(self, **changes: Any) -> Scene:
        """Return the scene with some attributes changed."""
        return dataclasses.replace(self, **changes)


def _require_rgb8(colour: tuple[int, int, int]) -> None:
    """Refuse a colour that is not three whole numbers of 0 to 255."""
    if not isinstance(colour, list | tuple) or len(colour) != 3:
        raise ArgumentError(
            f"background must be (red, green, blue), each 0 to 255; got {colour!r}"
        )
    for channel in colour:
        in_range(channel, 0, 255, "background")
        if channel != int(channel):
            raise ArgumentError(f"background must be whole numbers; got {colour!r}")
