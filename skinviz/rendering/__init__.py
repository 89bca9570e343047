"""From a scene to spectral radiance and colour: pictures, and values at vertices."""

from skinviz.rendering.geometry import Geometry, geometry_of
from skinviz.rendering.plan import Plan
from skinviz.rendering.render import Rendering, render
from skinviz.rendering.shade import VertexSpectrum, shade, vertex_spectrum

__all__ = [
    "Geometry",
    "Plan",
    "Rendering",
    "VertexSpectrum",
    "geometry_of",
    "render",
    "shade",
    "vertex_spectrum",
]
