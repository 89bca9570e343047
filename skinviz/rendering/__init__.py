"""From a scene to spectral radiance and colour."""

from skinviz.rendering.colour import DisplayCounts, to_srgb8
from skinviz.rendering.shade import VertexSpectrum, shade, vertex_spectrum

__all__ = ["DisplayCounts", "VertexSpectrum", "shade", "to_srgb8", "vertex_spectrum"]
