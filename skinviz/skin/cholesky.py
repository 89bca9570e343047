"""Cholesky's method for the few parameters of one fit, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz._compile import inlined


@inlined
def factorise(L: Any, k: int, least: float) -> bool:
    """Replace the leading k × k lower triangle of a matrix by its Cholesky factor.

    The diagonal is left inverted. False, and half done, if a pivot is not above
    ``least``.
    """
    for a in range(k):
        for b in range(a):
            for c in range(b):
                L[a, b] -= L[a, c] * L[b, c]
            L[a, b] *= L[b, b]
            L[a, a] -= L[a, b] * L[a, b]
        if not L[a, a] > least:  # NaN too
            return False
        L[a, a] = 1 / np.sqrt(L[a, a])
    return True


@inlined
def substitute(L: Any, k: int, y: Any) -> None:
    """Replace a right side (k,) by the solution, the matrix factorised."""
    for a in range(k):
        for c in range(a):
            y[a] -= L[a, c] * y[c]
        y[a] *= L[a, a]
    for a in range(k - 1, -1, -1):
        for c in range(a + 1, k):
            y[a] -= L[c, a] * y[c]
        y[a] *= L[a, a]
