"""Adaptation of white: what a colour looks like to eyes used to another light."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, one_of
from skinviz.errors import ArgumentError

Array = NDArray[np.float64]

ADAPTATIONS = ("none", "cat16")
"""Colours as a meter sees them, or as eyes fully adapted to the light do."""

CAT16 = np.array(
    [
        [0.401288, 0.650173, -0.051461],
        [-0.250268, 1.204414, 0.045854],
        [-0.002079, 0.048952, 0.953127],
    ]
)
"""XYZ to the responses of CAT16; Li et al., Color Res. Appl. 42:703 (2017)."""

BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
"""XYZ to the responses of the linear Bradford transform; ICC.1:2022, annex E."""

_LEAST = 0.01  # X or Z over Y, below which a light has no white
_WEAKEST = 1e-3  # response of one kind of cone over the strongest


def cat16_matrix(white: ArrayLike, target: ArrayLike) -> Array:
    """Return the matrix that takes XYZ from one white to another, fully adapted.

    Parameters
    ----------
    white, target : (3,) array_like
        XYZ of the perfect diffuser in the scene and of the display's white, each on
        its own scale: ``matrix @ white`` is ``target``.

    Returns
    -------
    matrix : (3, 3) ndarray of float64
        ``xyz @ matrix.T`` are the adapted colours.

    Raises
    ------
    ArgumentError
        If a white is not finite, or so far from white that one kind of cone hardly
        sees it: X or Z below 0.01 Y, or a response below 0.001 of the strongest.

    References
    ----------
    .. [1] C. Li et al., Color Res. Appl. 42:703 (2017), one-step von Kries, D = 1.
    """
    whites = []
    for given, name in ((white, "white"), (target, "target")):
        xyz = as_numbers(given, name)
        if xyz.shape != (3,) or not np.isfinite(xyz).all():
            raise ArgumentError(f"{name} must be one XYZ (3,), finite; got {given!r}")
        _require_white(xyz, name)
        whites.append(xyz)
    return von_kries(whites[0], whites[1], CAT16)


def adaptation(name: str, white: ArrayLike, target: ArrayLike) -> Array:
    """Return the matrix (3, 3) of an adaptation by its name.

    Parameters
    ----------
    name : {"none", "cat16"}
        "none" leaves colours as they are; a hand under illuminant A looks orange.
    white, target : (3,) array_like
        As for :func:`cat16_matrix`; "none" does not look at them.

    Raises
    ------
    ArgumentError
        If the name is another, or :func:`cat16_matrix` refuses a white.
    """
    if one_of(name, ADAPTATIONS, "adaptation") == "none":
        return np.eye(3)
    return cat16_matrix(white, target)


def von_kries(white: Array, target: Array, responses: Array) -> Array:
    """Return the matrix (3, 3) that scales each response from one white to another."""
    # Each by its largest first, so that whites of 1e-300 or 1e300 have responses.
    from_, to = white / np.abs(white).max(), target / np.abs(target).max()
    gains = (responses @ to) / (responses @ from_)
    gains = gains * (np.abs(target).max() / np.abs(white).max())
    return np.asarray(np.linalg.solve(responses, gains[:, None] * responses))


def _require_white(xyz: Array, name: str) -> None:
    """Refuse a light to which no eye can adapt."""
    scaled = xyz / max(float(np.abs(xyz).max()), float(np.finfo(np.float64).tiny))
    cones = CAT16 @ scaled
    if min(scaled[0], scaled[2]) < _LEAST * scaled[1] or scaled[1] <= 0:
        why = "X and Z must be at least 0.01 Y, and Y above 0"
    elif cones.min() < _WEAKEST * cones.max():
        why = "one kind of cone hardly sees it"
    else:
        return
    raise ArgumentError(
        f"{name} {xyz.tolist()} is so far from white that eyes cannot adapt to it "
        f"({why}); use adaptation 'none'"
    )
