"""What the solver is given and what it gives back: arrays under names."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

Array = NDArray[np.float64]

CONVERGED, AT_BOUND, NOT_CONVERGED, REFUSED = range(4)
"""Codes of a spectrum's status."""

HIGHEST = 1.5
"""Above this it is no reflectance, however glossy."""


class Problem(NamedTuple):
    """What all spectra of a batch share.

    Attributes
    ----------
    table : (k, N) ndarray
        The model's coefficients, padded to N bands.
    constants : (c,) ndarray
        Its other numbers.
    low, high : (p,) ndarray
        Bounds.
    centre, stiffness : (p,) ndarray
        Normal priors: mean, and 1/variance (0 for none).
    starts : (s, p) ndarray
        Where a descent may begin.
    curves, slopes : (s, N), (s, p, N) ndarray
        The model and its Jacobian there.
    sampled : (k,) ndarray of int64
        A few bands by which the starts are told apart.
    sketch : (k, s) ndarray of float32
        The curves there.
    observer : (3, N) ndarray
        Weights from a spectrum to XYZ.
    """

    table: Array
    constants: Array
    low: Array
    high: Array
    centre: Array
    stiffness: Array
    starts: Array
    curves: Array
    slopes: Array
    sampled: NDArray[np.int64]
    sketch: NDArray[np.float32]
    observer: Array


class Solutions(NamedTuple):
    """Where m descents ended; written by :func:`solve`.

    Attributes
    ----------
    values : (m, p) ndarray
        The parameters.
    held : (m, p) ndarray of bool
        Those held at a bound.
    information, pull : (m, p, p), (m, p) ndarray
        JᵀWJ and JᵀW(residual) of the data, weights relative to the largest.
    unit : (m,) ndarray
        σ² of a band of weight 1; NaN where it is not known.
    cost, sse : (m,) ndarray
        Weighted and plain sum of squared residuals.
    n_used : (m,) ndarray of int64
        Bands used.
    status : (m,) ndarray of uint8
        One of the codes.
    colours : (m, 2, 3) ndarray
        XYZ of the data and of the fit.
    """

    values: Array
    held: NDArray[np.bool_]
    information: Array
    pull: Array
    unit: Array
    cost: Array
    sse: Array
    n_used: NDArray[np.int64]
    status: NDArray[np.uint8]
    colours: Array


def room(m: int, p: int) -> Solutions:
    """Return memory for the solutions of m problems of p parameters."""
    return Solutions(
        values=np.zeros((m, p)),
        held=np.zeros((m, p), dtype=np.bool_),
        information=np.zeros((m, p, p)),
        pull=np.zeros((m, p)),
        unit=np.ones(m),
        cost=np.zeros(m),
        sse=np.zeros(m),
        n_used=np.zeros(m, dtype=np.int64),
        status=np.zeros(m, dtype=np.uint8),
        colours=np.zeros((m, 2, 3)),
    )


_VECTOR, MATRIX, _CUBE = (types.Array(types.float64, n, "C") for n in (1, 2, 3))
_FLAGS = types.Array(types.boolean, 2, "C")
PROBLEM = types.NamedTuple(
    (
        MATRIX,
        *5 * (_VECTOR,),
        *2 * (MATRIX,),
        _CUBE,
        types.int64[::1],
        types.float32[:, ::1],
        MATRIX,
    ),
    Problem,
)
SOLUTIONS = types.NamedTuple(
    (
        *(MATRIX, _FLAGS, _CUBE, MATRIX, _VECTOR, _VECTOR, _VECTOR),
        *(types.int64[::1], types.uint8[::1], _CUBE),
    ),
    Solutions,
)
