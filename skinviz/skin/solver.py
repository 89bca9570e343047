"""Batched nonlinear least squares within bounds: one solver for every model.

Levenberg–Marquardt on many small problems at once. A parameter at a bound whose
gradient pushes outwards is held there (active set); the rest move, and a step
that would cross a bound stops on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Predict = Callable[[Array], tuple[Array, Array]]

_MAX_ITERATIONS = 200
_STEP_TOLERANCE = 1e-8
_GRADIENT_TOLERANCE = 1e-5
_EXACT = 1e-7  # RMS residual below which the data are met; measurements have 1e-4
_SHOWN = 1e-8  # cosine between a step and the gradient's change
_DAMPING = (1e-14, 1e14)


@dataclass(frozen=True)
class Solution:
    """Where the solver stopped, for each of m problems.

    Attributes
    ----------
    values : (m, p) ndarray
        The parameters.
    predicted : (m, n) ndarray
        The model there.
    jacobian : (m, n, p) ndarray
        Its derivatives there.
    held : (m, p) ndarray of bool
        Parameters held at a bound by the active set.
    converged : (m,) ndarray of bool
        Whether the residuals are orthogonal to every free parameter's effect.
    """

    values: Array
    predicted: Array
    jacobian: Array
    held: NDArray[np.bool_]
    converged: NDArray[np.bool_]


def solve(
    predict: Predict, target: Array, weights: Array, start: Array, bounds: Array
) -> Solution:
    """Minimise Σ weights (predicted − target)² of each problem within bounds.

    Parameters
    ----------
    predict : callable
        From values (k, p) to predictions (k, n) and derivatives (k, n, p).
    target, weights : (m, n) ndarray
        Data and their weights, 0 for a band to leave out.
    start : (m, p) ndarray
        Where to begin, within the bounds.
    bounds : (2, p) ndarray
        Lowest and highest values.

    Returns
    -------
    solution : Solution
        Values at the minimum, or the best that was found.
    """
    low, high = bounds
    values = start.copy()
    predicted, jacobian = predict(values)
    m, p = values.shape
    # The minimum does not depend on the weights' scale; the arithmetic would.
    largest = weights.max(axis=1, keepdims=True)
    weights = weights / np.where(largest > 0, largest, 1.0)
    bend = np.zeros((m, p, p))
    cost = _cost(predicted, target, weights)
    damping = np.full(m, 1e-3)
    growth = np.full(m, 2.0)
    working = np.arange(m)
    for _ in range(_MAX_ITERATIONS):
        if working.size == 0:
            break
        x, weight, aim = values[working], weights[working], target[working]
        gradient, normal = _normal_equations(
            predicted[working], jacobian[working], aim, weight
        )
        held = _held(x, gradient, low, high)
        curvature = _curvature(normal, bend[working])
        step = _step(gradient, curvature, held, damping[working])
        trial = np.clip(x + step, low, high)
        step = trial - x
        new, new_jacobian = predict(trial)
        new_cost = _cost(new, aim, weight)
        # Where the model falls vertically no step can start: it may end there only
        # if the data are met.
        steep = ~np.isfinite(new_jacobian)
        stuck = steep.any(axis=(1, 2)) & ~_is_met(new_cost, weight)
        new_cost = np.where(stuck, np.inf, new_cost)
        new_jacobian = np.where(steep, 0.0, new_jacobian)
        promised = -_dot(gradient, step) - _quadratic(curvature, step) / 2
        good = new_cost <= cost[working]
        gain = np.where(good, cost[working] - new_cost, 0.0) / 2
        trust = np.where(promised > gain, gain / np.where(promised > 0, promised, 1), 1)

        accepted = working[good]
        change = np.einsum(
            "mnp,mn->mp",
            new_jacobian[good] - jacobian[accepted],
            weight[good] * (new[good] - aim[good]),
        )
        new_gradient, _ = _normal_equations(
            new[good], new_jacobian[good], aim[good], weight[good]
        )
        bend[accepted] = _updated_bend(
            bend[accepted], step[good], change, new_gradient - gradient[good]
        )
        values[accepted], cost[accepted] = trial[good], new_cost[good]
        predicted[accepted], jacobian[accepted] = new[good], new_jacobian[good]

        # Nielsen's rule: trust a step in proportion to how well it kept its promise.
        shrink = np.maximum(0.1, 1 - (2 * np.clip(trust, 0, 1) - 1) ** 3)
        damping[working] = np.clip(
            damping[working] * np.where(good, shrink, growth[working]), *_DAMPING
        )
        growth[working] = np.where(good, 2.0, 2 * growth[working])
        settled = np.abs(step) <= _STEP_TOLERANCE * (np.abs(x) + _STEP_TOLERANCE)
        working = working[~settled.all(axis=1)]
    gradient, normal = _normal_equations(predicted, jacobian, target, weights)
    held = _held(values, gradient, low, high)
    # The squared cosine between the residuals and each column of the Jacobian; it
    # says nothing where the data are met exactly.
    scale = np.einsum("mpp->mp", normal) * cost[:, None]
    level = held | (gradient**2 <= _GRADIENT_TOLERANCE**2 * scale)
    done = level.all(axis=1) | _is_met(cost, weights)
    return Solution(values, predicted, jacobian, held, done)


def _cost(predicted: Array, target: Array, weights: Array) -> Array:
    """Return each problem's weighted sum of squares (m,)."""
    return np.asarray((weights * (predicted - target) ** 2).sum(axis=-1))


