"""The package's compiled layers and stacks over arrays, for comparison with oracles."""

import numba
import numpy as np

from skinviz._vector_math import decay
from skinviz.skin import kernels


@numba.njit
def _layers(K, S, D, fluxes, slopes):
    for i in range(K.size):
        kappa = kernels.root(K[i], S[i])
        y = kernels.depth(kappa, K[i], S[i], D[i])
        E, m = decay(y)
        R, T, U, A, Q = kernels.layer(K[i], S[i], kappa, E, m)
        fluxes[0, i], fluxes[1, i] = R / Q, T / Q
        fluxes[2, i], fluxes[3, i] = U / Q, A / Q
        by_R, by_T = kernels.absorption_slopes(K[i], S[i], kappa, y, E, m)
        slopes[0, i], slopes[1, i] = by_R / Q / Q / kappa, by_T / Q / Q / kappa


def layers(K, S, D):
    """Return R, T, 1 − R, 1 − R − T (4, m), and the slopes of R and T by K (2, m)."""
    K, S, D = (np.array(x, dtype=float) for x in np.broadcast_arrays(K, S, D))
    fluxes, slopes = np.zeros((4, K.size)), np.zeros((2, K.size))
    _layers(K.ravel(), S.ravel(), D.ravel(), fluxes, slopes)
    return fluxes, slopes


@numba.njit
def _stacks(K, S, D, backing, body, slopes):
    for i in range(body.size):
        prepared = np.zeros((2, 4))
        for k in range(2):
            kappa = kernels.root(K[k, i], S[k, i])
            y = kernels.depth(kappa, K[k, i], S[k, i], D[k, i])
            prepared[k, 0], prepared[k, 1] = kappa, y
            prepared[k, 2], prepared[k, 3] = decay(y)
        top = kernels.layer(
            K[0, i], S[0, i], prepared[0, 0], prepared[0, 2], prepared[0, 3]
        )
        bottom = kernels.layer(
            K[1, i], S[1, i], prepared[1, 0], prepared[1, 2], prepared[1, 3]
        )
        body[i], first, second = kernels.stack(top, bottom, backing)
        carries = (first, second)
        for k in range(2):
            kappa, y, E, m = prepared[k]
            at = (K[k, i], S[k, i], kappa, y, E, m, carries[k])
            slopes[0, k, i] = kernels.by_absorption(*at)
            slopes[1, k, i] = kernels.by_scattering(*at)
            slopes[2, k, i] = kernels.by_thickness(
                K[k, i], S[k, i], kappa, E, carries[k]
            )


def stacks(K, S, D, backing):
    """Return R_b (m,) of K, S, D (2, m), top then bottom, and its slopes (3, 2, m).

    The slopes are by K, S and D, of the top and of the bottom layer.
    """
    K, S, D = (np.ascontiguousarray(np.array(x, dtype=float)) for x in (K, S, D))
    body, slopes = np.zeros(K.shape[1]), np.zeros((3, 2, K.shape[1]))
    _stacks(K, S, D, float(backing), body, slopes)
    return body, slopes


def measured_and_jacobian(model, values, wavelengths):
    """Return a model's measured (m, n) and its derivatives (m, n, p)."""
    table, constants = model.arrays(wavelengths, model.interface)
    values = np.array(values, dtype=float)
    curves, slopes = model.curves_and_slopes(values, table, constants)
    n = len(wavelengths)
    return curves[:, :n], np.moveaxis(slopes, 1, 2)[:, :n]
