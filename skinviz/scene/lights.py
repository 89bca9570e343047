"""What lights a scene: far lights and near ones."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import as_numbers, in_range, unit_vector
from skinviz.errors import ArgumentError
from skinviz.spectra.illuminants import Illuminant, as_illuminant

Array = NDArray[np.float64]

_FARTHEST = 1e9  # mm, beyond which a light is better said to be far


class _Emitter:
    """What far and near lights have in common: a spectrum and a strength."""

    illuminant: str | Illuminant
    strength: float

    @cached_property
    def spectrum(self) -> Illuminant:
        """Its relative spectral power."""
        return as_illuminant(self.illuminant)

    def _require_light(self) -> None:
        """Refuse unknown names and darkness."""
        as_illuminant(self.illuminant)
        in_range(self.strength, 1e-30, 1e30, "light strength")


@dataclass(frozen=True, eq=False)
class DirectionalLight(_Emitter):
    """A far light: parallel rays, the same irradiance everywhere.

    Attributes
    ----------
    direction : (3,) array
        From the mesh towards the light; scaled to length 1.
    illuminant : str or Illuminant
        Its spectrum: the name of a CIE illuminant, a temperature as "3200 K", a line
        as "632.8 nm", or a lamp.
    strength : float
        Irradiance, in units of the first light's. [1], > 0
    """

    direction: Array
    illuminant: str | Illuminant = "D65"
    strength: float = 1.0

    def __post_init__(self) -> None:
        """Normalise the direction; refuse unknown names and darkness."""
        object.__setattr__(
            self, "direction", unit_vector(self.direction, "light direction")
        )
        self._require_light()

    @property
    def place(self) -> str:
        """Where the light is, in words."""
        return f"from {np.round(self.direction, 3).tolist()}"

    @property
    def homogeneous(self) -> Array:
        """Where the light is, as (x, y, z, 0): a point at infinity."""
        return np.array([*self.direction, 0.0])


@dataclass(frozen=True, eq=False)
class PointLight(_Emitter):
    """A near, small light: irradiance falls with the square of the distance.

    Attributes
    ----------
    position : (3,) array
        In the mesh's coordinates. [mm]
    illuminant : str or Illuminant
        Its spectrum: the name of a CIE illuminant, a temperature as "3200 K", a line
        as "632.8 nm", or a lamp.
    strength : float
        Irradiance of a plate that faces the light at the mesh's centroid, in units
        of the first light's. [1], > 0
    """

    position: Array
    illuminant: str | Illuminant = "D65"
    strength: float = 1.0

    def __post_init__(self) -> None:
        """Refuse positions that are none, unknown names and darkness."""
        position = as_numbers(self.position, "light position")
        if position.shape != (3,) or not (np.abs(position) <= _FARTHEST).all():
            raise ArgumentError(
                f"light position must be three numbers of at most {_FARTHEST:g} mm; "
                f"got {self.position!r}; give a farther light's direction"
            )
        object.__setattr__(self, "position", position)
        self._require_light()

    @property
    def place(self) -> str:
        """Where the light is, in words."""
        return f"at {np.round(self.position, 3).tolist()} mm"

    @property
    def homogeneous(self) -> Array:
        """Where the light is, as (x, y, z, 1). [mm]"""
        return np.array([*self.position, 1.0])


Light = DirectionalLight | PointLight
