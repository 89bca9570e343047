"""Small figures of the gallery, each computed once."""

import pytest

from skinviz.view.gallery.catalogue import figure, recipe_of

COARSE = 30  # dots per inch: pictures of hands are then small


@pytest.fixture(scope="session")
def made():
    """Return a function that gives a figure at a share of its own width."""
    known = {}

    def make(name, share=1.0):
        if (name, share) not in known:
            width = 25.4 * recipe_of(name).width * share
            known[name, share] = figure(name, width=width, dots=COARSE)
        return known[name, share]

    return make
