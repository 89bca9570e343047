"""The steps of a bounded least-squares descent, for one small problem, compiled.

What belongs here is algebra on a few parameters: it knows neither models nor spectra
in bulk. With residuals r, weights W and the Jacobian J, the cost is rᵀWr plus the
priors, the gradient is half of the cost's, and the matrix is Gauss and Newton's.

References
----------
.. [1] J. E. Dennis, D. M. Gay and R. E. Welsch, ACM Trans. Math. Softw. 7:348 (1981).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinviz._compile import inlined, summing
from skinviz.skin.cholesky import factorise, substitute

Array = NDArray[np.float64]

_LEVEL = 1e-6  # cosine of the residuals and a parameter's effect
_SHOWN = 1e-8  # cosine between a step and the gradient's change


class Room(NamedTuple):
    """Memory for one step of p parameters."""

    curvature: Array  # (p, p)
    factor: Array  # (p, p)
    right: Array  # (p,)
    known: Array  # (p,)
    free: NDArray[np.int64]  # (p,)
    fixed: NDArray[np.bool_]  # (p,)


@inlined
def new_room(p: int) -> Any:
    """Return memory for steps of p parameters."""
    return Room(
        np.zeros((p, p)),
        np.zeros((p, p)),
        np.zeros(p),
        np.zeros(p),
        np.zeros(p, np.int64),
        np.zeros(p, np.bool_),
    )


@summing
def differentiate(
    x: Any,
    measured: Any,
    jacobian: Any,
    target: Any,
    weight: Any,
    centre: Any,
    stiffness: Any,
    residual: Any,
    gradient: Any,
    normal: Any,
) -> float:
    """Fill in the last three: JᵀWr and JᵀWJ with the priors; return the cost."""
    cost = 0.0
    for j in range(target.size):
        off = measured[j] - target[j]
        residual[j] = weight[j] * off
        cost += residual[j] * off
    for a in range(x.size):
        total = 0.0
        for j in range(target.size):
            total += jacobian[a, j] * residual[j]
        off = x[a] - centre[a]
        gradient[a] = total + stiffness[a] * off
        cost += stiffness[a] * off * off
        for b in range(a + 1):
            total = 0.0
            for j in range(target.size):
                total += jacobian[a, j] * (weight[j] * jacobian[b, j])
            normal[a, b] = total
            normal[b, a] = total
        normal[a, a] += stiffness[a]
    return cost


@inlined
def hold(x: Any, gradient: Any, low: Any, high: Any, held: Any) -> None:
    """Mark the parameters at a bound that descent would push through it."""
    for a in range(x.size):
        down = x[a] <= low[a] and gradient[a] >= 0
        held[a] = down or (x[a] >= high[a] and gradient[a] <= 0)


@inlined
def is_level(gradient: Any, normal: Any, held: Any, cost: float) -> bool:
    """Return whether the residuals are orthogonal to all that free parameters do."""
    for a in range(held.size):
        most = _LEVEL**2 * normal[a, a] * cost
        if not held[a] and not gradient[a] * gradient[a] <= most:
            return False
    return True


@inlined
def take(x: Any, move: Any, low: Any, high: Any, new: Any) -> bool:
    """Write where a step leads, to the bounds exactly; say whether that is new."""
    moved = False
    for a in range(x.size):
        new[a] = min(max(x[a] + move[a], low[a]), high[a])
        move[a] = new[a] - x[a]
        moved = moved or move[a] != 0
    return moved


@inlined
def step(
    x: Any,
    gradient: Any,
    normal: Any,
    bend: Any,
    damping: float,
    low: Any,
    high: Any,
    held: Any,
    room: Any,
    move: Any,
) -> float:
    """Write the damped step within the bounds; return the cost it promises to gain.

    A parameter that would cross a bound stops on it, the first to cross first, and
    the others' steps are found anew. What is promised is by the quadratic model,
    without the damping.
    """
    _add(normal, bend, 1.0, room.curvature)
    for a in range(x.size):
        room.fixed[a] = held[a]
        move[a] = 0.0
    for _ in range(x.size):
        if not _solve_free(gradient, normal, damping, room, move):
            _add(normal, bend, 0.0, room.curvature)  # not convex with what was learnt
            _solve_free(gradient, normal, damping, room, move)
        first = _first_crossing(x, move, low, high, room.fixed)
        if first < 0:
            break
        edge = high[first] if move[first] > 0 else low[first]
        move[first] = edge - x[first]
        room.fixed[first] = True
    return _promise(gradient, room.curvature, move)


@inlined
def _add(normal: Any, bend: Any, share: float, curvature: Any) -> None:
    """Write the matrix and a share of what was learnt that it leaves out."""
    for a in range(curvature.shape[0]):
        for b in range(curvature.shape[0]):
            curvature[a, b] = normal[a, b] + share * bend[a, b]


@inlined
def _promise(gradient: Any, curvature: Any, move: Any) -> float:
    """Return the cost that a step gains by the quadratic model."""
    gain = 0.0
    for a in range(move.size):
        gain -= 2 * gradient[a] * move[a]
        for b in range(move.size):
            gain -= move[a] * curvature[a, b] * move[b]
    return gain


@inlined
def _first_crossing(x: Any, move: Any, low: Any, high: Any, fixed: Any) -> int:
    """Return the parameter that a step takes over its bound soonest, −1 if none."""
    nearest, share = -1, 1.0
    for a in range(x.size):
        space = (high[a] if move[a] > 0 else low[a]) - x[a]
        if not fixed[a] and abs(move[a]) > abs(space) and space / move[a] < share:
            nearest, share = a, space / move[a]
    return nearest


@inlined
def _solve_free(
    gradient: Any, normal: Any, damping: float, room: Any, move: Any
) -> bool:
    """Write the step of parameters that are not fixed; say whether it is downhill.

    The damping is a share of the matrix's diagonal, so that the step does not depend
    on the parameters' units. Fixed ones keep their own steps.
    """
    p, k = move.size, 0
    for a in range(p):
        if not room.fixed[a]:
            move[a] = 0.0
            room.free[k] = a
            k += 1
    for i in range(k):
        a = room.free[i]
        room.right[i] = -gradient[a]
        for b in range(p):
            room.right[i] -= room.curvature[a, b] * move[b]
        for j in range(i + 1):
            room.factor[i, j] = room.curvature[a, room.free[j]]
        own = normal[a, a] if normal[a, a] > 0 else 1.0  # 1: any step, as good as none
        room.factor[i, i] += damping * own
    if not factorise(room.factor, k, 0.0):
        return False
    substitute(room.factor, k, room.right)
    for i in range(k):
        move[room.free[i]] = room.right[i]
    return True


@summing
def learn_bend(
    old_jacobian: Any,
    jacobian: Any,
    residual: Any,
    old_gradient: Any,
    gradient: Any,
    move: Any,
    room: Any,
    bend: Any,
) -> None:
    """Update the secant estimate of Σ r ∇²r after a step, sized as in [1]_."""
    p = move.size
    change, known = room.right, room.known
    along, own, taught, pull2, step2 = 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(p):
        total = 0.0
        for j in range(residual.size):
            total += (jacobian[a, j] - old_jacobian[a, j]) * residual[j]
        change[a] = total
        known[a] = 0.0
        for b in range(p):
            known[a] += bend[a, b] * move[b]
        pull = gradient[a] - old_gradient[a]
        along += pull * move[a]
        own += move[a] * known[a]
        taught += move[a] * change[a]
        pull2 += pull * pull
        step2 += move[a] * move[a]
    # A step too short to show how the gradient turns teaches nothing.
    if not along > _SHOWN * np.sqrt(pull2 * step2):
        return
    size = min(1.0, abs(taught) / abs(own)) if own != 0 else 1.0
    excess = taught - size * own
    for a in range(p):
        pull_a = (gradient[a] - old_gradient[a]) / along
        for b in range(a + 1):
            pull_b = (gradient[b] - old_gradient[b]) / along
            value = size * bend[a, b] - excess * pull_a * pull_b
            value += (change[a] - size * known[a]) * pull_b
            value += (change[b] - size * known[b]) * pull_a
            bend[a, b] = value
            bend[b, a] = value
