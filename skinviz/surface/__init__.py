"""Reflection at the skin's surface: Fresnel's law and Torrance–Sparrow's model."""

from skinviz.surface.fresnel import fresnel_reflectance
from skinviz.surface.torrance_sparrow import TorranceSparrow, physical_beta

__all__ = ["TorranceSparrow", "fresnel_reflectance", "physical_beta"]
