"""The texts that a figure shows, and whether all of them can be read."""

import itertools

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text


def texts_of(figure):
    """Draw a figure; give the texts that were drawn, with their boxes in pixels."""
    texts = []
    draw = Text.draw

    def spy(self, renderer):
        if self.get_visible() and self.get_text().strip():
            texts.append((self.get_text(), self.get_window_extent(renderer)))
        return draw(self, renderer)

    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # settles the layout
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", spy)
        canvas.draw()
    return texts


def check_inside(figure, texts):
    """Refuse a word that runs over the canvas' edge."""
    width, height = figure.get_size_inches() * figure.dpi
    for text, box in texts:
        assert box.x0 >= 0, text
        assert box.y0 >= 0, text
        assert box.x1 <= width, text
        assert box.y1 <= height, text


def check_apart(texts):
    """Refuse two texts of which one lies on the other."""
    for (first, a), (second, b) in itertools.combinations(texts, 2):
        wide = min(a.x1, b.x1) - max(a.x0, b.x0)
        high = min(a.y1, b.y1) - max(a.y0, b.y0)
        # A box has a little air of its own around the ink.
        assert wide <= 1 or high <= 1, f"{first!r} on {second!r}"
