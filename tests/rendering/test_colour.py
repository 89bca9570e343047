"""From XYZ to display values, with what does not fit counted."""

import numpy as np
import pytest

from skinviz.rendering import to_srgb8


def test_display_values_are_those_of_colour_science(colour):
    rng = np.random.default_rng(0)
    xyz = rng.uniform(0, 1, (500, 3)) * [0.95, 1.0, 1.09]
    expected = 255 * np.clip(colour.XYZ_to_sRGB(xyz), 0, 1)
    rgb, _ = to_srgb8(xyz)
    assert rgb.dtype == np.uint8
    # The standard prints its matrix with four decimals; colour-science the same.
    assert np.abs(rgb - expected).max() <= 1


def test_white_is_white_and_black_is_black():
    rgb, counts = to_srgb8(np.array([[0.9505, 1.0, 1.089], [0.0, 0.0, 0.0]]))
    assert rgb.tolist() == [[255] * 3, [0] * 3]
    assert counts.total == 2


def test_what_does_not_fit_is_cut_and_counted():
    inside = [0.3, 0.3, 0.3]
    bright = [2.0, 2.0, 2.0]
    green = [0.1, 0.5, 0.05]  # a spectral green: red is below 0
    both = [0.5, 2.0, 0.1]
    rgb, counts = to_srgb8(np.array([[inside, bright], [green, both]]))
    assert rgb.shape == (2, 2, 3)
    assert (counts.total, counts.over_exposed, counts.out_of_gamut) == (4, 2, 2)
    assert rgb[0, 1].tolist() == [255] * 3
    assert rgb[1, 0, 0] == 0


@pytest.mark.parametrize("shape", [(3,), (0, 3), (4, 5, 3)])
def test_any_shape_of_colours_is_encoded(shape):
    rgb, counts = to_srgb8(np.full(shape, 0.2))
    assert rgb.shape == shape
    assert counts.total == np.prod(shape[:-1])


def test_brighter_grey_is_never_shown_darker():
    grey = np.linspace(0, 1.2, 5000)[:, None] * [0.9505, 1.0, 1.089]
    rgb, _ = to_srgb8(grey)
    assert (np.diff(rgb.astype(int), axis=0) >= 0).all()
    assert len(np.unique(rgb[:, 1])) == 256
