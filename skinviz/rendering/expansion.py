"""From the scalars of points to their light, for vertices and pixels alike."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.rendering import kernels
from skinviz.rendering.stage import Lit

Array = NDArray[np.float64]


def expand_mapped(
    lit: Lit,
    scalars: Array,
    body: Array,
    *,
    rows: NDArray[np.int64],
    samples: int,
    out: NDArray[Any],
) -> None:
    """Write the radiance of points that each have their own pigments.

    Parameters
    ----------
    lit : Lit
        The light.
    scalars : (k, m) ndarray
        Of the lights, then of the fields.
    body : (m, bands) ndarray
        What leaves the skin from inside. [1]
    rows : (m,) ndarray
        The row of ``out`` that each point belongs to, ascending.
    samples : int
        Over how many points a row is the mean.
    out : (n, bands) ndarray
        The radiance.
    """
    spectra, fields = lit.spectra, lit.fields
    n_lights = len(spectra.light)
    require_single(scalars, spectra.products(fields.spectra))
    kernels.expand_mapped(
        *(rows, samples),
        np.concatenate([scalars[:n_lights], scalars[lit.rows :]]),
        np.concatenate([spectra.light, fields.spectra]),
        *(scalars[n_lights : lit.rows], spectra.shine, body, out),
    )


def as_single(matrix: Array) -> NDArray[np.float32]:
    """Return spectra as float32; see :func:`require_single`."""
    require_single(np.ones((len(matrix), 1)), matrix)
    return matrix.astype(np.float32)


def require_single(scalars: Array, matrix: NDArray[Any]) -> None:
    """Refuse scalars (k, m) and spectra (k, n) whose products float32 does not hold."""
    # A bound, not the light itself: that would have to be read once more.
    with np.errstate(over="ignore"):
        peak = scalars.max(axis=1, initial=0.0) @ matrix.max(axis=1, initial=0.0)
    if not peak <= np.finfo(np.float32).max:
        raise ArgumentError(
            f"radiance reaches {peak:.3g}, more than float32 holds; lower the exposure "
            "or the lights' strength"
        )
