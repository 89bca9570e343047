"""The viewer as a window of its own: a PyVista plotter with spectral colours."""

from __future__ import annotations

import dataclasses
import os
import sys
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._system import require_system_libraries
from skinviz.errors import SkinvizError
from skinviz.rendering.held import ONE_RAY, SeenPoint, seen_point
from skinviz.rendering.shade import vertex_rgb
from skinviz.rendering.stage import Stage, stage_of
from skinviz.scene.camera import Camera
from skinviz.spectra.colorimetry import xyz_to_lab
from skinviz.view.viewer.opened import Opened

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

_SIZE = (1100, 850)
_HINT = "click: light of a point    drag: turn    wheel: zoom    q: end"
_CURVES = (("total", "k"), ("diffuse", "r"), ("specular", "b"))


def show_window(opened: Opened) -> None:
    """Open a window and wait until it is closed.

    Raises
    ------
    SkinvizError
        If there is no screen.
    """
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise SkinvizError(
            "a window needs a screen, and there is none here; leave out --native to "
            "open the viewer in a browser, also through an SSH tunnel"
        )
    require_system_libraries("vtk")
    window(opened).show()


def window(opened: Opened, *, off_screen: bool = False) -> pyvista.Plotter:
    """Return the plotter: colours follow the camera, and a click reads a point."""
    import pyvista

    plotter = pyvista.Plotter(
        title=f"skinviz: {opened.name}", window_size=_SIZE, off_screen=off_screen
    )
    plotter.ren_win.SetMultiSamples(0)  # four times as slow, and edges are no colours
    plotter.background_color = opened.scene.background
    mesh = opened.scene.mesh.copy(deep=False)
    _aim(plotter, opened)
    mesh.point_data["rgb"] = colours(opened, plotter.camera)
    plotter.add_mesh(mesh, scalars="rgb", rgb=True, lighting=False, name="hand")
    chart = _empty_chart()
    plotter.add_chart(chart)
    plotter.iren.add_observer(
        "EndInteractionEvent", lambda *_: _recolour(plotter, opened, mesh)
    )
    plotter.enable_surface_point_picking(
        callback=partial(read_point, plotter, opened, chart),
        left_clicking=True,
        show_message=False,
        point_size=12,
        color="white",
    )
    plotter.add_text(_HINT, position="lower_left", font_size=9, color="white")
    return plotter


def colours(opened: Opened, camera: Any) -> NDArray[np.uint8]:
    """Return what every vertex (n, 3) shows to a VTK camera."""
    return vertex_rgb(_stage(opened, camera))[0]


def read_point(
    plotter: pyvista.Plotter, opened: Opened, chart: Any, point: Any
) -> None:
    """Write the colour of a point on the window, and draw the light that it sends."""
    if point is None:
        return
    stage = _stage(opened, plotter.camera)
    seen = seen_point(stage, np.asarray(point, dtype=np.float64))
    if seen is None:
        return
    lab = xyz_to_lab(seen.xyz, stage.white)
    text = f"L* {lab[0]:.2f}   a* {lab[1]:.2f}   b* {lab[2]:.2f}"
    plotter.add_text(
        text, position="upper_left", font_size=11, color="white", name="reading"
    )
    _draw(chart, seen)
    plotter.render()


def _empty_chart() -> Any:
    """Return a chart over wavelength, out of sight until there is a point."""
    import pyvista

    chart = pyvista.Chart2D(size=(0.36, 0.34), loc=(0.62, 0.02))
    chart.x_label, chart.y_label = "wavelength (nm)", "radiance / white"
    chart.x_range = (400.0, 700.0)
    chart.background_color = "white"
    chart.visible = False
    return chart


def _draw(chart: Any, seen: SeenPoint) -> None:
    """Draw the radiance of a point in its parts."""
    spectrum = seen.spectrum
    unit = float(np.interp(560.0, spectrum.wavelengths, spectrum.white)) or 1.0
    values = (
        spectrum.diffuse + spectrum.specular,
        spectrum.diffuse,
        spectrum.specular,
    )
    chart.clear()
    for (name, colour), own in zip(_CURVES, values, strict=True):
        chart.line(spectrum.wavelengths, own / unit, color=colour, label=name)
    chart.y_range = (0.0, 1.4 * float(np.max(values)) / unit or 1.0)
    chart.visible = True


def _recolour(plotter: pyvista.Plotter, opened: Opened, mesh: Any) -> None:
    """Give the hand the colours that it shows to a camera that has moved."""
    mesh.point_data["rgb"] = colours(opened, plotter.camera)
    plotter.render()


def _stage(opened: Opened, camera: Any) -> Stage:
    """Return the scene as a VTK camera sees it."""
    scene = opened.scene
    towards = np.subtract(camera.position, camera.focal_point)
    own = Camera(
        towards,
        np.array(camera.up),
        scene.camera.size,
        distance=np.inf
        if camera.parallel_projection
        else float(np.linalg.norm(towards)),
        target=np.array(camera.focal_point),
        height=2 * float(camera.parallel_scale) if camera.parallel_projection else None,
    )
    scene = scene.replace(camera=own)
    return stage_of(scene, ONE_RAY, opened.geometry, whole=True)


def _aim(plotter: pyvista.Plotter, opened: Opened) -> None:
    """Put the window's camera where the scene's is."""
    given = dataclasses.replace(opened.scene.camera, size=_SIZE)
    view = given.view(opened.geometry.in_mm)
    height = view.pixel * _SIZE[1]
    far = np.isinf(view.distance)
    distance = 4 * opened.geometry.scale + height if far else view.distance
    camera = plotter.camera
    camera.focal_point = tuple(view.target)
    camera.position = tuple(view.target + distance * view.direction)
    camera.up = tuple(view.up)
    if far:
        plotter.enable_parallel_projection()
        camera.parallel_scale = height / 2
    else:
        camera.view_angle = float(np.rad2deg(2 * np.arctan2(height / 2, distance)))
