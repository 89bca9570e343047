"""From a scene to spectral radiance and colour."""

from skinviz.rendering.colour import DisplayCounts, to_srgb8
from skinviz.rendering.geometry import Geometry, geometry_of
from skinviz.rendering.plan import Plan
from skinviz.rendering.render import Rendering, render
from skinviz.rendering.shade import VertexSpectrum, shade, vertex_spectrum

__all__ = [
    "DisplayCounts",
    "Geometry",
    "Plan",
    "Rendering",
    "VertexSpectrum",
    "geometry_of",
    "render",
    "shade",
    "to_srgb8",
    "vertex_spectrum",
]
