"""What a model of the skin's surface is: the face that all of them share."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz.surface.dispersion import Dispersion, one_index
from skinviz.surface.evaluation import cosines, specular, unit_vectors
from skinviz.surface.fresnel import fresnel_reflectance

Array = NDArray[np.float64]


@runtime_checkable
class Surface(Protocol):
    """Specular reflection of a surface: frozen, one small file each.

    A model that inherits from this gets :meth:`evaluate` and :meth:`parts`.

    Attributes
    ----------
    name : str
        As in scene files.
    """

    name: ClassVar[str]
    __dataclass_fields__: ClassVar[dict[str, Any]]  # its parameters

    @property
    @abstractmethod
    def n(self) -> float | Dispersion:
        """Refractive index of the skin. [1]"""

    @property
    @abstractmethod
    def physical_beta(self) -> float:
        """The weight with which facets cover the surface once. [1]

        The specular albedo is then at most 1 for every F and angle, with masking.
        """

    @property
    @abstractmethod
    def beta(self) -> float:
        """The weight of D F G/(N·V). [1]"""

    @property
    @abstractmethod
    def description(self) -> str:
        """The model and its parameters, in a line of words."""

    @property
    @abstractmethod
    def lobe(self) -> Any:
        """The compiled β D G/(N·V) of blocks of points; see ``kernels.LOBE``."""

    @property
    @abstractmethod
    def constants(self) -> Array:
        """What the lobe is given."""

    @abstractmethod
    def factors(self, cosines: Array) -> tuple[Array, Array]:
        """Return D and G/(N·V), both (...), of N·L, N·V, N·H, |N × H|, V·H (5, ...).

        Plain array functions, for plots; their product is the lobe without β.
        """

    @abstractmethod
    def reach(self, incidence: float) -> float:
        """Return how far facets are tilted that still matter (D > 1e-27). [rad]

        ``incidence`` is the light's angle from the normal. [rad]
        """

    def evaluate(
        self,
        normals: ArrayLike,
        light: ArrayLike,
        view: ArrayLike,
        n: ArrayLike | None = None,
    ) -> Array:
        """Return β D F G/(N·V): specular radiance over that of the lit diffuser.

        Parameters
        ----------
        normals, light, view : (..., 3) array_like
            Unit vectors from the surface: its normal, towards light and viewer;
            broadcast together.
        n : (...) array_like, optional
            Refractive index instead of the surface's own, broadcast with the
            vectors. [1], ≥ 1

        Returns
        -------
        specular : (...) ndarray of float64
            To be multiplied by E(λ), the radiance of the perfect diffuser lit at
            normal incidence. 0 where the light is behind the surface. [1]

        Raises
        ------
        ArgumentError
            If a vector is not of length 1, an index below 1 or not finite, or no
            ``n`` given for a surface whose index varies with wavelength.

        Notes
        -----
        A normal that faces away from the viewer, as interpolated normals do at
        silhouettes, counts as N·V = 0.001 in the models that divide by it.
        """
        index = one_index(self.n, n)
        return specular(self.lobe, self.constants, index, normals, light, view)

    def parts(
        self,
        normals: ArrayLike,
        light: ArrayLike,
        view: ArrayLike,
        n: ArrayLike | None = None,
    ) -> dict[str, Array]:
        """Return the factors of :meth:`evaluate` but β, for plots.

        ``"distribution"`` is D, ``"attenuation"`` G/(N·V), ``"fresnel"`` F, each of
        the broadcast shape (...).
        """
        index = one_index(self.n, n)
        seen = cosines(*unit_vectors(normals, light, view))
        distribution, attenuation = self.factors(seen)
        fresnel = fresnel_reflectance(seen[4], index)
        arrays = np.broadcast_arrays(distribution, attenuation, fresnel)
        names = ("distribution", "attenuation", "fresnel")
        return dict(zip(names, (np.array(x) for x in arrays), strict=True))


def told_index(n: float | Dispersion) -> str:
    """Return a refractive index in words."""
    return f"n of {n.name}" if isinstance(n, Dispersion) else f"n {n:g}"
