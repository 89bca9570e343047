"""From a scene's XYZ to what its display shows, what it cannot show counted."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.spectral import white_xyz
from skinviz.scene.scene import Scene
from skinviz.spectra.adaptation import adaptation
from skinviz.spectra.display import DisplayCounts

Array = NDArray[np.float64]

_PIXELS = 2**18  # that are encoded at once, which bounds the memory


def display_matrix(scene: Scene) -> Array:
    """Return the matrix (3, 3) from a scene's XYZ to its display's linear colours.

    Raises
    ------
    ArgumentError
        If the scene asks for adaptation to a light that eyes cannot adapt to.
    """
    display = scene.display
    if scene.white == "none":
        return display.matrix
    white = white_xyz(scene) / scene.exposure
    return display.matrix @ adaptation(scene.white, white, display.white)


def encoded(
    scene: Scene,
    xyz: NDArray[Any],
    coverage: NDArray[np.float32],
    bits: int = 8,
) -> tuple[NDArray[Any], DisplayCounts]:
    """Return what the display shows of a picture, on the scene's background.

    Parameters
    ----------
    scene : Scene
        Whose display, adaptation and background.
    xyz : (height, width, 3) ndarray
        Light of the mesh.
    coverage : (height, width) ndarray
        The share of each pixel that shows the mesh.
    bits : {8, 16}
        Of a channel.

    Returns
    -------
    levels : (height, width, 3) ndarray of uint8 or uint16
        Encoded colours.
    counts : DisplayCounts
        Of the pixels that show the mesh.
    """
    display, matrix = scene.display, display_matrix(scene)
    behind = display.decode(np.array(scene.background) / 255)
    levels = np.zeros(xyz.shape, dtype=np.uint8 if bits == 8 else np.uint16)
    counts = DisplayCounts(0, 0, 0)
    rows = max(1, _PIXELS // xyz.shape[1])
    for top in range(0, len(xyz), rows):
        part = slice(top, top + rows)
        linear = xyz[part] @ matrix.T
        linear += (1.0 - coverage[part])[..., None] * behind
        encode = display.encode8 if bits == 8 else display.encode16
        levels[part], told = encode(linear, coverage[part] > 0)
        counts += told
    return levels, counts
