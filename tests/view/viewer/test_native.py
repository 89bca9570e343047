"""The window: spectral colours on the mesh, and points that are read."""

import numpy as np
import pytest

from skinviz._system import require_system_libraries
from skinviz.errors import SkinvizError
from skinviz.rendering.shade import shade
from skinviz.view.viewer import native


@pytest.fixture
def plotter(opened):
    require_system_libraries("vtk")
    made = native.window(opened, off_screen=True)
    yield made
    made.close()


def test_colours_are_those_of_shade(opened, plotter):
    expected = shade(opened.scene).point_data["rgb"]
    seen = shade(opened.scene)["rgb"].any(axis=1)
    shown = native.colours(opened, plotter.camera)
    off = np.abs(shown.astype(int) - expected.astype(int))
    assert off[seen].max() <= 1


def test_the_window_shows_colours_without_lighting_them(opened, plotter):
    """The middle of the picture has the colour of a vertex there."""
    plotter.show(auto_close=False)
    image = plotter.screenshot(return_img=True)
    height, width, _ = image.shape
    middle = image[height // 2, width // 2].astype(int)
    assert plotter.ren_win.GetMultiSamples() == 0
    points = np.asarray(opened.scene.mesh.points)
    nearest = np.argmin(np.linalg.norm(points - [0, 0, 40], axis=1))
    colour = native.colours(opened, plotter.camera)[nearest].astype(int)
    assert np.abs(middle - colour).max() <= 2


def test_colours_follow_the_camera(opened, plotter):
    before = native.colours(opened, plotter.camera)
    plotter.camera.azimuth = 50
    assert (native.colours(opened, plotter.camera) != before).any()


def test_a_point_is_read(opened, plotter):
    (chart,) = plotter.renderer._charts
    assert not chart.visible
    for _ in range(2):
        native.read_point(plotter, opened, chart, (0.0, 0.0, 39.99))
        assert [line.label for line in chart.plots()] == [
            "total",
            "diffuse",
            "specular",
        ]
    total, diffuse, specular = (np.array(line.y) for line in chart.plots())
    np.testing.assert_allclose(total, diffuse + specular)
    assert chart.visible
    native.read_point(plotter, opened, chart, None)
    assert "reading" in plotter.actors


def test_without_a_screen_it_says_what_to_do(opened, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(SkinvizError, match="--native"):
        native.show_window(opened)
