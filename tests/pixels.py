"""Where in a scene the samples of a picture are, by the definition of its view."""

import numpy as np


def sample_places(size, cell=(0.5, 0.5)):
    """Columns and rows (h, w) of one place in every pixel."""
    width, height = size
    return np.meshgrid(np.arange(width) + cell[0], np.arange(height) + cell[1])


def places_in_mm(view, cell=(0.5, 0.5)):
    """Where (h, w, 3) samples are seen in the plane through the view's target."""
    width, height = view.size
    columns, rows = sample_places(view.size, cell)
    x, y = (columns - width / 2) * view.pixel, (height / 2 - rows) * view.pixel
    return view.target + x[..., None] * view.right + y[..., None] * view.up
