"""The bounded minimum by SciPy from several starts, the model in plain floats."""

import numpy as np
from scipy.optimize import least_squares

from oracles import two_layer

STARTS = ((0.03, 1e-3, 3e-3), (0.1, 0.01, 0.003), (0.4, 0.03, 0.03))
SCALE = (0.1, 0.01, 0.01)  # sizes of skin's weights, for the trust region


def smallest_sse(spectrum, table, D, interface):
    """Return the least sum of squares that any start reaches."""

    def residual(weights):
        return two_layer.plain(weights, table, D, interface) - spectrum

    found = [
        least_squares(
            residual,
            start,
            jac="2-point",
            bounds=(0, np.inf),
            method="dogbox",
            x_scale=SCALE,
            ftol=1e-14,
            xtol=1e-12,
            gtol=1e-14,
        )
        for start in STARTS
    ]
    return min(2 * result.cost for result in found)
