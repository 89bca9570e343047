"""How much there is to compute of a scene, counted before it is."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from skinviz.rendering.plan import MOST_SAMPLES, Plan
from skinviz.rendering.stage import Stage

_NODES = 3  # channels of XYZ
_USUAL_ROUGH = 0.03  # share of pixels, where no pilot has counted them
_NO_CONTRAST = 1e3  # above which no pixel's is
_USUAL_SHARE = 0.8  # of the pixels that may show the mesh, that do
TABLE_ENTRIES = 1000
"""Entries that a table of tints is taken to have, before there is one."""


@dataclass(frozen=True, eq=False)
class Work:
    """What a scene asks for.

    Attributes
    ----------
    stage : Stage
        The scene, ready.
    pixels : float
        How many pixels may show the mesh.
    share : float
        How many of these do. [1]
    outlined : float
        How many an outline crosses.
    rough : dict of (int, float) to float
        The share of pixels that have all samples, by ``samples`` and ``refine``.
    """

    stage: Stage
    pixels: float
    share: float
    outlined: float
    rough: dict[tuple[int, float], float] = field(default_factory=dict)

    @property
    def mapped(self) -> bool:
        """Whether the skin differs from point to point."""
        return self.stage.scene.skin.values.ndim > 1

    @property
    def bounces(self) -> bool:
        """Whether the scene declares light between its parts."""
        return self.stage.scene.interreflection != "none"

    @property
    def lights(self) -> int:
        """How many lights there are."""
        return len(self.stage.scene.lights)

    @property
    def vertices(self) -> int:
        """At how many vertices light may be wanted."""
        return int(self.stage.wanted.sum())

    @property
    def channels(self) -> int:
        """How many numbers a tint has."""
        return _NODES * (self.lights + (4 if self.bounces and self.mapped else 0))

    def rays(self, plan: Plan) -> float:
        """How many rays a plan casts from the eye."""
        if plan.refine is None or plan.samples == MOST_SAMPLES:
            return plan.samples * self.pixels
        few = max(self.pixels - self.outlined, 0.0)
        usual = _USUAL_ROUGH if plan.refine < _NO_CONTRAST else 0.0
        rough = self.rough.get((plan.samples, plan.refine), usual)
        return plan.samples * few + MOST_SAMPLES * (
            self.outlined + rough * self.share * few
        )

    def points(self, plan: Plan) -> float:
        """How many of these rays find skin."""
        return self.share * self.rays(plan)


def work_of(stage: Stage) -> Work:
    """Return what a scene asks for, by what is known without a ray."""
    block, marked = stage.sight.blocks
    width, height = stage.sight.view.size
    return Work(
        stage,
        pixels=min(float(marked.sum()) * block**2, float(width * height)),
        share=_USUAL_SHARE,
        outlined=float(np.count_nonzero(stage.sight.outlines)),
    )
