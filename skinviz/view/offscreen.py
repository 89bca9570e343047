"""Pictures of shaded meshes, drawn off-screen by VTK."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz._system import require_system_libraries
from skinviz._validate import one_of
from skinviz.errors import MeshError
from skinviz.scene.camera import Camera, View
from skinviz.scene.scene import BACKGROUND
from skinviz.spectra.colorimetry import decode_srgb, encode_srgb

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

_OVERSAMPLING = 3
_LARGEST_CANVAS = 16384  # pixels a side that software OpenGL draws
_ROWS = 64


@dataclass(frozen=True)
class Picture:
    """A picture and where points of the scene lie in it.

    Attributes
    ----------
    rgb : (height, width, 3) ndarray of uint8
        sRGB.
    view : View
        Where points of the scene lie in it.
    """

    rgb: NDArray[np.uint8]
    view: View


def draw(mesh: pyvista.PolyData, camera: Camera) -> Picture:
    """Draw a mesh's own ``rgb`` colours, unlit.

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
    view = camera.view(points)
    width, height = camera.size
    half = view.pixel * height / 2
    depth = (points - view.target) @ view.direction
    far = view.distance == np.inf
    reach = max(float(depth.max()), 0) + 2 * half if far else view.distance
    samples = max(1, min(_OVERSAMPLING, _LARGEST_CANVAS // max(width, height)))
    large = (width * samples, height * samples)
    plotter = pv.Plotter(off_screen=True, window_size=list(large))
    try:
        plotter.render_window.SetMultiSamples(0)
        plotter.set_background(BACKGROUND)
        plotter.add_mesh(mesh, scalars="rgb", rgb=True, lighting=False)
        _aim(plotter, view, half, reach)
        plotter.camera.clipping_range = (
            max(reach - float(depth.max()), 0) * 0.99 + reach * 1e-4,
            (reach - float(depth.min())) * 1.01,
        )
        fine = np.asarray(plotter.screenshot(return_img=True))
    finally:
        plotter.close()
    return Picture(_averaged(fine, samples), view)


def _aim(plotter: pyvista.Plotter, view: View, half: float, reach: float) -> None:
    """Look along a view from a distance; ``half`` is half the height shown. [mm]"""
    plotter.camera.focal_point = view.target
    plotter.camera.position = view.target + reach * view.direction
    plotter.camera.up = view.up
    if view.distance == np.inf:
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = half
    else:
        plotter.camera.view_angle = 2 * np.rad2deg(np.arctan2(half, view.distance))


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
