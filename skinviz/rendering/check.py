"""Whether a finished picture keeps its tolerance: looked up at pixels drawn anew."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering import trace
from skinviz.rendering.finding import Finding
from skinviz.rendering.imager import Image, image_of
from skinviz.rendering.knobs import KNOBS
from skinviz.rendering.painter import Painter
from skinviz.rendering.pilot import point_colours
from skinviz.rendering.plan import MOST_SAMPLES, Plan, cells
from skinviz.rendering.stage import Stage
from skinviz.rendering.tolerance import colour_differences, is_lit

Array = NDArray[np.float64]

_PIXELS = 1000
_WORTH = 20  # times as many rays, that a picture has at least where it is looked up
_SEED = 49574  # other than the pilot's: what was chosen by luck shows

_PICTURE = {"shadows": True, "specular": "dispersion", "shading": "points"}


def checked(stage: Stage, image: Image) -> tuple[Stage, Image]:
    """Return a stage and its picture, drawn finer until it keeps the tolerance.

    Small pictures are as they are: to look anything up would cost as much. Looked at
    are pixels that the mesh fills, traced with all samples and all that the
    plan left out of light and place; what it has of wavelengths and of light between
    parts was priced by itself, and its price is taken off the tolerance.
    """
    plan = stage.plan
    if int(image.rays.sum(dtype=np.int64)) < _WORTH * _PIXELS * MOST_SAMPLES:
        return stage, image
    allowed = (plan.tolerance or 0.0) - _spent(plan)
    exact = stage.replanned(samples=MOST_SAMPLES, refine=None, **_PICTURE)
    rng = np.random.default_rng(_SEED)
    while _saves(stage):
        difference, n = _difference(exact, image, rng)
        if difference <= allowed:
            told = Finding("check", f"{n} pixels anew", "", difference)
            return stage.replanned(findings=(*stage.plan.findings, told)), image
        stage = _finer(stage)
        image = image_of(stage)
    return stage, image


def _spent(plan: Plan) -> float:
    """Return what of a plan's tolerance is used up by what was priced by itself."""
    spent: dict[str, float] = {}
    groups = {knob.name: knob.group for knob in KNOBS if knob.share is not None}
    for finding in plan.findings:
        if finding.knob in groups:
            group = groups[finding.knob]
            spent[group] = max(spent.get(group, 0.0), finding.delta_e or 0.0)
    return sum(spent.values())


def _saves(stage: Stage) -> bool:
    """Return whether a plan leaves anything out that can be looked up."""
    plan = stage.plan
    return plan.samples < MOST_SAMPLES or any(
        getattr(plan, name) != value for name, value in _PICTURE.items()
    )


def _finer(stage: Stage) -> Stage:
    """Return the stage with all of light and place, and twice the samples."""
    plan = stage.plan
    samples = min(2 * plan.samples, MOST_SAMPLES)
    fine = plan.refine is None or samples == MOST_SAMPLES
    refine = None if fine else plan.refine / 4  # type: ignore[operator]
    return stage.replanned(samples=samples, refine=refine, **_PICTURE)


def _difference(
    exact: Stage, image: Image, rng: np.random.Generator
) -> tuple[float, int]:
    """Return the 99th percentile over some pixels, of how many. [ΔE00]"""
    filled = np.flatnonzero((image.covered > 0) & (image.covered == image.rays))
    if filled.size > _PIXELS:
        filled = np.sort(rng.choice(filled, _PIXELS, replace=False))
    if filled.size == 0:
        return 0.0, 0
    hits = trace.cast(exact.sight, cells(MOST_SAMPLES), filled)
    flat = point_colours(Painter(exact), hits.apart(filled.size * MOST_SAMPLES))
    truth = flat.reshape(filled.size, MOST_SAMPLES, 3).mean(axis=1)
    own = image.xyz[filled].astype(np.float64)
    lit = is_lit(own, truth)
    differences = colour_differences(own[lit], truth[lit], exact.white)
    if differences.size == 0:
        return 0.0, 0
    return float(np.percentile(differences, 99)), differences.size