def _is_met(cost: Array, weights: Array) -> NDArray[np.bool_]:
    """Return whether data (m,) are met as exactly as any measurement could tell."""
    return np.asarray(cost <= _EXACT**2 * weights.sum(axis=1))


def _normal_equations(
    predicted: Array, jacobian: Array, target: Array, weights: Array
) -> tuple[Array, Array]:
    """Return the gradient (m, p) and the Gauss–Newton matrix (m, p, p)."""
    weighted = weights[..., None] * jacobian
    gradient = np.einsum("mnp,mn->mp", weighted, predicted - target)
    return gradient, np.einsum("mnp,mnq->mpq", weighted, jacobian)


def _curvature(normal: Array, bend: Array) -> Array:
    """Return the Hessian (m, p, p) with the residuals' bend where that is convex."""
    full = normal + bend
    scale = np.sqrt(np.einsum("mpp->mp", normal))
    scale = np.where(scale > 0, scale, 1.0)
    scaled = full / (scale[:, :, None] * scale[:, None, :])
    convex = np.linalg.eigvalsh(scaled)[:, 0] > 0
    return np.where(convex[:, None, None], full, normal)


def _updated_bend(bend: Array, step: Array, change: Array, pull: Array) -> Array:
    """Return the secant estimate of Σ r ∇²r (m, p, p) after a step (m, p).

    Dennis, Gay & Welsch's update, sized as they do [1]_: where residuals stay
    large, Gauss–Newton alone overshoots and swings about the minimum.

    References
    ----------
    .. [1] J. E. Dennis, D. M. Gay and R. E. Welsch, ACM Trans. Math. Softw. 7:348
       (1981).
    """
    along = _dot(pull, step)
    known = np.einsum("mpq,mq->mp", bend, step)
    own = np.abs(_dot(step, known))
    size = np.where(
        own > 0,
        np.minimum(1, np.abs(_dot(step, change)) / np.where(own > 0, own, 1.0)),
        1.0,
    )
    bend, known = bend * size[:, None, None], known * size[:, None]
    # A step too short to show how the gradient turns teaches nothing.
    shown = along > _SHOWN * np.sqrt(_dot(pull, pull) * _dot(step, step))
    # Unit vectors along the pull keep powers of small steps from overflowing.
    length = np.sqrt(_dot(pull, pull))
    unit = pull / np.where(length > 0, length, 1.0)[:, None]
    reach = np.where(shown, _dot(unit, step), 1.0)
    miss = (change - known) / reach[:, None]
    cross = miss[:, :, None] * unit[:, None, :]
    twice = (_dot(step, miss) / reach)[:, None, None]
    update = cross + cross.transpose(0, 2, 1) - twice * unit[:, :, None] * unit[:, None]
    return np.asarray(np.where(shown[:, None, None], bend + update, bend))


def _dot(a: Array, b: Array) -> Array:
    """Return the scalar product of rows (m,)."""
    return np.asarray(np.einsum("mp,mp->m", a, b))


def _quadratic(matrix: Array, x: Array) -> Array:
    """Return xᵀ A x of each row (m,)."""
    return np.asarray(np.einsum("mp,mpq,mq->m", x, matrix, x))


def _held(x: Array, gradient: Array, low: Array, high: Array) -> NDArray[np.bool_]:
    """Return the parameters at a bound that descent would push through it."""
    return ((x <= low) & (gradient >= 0)) | ((x >= high) & (gradient <= 0))


def _step(
    gradient: Array, normal: Array, held: NDArray[np.bool_], damping: Array
) -> Array:
    """Return the damped step of the parameters that are free, 0 for the held."""
    p = gradient.shape[1]
    free = ~held
    both = free[:, :, None] & free[:, None, :]
    diagonal = np.einsum("mpp->mp", normal)
    # Marquardt's scaling makes the step independent of the parameters' units.
    scale = np.sqrt(np.where(free & (diagonal > 0), diagonal, 1.0))
    scaled = np.where(both, normal / (scale[:, :, None] * scale[:, None, :]), 0.0)
    scaled += np.eye(p) * np.where(free, damping[:, None], 1.0)[:, None, :]
    right = np.where(free, -gradient / scale, 0.0)
    return np.asarray(np.linalg.solve(scaled, right[..., None])[..., 0] / scale)
