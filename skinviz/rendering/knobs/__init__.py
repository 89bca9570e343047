"""The choices of a plan, a file each: its levels, what they cost, how they are told.

A new one is a new file with a ``KNOB``, a field of ``Plan`` that the pipeline heeds,
and its name below.
"""

from __future__ import annotations

from skinviz.rendering.knobs import (
    arithmetic,
    basis,
    bounce,
    reflectance,
    sampling,
    shading,
    shadows,
    spectrum,
    specular,
)
from skinviz.rendering.knobs.knob import Knob, Setting

KNOBS: tuple[Knob, ...] = (
    spectrum.KNOB,
    basis.KNOB,
    reflectance.KNOB,
    arithmetic.KNOB,
    bounce.KNOB,
    shadows.KNOB,
    specular.KNOB,
    shading.KNOB,
    sampling.KNOB,
)
"""In the order in which they are decided: what later ones are computed with, first."""

__all__ = ["KNOBS", "Knob", "Setting"]
