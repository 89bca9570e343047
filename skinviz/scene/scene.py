"""The scene: frozen descriptions of what is to be computed, with no computation."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import as_numbers, as_wavelengths, in_range, one_of, unit_vector
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan.checks import require_triangles
from skinviz.skin.model import SkinModel
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.colorimetry import OBSERVERS
from skinviz.spectra.illuminants import illuminant_spd
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS
from skinviz.surface.torrance_sparrow import TorranceSparrow

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

LARGEST_PICTURE = 16384
"""Longest side that a picture may have. [pixels]"""

_MOST_PIXELS = 2**26


@dataclass(frozen=True, eq=False)
class Skin:
    """A model of skin and its parameters, on the whole mesh or at each vertex.

    Attributes
    ----------
    model : SkinModel
        The model.
    values : (p,) or (n_vertices, p) ndarray
        Its parameters.
    """

    model: SkinModel
    values: Array

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


@dataclass(frozen=True, eq=False)
class DirectionalLight:
    """A far light.

    Attributes
    ----------
    direction : (3,) array
        From the mesh towards the light; scaled to length 1.
    illuminant : str
        Name of a CIE illuminant, its spectrum.
    strength : float
        Irradiance, in units of the first light's. [1], > 0
    """

    direction: Array
    illuminant: str = "D65"
    strength: float = 1.0

    def __post_init__(self) -> None:
        """Normalise the direction; refuse unknown names and darkness."""
        object.__setattr__(
            self, "direction", unit_vector(self.direction, "light direction")
        )
        illuminant_spd(self.illuminant, PAPER_WAVELENGTHS)
        in_range(self.strength, 1e-30, 1e30, "light strength")


@dataclass(frozen=True, eq=False)
class Camera:
    """A far viewer: parallel rays, the whole mesh in the picture.

    Attributes
    ----------
    direction : (3,) array
        From the mesh towards the viewer; scaled to length 1.
    up : (3,) array
        Shown upwards; any direction across ``direction``.
    size : (int, int)
        Width and height of the picture. [pixels]
    """

    direction: Array
    up: Array
    size: tuple[int, int] = (1024, 1024)

    def __post_init__(self) -> None:
        """Normalise the directions; refuse impossible ones and sizes."""
        towards = unit_vector(self.direction, "camera direction")
        up = unit_vector(self.up, "camera up")
        across = up - (up @ towards) * towards
        if np.linalg.norm(across) < 1e-6:
            raise ArgumentError("camera up must not be parallel to its direction")
        object.__setattr__(self, "direction", towards)
        object.__setattr__(self, "up", unit_vector(across, "camera up"))
        object.__setattr__(self, "size", _picture_size(self.size))


def _picture_size(size: object) -> tuple[int, int]:
    """Return width and height as two counts of pixels."""
    if not isinstance(size, list | tuple) or len(size) != 2:
        raise ArgumentError(f"camera size must be (width, height); got {size!r}")
    for pixels in size:
        in_range(pixels, 1, LARGEST_PICTURE, "camera size", "pixels")
        if pixels != int(pixels):
            raise ArgumentError(f"camera size must be whole pixels; got {size!r}")
    width, height = (int(pixels) for pixels in size)
    if width * height > _MOST_PIXELS:
        raise ArgumentError(
            f"camera size {width} x {height} is more than {_MOST_PIXELS / 1e6:.0f} "
            "million pixels; draw it in parts"
        )
    return width, height


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that a picture depends on.

    Attributes
    ----------
    mesh : pyvista.PolyData
        Triangles. [mm]
    skin : Skin
        Body reflectance, uniform or per vertex.
    surface : TorranceSparrow
        Reflection at the surface.
    lights : tuple of DirectionalLight
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
    """

    mesh: pyvista.PolyData
    skin: Skin
    surface: TorranceSparrow
    lights: tuple[DirectionalLight, ...]
    camera: Camera
    diffuse_scale: float = 1.0
    exposure: float = 1.0
    wavelengths: Array = field(default_factory=lambda: PAPER_WAVELENGTHS)
    observer: str = "cie1931"

    def __post_init__(self) -> None:
        """Refuse meshes without triangles, no light, and mismatched pigments."""
        require_triangles(self.mesh, "the scene's mesh")
        if not self.mesh.is_all_triangles:
            object.__setattr__(self, "mesh", self.mesh.triangulate())
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
        object.__setattr__(self, "wavelengths", as_wavelengths(self.wavelengths))

    def replace(self, **changes: Any) -> Scene:
        """Return the scene with some attributes changed."""
        return dataclasses.replace(self, **changes)
