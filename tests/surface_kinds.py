"""Directions, and every kind of surface over the range of widths."""

import numpy as np
from hypothesis import strategies as st

from skinviz.surface import CookTorrance, Lambert, Phong, TorranceSparrow

UP = np.array([0.0, 0.0, 1.0])
HALF_PI = np.pi / 2
NARROWEST, WIDEST = 1e-4, HALF_PI


def direction(polar, azimuth=0.0):
    """Return a unit vector at an angle from the normal."""
    sine = np.sin(polar)
    return np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(polar)])


def rotation(axis, angle):
    """Return Rodrigues' matrix."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


polar = st.integers(0, 8900).map(lambda x: np.deg2rad(x / 100))
azimuths = st.integers(0, 35_999).map(lambda x: np.deg2rad(x / 100))
upwards = st.tuples(polar, azimuths)

EVERYWHERE = np.array(
    [
        direction(p, a)
        for p in (0, 0.5, HALF_PI - 1e-9, HALF_PI, HALF_PI + 1e-9, 2.5, np.pi)
        for a in (0.0, 1.0, np.pi)
    ]
)


def _phong(width, **options):
    """Return a lobe about as wide as facets of a half-width make it."""
    return Phong(np.log(2) / (2 * width * width), **options)


def _lambert(width, **options):
    """Return the surface that has no lobe, whatever it is asked for."""
    return Lambert()


SURFACES = {
    "torrance-sparrow": TorranceSparrow,
    "torrance-sparrow, none": lambda w, **o: TorranceSparrow(w, masking="none", **o),
    "cook-torrance": CookTorrance,
    "cook-torrance, smith": lambda w, **o: CookTorrance(w, masking="smith", **o),
    "cook-torrance, none": lambda w, **o: CookTorrance(w, masking="none", **o),
    "phong": _phong,
    "lambert": _lambert,
}
"""Each model with each of its maskings, as functions of a width. [rad or 1]"""

BOUNDED = tuple(name for name in SURFACES if "none" not in name)
"""Those that conserve energy."""
