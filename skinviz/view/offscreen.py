"""Pictures of shaded meshes, drawn off-screen by VTK."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._files import whole_file
from skinviz._system import require_system_libraries
from skinviz._validate import one_of
from skinviz.errors import MeshError
from skinviz.scene.scene import Camera
from skinviz.spectra.colorimetry import decode_srgb, encode_srgb

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

BACKGROUND = (46, 46, 46)
"""A dark neutral surround. [8-bit sRGB]"""

_OVERSAMPLING = 3
_LARGEST_CANVAS = 16384  # pixels a side that software OpenGL draws
_ROWS = 64
_MARGIN = 1.06


@dataclass(frozen=True)
class Picture:
    """A picture and where points of the scene lie in it.

    Attributes
    ----------
    rgb : (height, width, 3) ndarray of uint8
        sRGB.
    centre : (3,) ndarray
        The point shown in the middle. [mm]
    camera : Camera
        The view.
    scale : float
        Pixels per millimetre.
    """

    rgb: NDArray[np.uint8]
    centre: Array
    camera: Camera
    scale: float

    def project(self, point: ArrayLike) -> tuple[float, float]:
        """Return the pixel (column, row), from the top left, of a point [mm]."""
        offset = np.asarray(point, dtype=np.float64) - self.centre
        right = np.cross(self.camera.up, self.camera.direction)
        width, height = self.camera.size
        return (
            width / 2 + self.scale * float(offset @ right),
            height / 2 - self.scale * float(offset @ self.camera.up),
        )


def draw(mesh: pyvista.PolyData, camera: Camera) -> Picture:
    """Draw a mesh's own ``rgb`` colours, unlit, as one parallel view of it all.

    Parameters
    ----------
    mesh : pyvista.PolyData
        With point data ``rgb``, as :func:`skinviz.shade` returns.
    camera : Camera
        The view and the size of the picture.

    Returns
    -------
    picture : Picture
        Edges smoothed by averaging 3 × 3 samples a pixel in linear light, fewer
        where the graphics driver's canvas is too small for them.

    Raises
    ------
    MeshError
        If the mesh has no ``rgb``.
    SystemLibraryError
        If a system library that VTK draws with is missing.
    """
    require_system_libraries("vtk")
    if "rgb" not in mesh.point_data:
        raise MeshError("the mesh has no colours rgb to draw; shade it first")
    import pyvista as pv

    points = np.asarray(mesh.points, dtype=np.float64)
    right = np.cross(camera.up, camera.direction)
    seen = np.stack([points @ right, points @ camera.up], axis=1)
    low, high = seen.min(axis=0), seen.max(axis=0)
    middle = (low + high) / 2
    depth = points @ camera.direction
    centre = (
        middle[0] * right
        + middle[1] * camera.up
        + (depth.min() + depth.max()) / 2 * camera.direction
    )
    width, height = camera.size
    half = (
        max((high - low)[1] / 2, (high - low)[0] / 2 * height / width, 1e-9) * _MARGIN
    )
    reach = float(np.ptp(depth)) + 2 * half
    samples = max(1, min(_OVERSAMPLING, _LARGEST_CANVAS // max(width, height)))
    large = (width * samples, height * samples)
    plotter = pv.Plotter(off_screen=True, window_size=list(large))
    try:
        plotter.render_window.SetMultiSamples(0)
        plotter.set_background(BACKGROUND)
        plotter.add_mesh(mesh, scalars="rgb", rgb=True, lighting=False)
        plotter.camera.parallel_projection = True
        plotter.camera.focal_point = centre
        plotter.camera.position = centre + reach * camera.direction
        plotter.camera.up = camera.up
        plotter.camera.parallel_scale = half
        plotter.camera.clipping_range = (reach * 1e-3, 3 * reach)
        fine = np.asarray(plotter.screenshot(return_img=True))
    finally:
        plotter.close()
    return Picture(_averaged(fine, samples), centre, camera, height / (2 * half))


def save_picture(picture: Picture, path: str | os.PathLike[str]) -> Path:
    """Write a picture as PNG, marked as sRGB, whole or not at all."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    file = Path(path)
    one_of(file.suffix.lower(), (".png",), "suffix of a picture")
    marks = PngInfo()
    marks.add(b"sRGB", b"\x00")  # rendering intent: perceptual
    with whole_file(file) as partial:
        Image.fromarray(picture.rgb).save(partial, format="PNG", pnginfo=marks)
    return file


def _averaged(fine: NDArray[np.uint8], samples: int) -> NDArray[np.uint8]:
    """Return a picture shrunk by averaging blocks of samples in linear light."""
    height, width = fine.shape[0] // samples, fine.shape[1] // samples
    rgb = np.zeros((height, width, 3), dtype=np.uint8)
    # Some rows at a time, which bounds the memory of large pictures.
    for top in range(0, height, _ROWS):
        rows = fine[top * samples : (top + _ROWS) * samples, :, :3]
        linear = decode_srgb(rows / 255.0)
        blocks = linear.reshape(-1, samples, width, samples, 3).mean(axis=(1, 3))
        rgb[top : top + _ROWS] = np.round(255 * encode_srgb(blocks))
    return rgb
