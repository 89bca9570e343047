"""What a change of plan does to the colours of a pilot: the price of a knob."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.rendering.knobs.bounce import trial_rays
from skinviz.rendering.painter import Painter
from skinviz.rendering.pilot import Pilot, point_colours
from skinviz.rendering.plan import MOST_SAMPLES
from skinviz.rendering.stage import Stage

Array = NDArray[np.float64]
Setting = Mapping[str, Any]

_GAIN = 2.0  # by which four times as many rays are surely better


@dataclass(frozen=True, eq=False)
class Trial:
    """A pilot, and a stage whose plan is to be changed.

    Attributes
    ----------
    pilot : Pilot
        The pixels that are looked at.
    base : Stage
        What is compared with: the reference, but for what was decided before and has
        its share of the tolerance.
    stage : Stage
        With all that was decided before.
    """

    pilot: Pilot
    base: Stage
    stage: Stage

    @cached_property
    def truth(self) -> Array:
        """XYZ of every ray (k, 16, 3) of the filled pixels, as the base has it."""
        return self.pilot.filled.colours(Painter(self.base))

    @cached_property
    def own(self) -> Array:
        """The same as the stage has it."""
        if self.stage is self.base:
            return self.truth
        return self.pilot.filled.colours(Painter(self.stage))

    @cached_property
    def edge_truth(self) -> Array:
        """XYZ of the edge pixels (k, 3), as the base has it."""
        return np.asarray(self.pilot.edges.colours(Painter(self.base)).mean(axis=1))

    def after(self, stage: Stage) -> Trial:
        """Return the trial of a stage on which more was decided."""
        trial = Trial(self.pilot, self.base, stage)
        for name in ("truth", "edge_truth"):  # which the base alone decides
            if name in self.__dict__:
                trial.__dict__[name] = self.__dict__[name]
        return trial

    def edge_difference(self, setting: Setting) -> float:
        """Return what a setting changes in edge pixels, which have all samples."""
        if self.pilot.edges.pixels.size == 0:
            return 0.0
        painter = Painter(self.stage.replanned(**setting))
        own = self.pilot.edges.colours(painter).mean(axis=1)
        return self.pilot.edge_difference(own, self.edge_truth)

    def difference(self, setting: Setting, allowed: float = np.inf) -> float:
        """Return a bound on what a setting changes in filled pixels. [ΔE00]

        Where some of the pixels show that it is more than allowed, it is not found
        out how much more.
        """
        painter = Painter(self.stage.replanned(**setting))
        some = self.pilot.some[1].colours(painter).mean(axis=1)
        floor = self.pilot.floor(some, self._true_means)
        if floor > allowed:
            return floor
        changed = self.pilot.filled.colours(painter)
        return self.pilot.judge(changed.mean(axis=1), self._true_means)

    def body_difference(self, setting: Setting) -> float:
        """Return a bound on what another reflectance or its sum changes. [ΔE00]

        Judged at one point of each pixel against the model at every nanometre, as if
        all lights met it at normal incidence and nothing shone: no point is brighter
        but by its shine, which has no such error.
        """
        stage = self.stage.replanned(**setting, bounce_rays=0)
        try:
            own = self.pilot.full_light(stage)
        except ArgumentError:  # bands that one of the lamps does not cover
            return float("inf")
        return self.pilot.judge(own, self.pilot.exact_full_light)

    def bounce_difference(self, setting: Setting) -> float:
        """Return a bound on what fewer rays between parts change. [ΔE00]

        Judged by one ray of each pixel, and by fewer directions than the reference's
        where the picture is large.
        """
        n, most = setting["bounce_rays"], trial_rays(self.pilot.population)
        if n < most:
            return self._gathered_difference(n, most)
        # By the error of a quarter of them, which falls at least as 1/√n.
        return self._gathered_difference(most // 4, most) / _GAIN

    def _gathered_difference(self, n_rays: int, most: int) -> float:
        """Return a bound on what ``n_rays`` change against the most. [ΔE00]"""
        return self.pilot.judge(self._gathered(n_rays), self._gathered(most))

    def _gathered(self, n_rays: int) -> Array:
        """Return XYZ (k, 3) of one ray of each pixel with so many rays a vertex."""
        if n_rays in self._found:
            return self._found[n_rays]
        hits = self.pilot.one_each
        wanted = np.zeros(len(self.stage.geometry.points), dtype=np.bool_)
        wanted[self.stage.geometry.faces[hits.triangles]] = True
        stage = self.stage.only_at(wanted).replanned(bounce_rays=n_rays)
        self._found[n_rays] = point_colours(Painter(stage), hits)
        return self._found[n_rays]

    def sampling_difference(self, setting: Setting) -> float:
        """Return a bound on what fewer samples change in filled pixels. [ΔE00]"""
        samples, refine = setting["samples"], setting["refine"]
        if samples == MOST_SAMPLES:
            return self.pilot.judge(self._own_means(MOST_SAMPLES), self._true_means)
        rough = self.rough(samples) > refine
        few, all_of_them = self._own_means(samples), self._own_means(MOST_SAMPLES)
        changed = np.where(rough[:, None], all_of_them, few)
        return self.pilot.judge(changed, self._true_means)

    @cached_property
    def _true_means(self) -> Array:
        """XYZ (k, 3) of the filled pixels, as the base has it."""
        return np.asarray(self.truth.mean(axis=1))

    def _own_means(self, samples: int) -> Array:
        """Return XYZ (k, 3) of the filled pixels by so many samples of the stage."""
        if samples not in self._means:
            self._means[samples] = self.own[:, :samples].mean(axis=1)
        return self._means[samples]

    @cached_property
    def _means(self) -> dict[int, Array]:
        """Means found so far, by samples."""
        return {}

    def rough(self, samples: int) -> Array:
        """Return the contrast of each filled pixel, ``inf`` where an outline is."""
        if samples not in self._rough:
            contrast = self.pilot.contrasts(Painter(self.stage), self.own, samples)
            outlined = self.pilot.stage.sight.outlines.ravel()
            contrast[outlined[self.pilot.filled.pixels]] = np.inf
            self._rough[samples] = contrast
        return self._rough[samples]

    @cached_property
    def _rough(self) -> dict[int, Array]:
        """Contrasts found so far, by samples."""
        return {}

    @cached_property
    def _found(self) -> dict[int, Array]:
        """Colours with light between parts found so far, by rays a vertex."""
        return {}
