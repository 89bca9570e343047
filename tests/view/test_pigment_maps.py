"""Maps of a fitted cube: the right pixels in them, every word readable."""

import matplotlib as mpl
import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import fit_skin, skin_model
from skinviz.view.pigment_maps import FLAT, maps_figure, own_colour

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="cheek", specular="included")


def cube(lines, samples, seed=0):
    """Return spectra (line, sample, n) whose melanin rises with the sample."""
    rng = np.random.default_rng(seed)
    weights = np.zeros((lines, samples, 3))
    weights[..., 0] = np.linspace(0.05, 0.3, samples)
    weights[..., 1] = rng.uniform(0.004, 0.01, (lines, samples))
    weights[..., 2] = 0.004
    return MODEL.measured(weights, NM)


def figure_of(measured):
    fit = fit_skin(measured, NM, MODEL)
    return fit, maps_figure(
        measured, fit, "two-layer model", "specular included; a.hdr"
    )


def panels(figure):
    """Return the axes that have a map, by the first line of their titles."""
    return {a.get_title().split("\n")[0]: a for a in figure.axes if a.get_title()}


@pytest.mark.parametrize(
    "shape", [(5, 4), (1, 1), (1, 200), (200, 1), (60, 80), (30, 300), (40, 1300)]
)
def test_every_size_of_cube_can_be_read(shape):
    _, figure = figure_of(cube(*shape))
    texts = texts_of(figure)
    check_inside(figure, texts)
    check_apart(texts)


def test_each_panel_shows_its_quantity():
    fit, figure = figure_of(cube(5, 4))
    shown = panels(figure)
    assert list(shown) == [
        *("colour under D65", "w_m", "w_h", "w_dh", "oxygen saturation", "RMSE")
    ]
    expected = [*np.moveaxis(fit.values, -1, 0), fit.oxygen_saturation, fit.rmse]
    for axes, values in zip(list(shown.values())[1:], expected, strict=True):
        assert_array_equal(axes.images[0].get_array(), values)
    labels = [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]
    assert labels[0] == "w_m [1]"
    assert len(labels) == 5


def test_refused_pixels_are_flat_grey_and_counted():
    measured = cube(5, 4)
    measured[1, 2] = 2.0
    measured[4, 0] = np.nan
    _, figure = figure_of(measured)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[::-1, :, :3] / 255
    for name, axes in panels(figure).items():
        at = axes.transData.transform([(2, 1), (0, 4), (1, 1)]).astype(int)
        colours = pixels[at[:, 1], at[:, 0]]
        flat = np.abs(colours - to_rgb(FLAT)).max(axis=1) < 0.01
        # The highlight has a colour of its own, the missing spectrum has none.
        assert flat.tolist() == [name != "colour under D65", True, False]
    said = " ".join(text.get_text() for text in figure.texts).replace("\n", " ")
    assert "2 of 20 refused and 0 not converged" in said
    viridis = mpl.colormaps["viridis"](np.linspace(0, 1, 256))[:, :3]
    assert np.abs(viridis - to_rgb(FLAT)).max(axis=1).min() > 0.2


def test_a_large_cube_is_thinned_out_and_the_caption_says_it():
    fit, figure = figure_of(cube(3, 1300))
    said = " ".join(text.get_text() for text in figure.texts).replace("\n", " ")
    assert "3 × 1300 pixels" in said
    assert "one pixel in 3 of one line in 3" in said
    image = panels(figure)["w_m"].images[0]
    assert_array_equal(image.get_array(), fit.values[::3, ::3, 0])
    assert image.get_extent() == [-0.5, 1299.5, 2.5, -0.5]


def test_a_cube_without_one_fitted_pixel_is_drawn():
    _, figure = figure_of(np.full((2, 3, NM.size), np.nan))
    assert any("no pixel fitted" in text for text, _ in texts_of(figure))


def test_the_cubes_colour_is_that_of_its_spectra():
    spectra = np.full((1, 3, NM.size), [[1.0], [0.2], [np.nan]])
    rgba = own_colour(spectra, NM)[0]
    assert_allclose(rgba[0], 1.0, atol=0.01)
    # A grey of 20 %: sRGB's encoding of 0.2 in each channel.
    assert_allclose(rgba[1, :3], 1.055 * 0.2 ** (1 / 2.4) - 0.055, atol=0.01)
    assert rgba[2, 3] == 0
