"""A scene made ready: everything that its points and pixels have in common."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.bounce import Fields, fields_of
from skinviz.rendering.geometry import Geometry, geometry_of
from skinviz.rendering.lighting import Lighting, Spectra, lighting_of, spectra_of
from skinviz.rendering.plan import Plan
from skinviz.rendering.sight import Sight
from skinviz.rendering.spectral import colour_rule, spectra_rule, white_xyz
from skinviz.rendering.tints import Tints, tints_of
from skinviz.scene.lights import Light
from skinviz.scene.scene import Scene
from skinviz.spectra.rules import SpectralRule

Array = NDArray[np.float64]
Made = TypeVar("Made")


@dataclass(frozen=True, eq=False)
class Lit:
    """A scene's light in the two factors of which it is the product.

    Attributes
    ----------
    lighting : Lighting
        What depends on place.
    spectra : Spectra
        What depends on wavelength.
    fields : Fields
        Light that the mesh throws on itself.
    """

    lighting: Lighting
    spectra: Spectra
    fields: Fields

    @cached_property
    def matrix(self) -> Array:
        """What each scalar of uniform skin gives in XYZ (rows + e, 3)."""
        return self.spectra.products(self.fields.spectra) @ self.spectra.colour

    @property
    def rows(self) -> int:
        """How many scalars of lights a point has."""
        return self.lighting.rows


@dataclass(frozen=True, eq=False)
class Stage:
    """A scene, and what follows from it once for all of its points.

    Attributes
    ----------
    scene : Scene
        What is lit and seen.
    plan : Plan
        How finely.
    sight : Sight
        Its mesh, and who looks at it.
    wanted : (n,) ndarray of bool
        At which vertices light is wanted.
    memo : dict
        What was made of the scene already, by the settings of plans that it owes to.
    """

    scene: Scene
    plan: Plan
    sight: Sight
    wanted: NDArray[np.bool_]
    memo: dict[tuple[Any, ...], Any] = field(default_factory=dict, repr=False)

    @property
    def geometry(self) -> Geometry:
        """The mesh."""
        return self.sight.geometry

    @property
    def colours(self) -> Lit:
        """Light as the plan sums it up for eyes."""
        settings = ("spectrum", *self._light_settings)
        return self._once("colours", settings, lambda: self._lit(self.rule))

    @property
    def bands(self) -> Lit:
        """Light at the scene's own wavelengths."""
        rule = spectra_rule
        return self._once(
            "bands", self._light_settings, lambda: self._lit(rule(self.scene))
        )

    @property
    def tints(self) -> Tints:
        """Where the tints of mapped skin come from."""
        settings = ("spectrum", *self._light_settings, "reflectance", "arithmetic")
        return self._once("tints", settings, lambda: tints_of(self))

    @property
    def rule(self) -> SpectralRule:
        """By which the plan sums up colours."""
        spectrum = self.plan.spectrum
        return self._once(
            "rule", ("spectrum",), lambda: colour_rule(self.scene, spectrum)
        )

    @property
    def white(self) -> Array:
        """XYZ (3,) of the perfect diffuser that faces light 1."""
        return self._once("white", (), lambda: white_xyz(self.scene))

    def relit(self, lights: Iterable[Light]) -> Stage:
        """Return the stage under other lights: what a light that moves costs.

        Where only places change, the light's spectra are not computed anew.
        """
        scene = self.scene.replace(lights=tuple(lights))
        stage = dataclasses.replace(self, scene=scene, memo={})
        if _alike(self.scene, scene):
            old = self.colours
            lighting = lighting_of(scene, self.sight, old.lighting.indices)
            settings = ("spectrum", *self._light_settings)
            stage._once(
                "colours", settings, lambda: stage._shone(lighting, old.spectra)
            )
        return stage

    def replanned(self, **changes: Any) -> Stage:
        """Return the stage with some of its plan changed; what stays is not redone."""
        return dataclasses.replace(self, plan=self.plan.replace(**changes))

    def only_at(self, wanted: NDArray[np.bool_]) -> Stage:
        """Return the stage with light wanted at other vertices (n,)."""
        kept = {key: value for key, value in self.memo.items() if key[0] == "rule"}
        return dataclasses.replace(self, wanted=wanted, memo=kept)

    def _once(
        self, name: str, settings: tuple[str, ...], make: Callable[[], Made]
    ) -> Made:
        """Return what is made of the scene by some settings, made once for each."""
        key = (name, *(getattr(self.plan, setting) for setting in settings))
        if key not in self.memo:
            self.memo[key] = make()
        return cast(Made, self.memo[key])

    @property
    def _light_settings(self) -> tuple[str, ...]:
        """What of the plan the light depends on before any ray is cast."""
        if self.scene.interreflection == "none":
            return ("specular", "basis")
        return ("specular", "basis", "bounce_rays")

    def _lit(self, rule: SpectralRule) -> Lit:
        """Return the scene's light as one rule samples it."""
        spectra, indices = spectra_of(self.scene, rule, self.plan)
        return self._shone(lighting_of(self.scene, self.sight, indices), spectra)

    def _shone(self, lighting: Lighting, spectra: Spectra) -> Lit:
        """Return light with what the mesh throws on itself."""
        fields = fields_of(
            *(self.scene, self.geometry, lighting, spectra, self.plan),
            wanted=self.wanted,
        )
        return Lit(lighting, spectra, fields)


def stage_of(
    scene: Scene,
    plan: Plan | None = None,
    geometry: Geometry | None = None,
    *,
    whole: bool = False,
) -> Stage:
    """Make a scene ready.

    Parameters
    ----------
    scene : Scene
        What is lit and seen.
    plan : Plan, optional
        How finely; the reference by default.
    geometry : Geometry, optional
        Of the scene's mesh, where it is at hand from :func:`geometry_of`.
    whole : bool
        Whether light is wanted at vertices too that the eye cannot see.

    Returns
    -------
    stage : Stage
        To be shaded or traced.

    Raises
    ------
    MeshError
        If the mesh is empty, has no extent or a vertex that is not finite.
    ArgumentError
        If the eye is within the mesh's reach where all of it is to be seen.
    """
    geometry = geometry or geometry_of(scene.mesh)
    sight = Sight(geometry, scene.camera.view(geometry.in_mm), scene.relief)
    wanted = np.ones(len(geometry.points), np.bool_) if whole else sight.seen
    return Stage(scene, plan or Plan(), sight, wanted)


def _alike(one: Scene, other: Scene) -> bool:
    """Return whether two scenes' lights have the same spectra and strengths."""
    return [(light.illuminant, light.strength) for light in one.lights] == [
        (light.illuminant, light.strength) for light in other.lights
    ]
