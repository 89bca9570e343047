"""Nonlinear least squares within bounds, one small problem a spectrum, compiled.

Levenberg–Marquardt with an active set: a parameter at a bound whose gradient pushes
outwards is held there, and a step that would cross a bound is solved again with that
parameter on it. Where residuals stay large the Gauss–Newton matrix alone overshoots,
so a secant estimate of what it leaves out is carried along [1]_. The solver knows a
model only as a function that fills in a spectrum and its Jacobian.

References
----------
.. [1] J. E. Dennis, D. M. Gay and R. E. Welsch, ACM Trans. Math. Softw. 7:348 (1981).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from skinviz._compile import comparing, compiled, inlined, summing
from skinviz.skin.descent import (
    Room,
    differentiate,
    hold,
    is_level,
    learn_bend,
    new_room,
    step,
    take,
)
from skinviz.skin.kernels import EVALUATE, SCRATCH
from skinviz.skin.problem import (
    AT_BOUND,
    CONVERGED,
    HIGHEST,
    MATRIX,
    NOT_CONVERGED,
    PROBLEM,
    REFUSED,
    SOLUTIONS,
)

Array = NDArray[np.float64]

_MOST_STEPS = 100
_MOST_STARTS = 4
_SETTLED = 1e-7  # share of the cost that the model still promises to gain
_EXACT = 1e-13  # RMS residual below which the data are met
_MET = 1e-7  # the same for a start that can go no further; measurements have 1e-4
_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-4, 1e-14, 1e12
_TRUSTED = 1e-2  # damping up to which a small promise means that little is to be had


class _Work(NamedTuple):
    """Memory of one thread; two states, the present one and one on trial."""

    target: Array  # (N,)
    weight: Array  # (N,)
    x: Array  # (2, p)
    measured: Array  # (2, N)
    jacobian: Array  # (2, p, N)
    residual: Array  # (2, N), times the weights
    gradient: Array  # (2, p)
    normal: Array  # (2, p, p), the Gauss–Newton matrix
    bend: Array  # (p, p), what it leaves out
    move: Array  # (p,)
    held: NDArray[np.bool_]  # (p,)
    room: Room
    stiffness: Array  # (p,)
    ranking: NDArray[np.float32]  # (s,)
    scratch: Array  # (SCRATCH, N)


@inlined
def _new_work(p: int, n: int, n_starts: int) -> Any:
    """Return the memory of one thread."""
    return _Work(
        np.zeros(n),
        np.zeros(n),
        np.zeros((2, p)),
        np.zeros((2, n)),
        np.zeros((2, p, n)),
        np.zeros((2, n)),
        np.zeros((2, p)),
        np.zeros((2, p, p)),
        np.zeros((p, p)),
        np.zeros(p),
        np.zeros(p, np.bool_),
        new_room(p),
        np.zeros(p),
        np.zeros(n_starts, np.float32),
        np.zeros((SCRATCH, n)),
    )


@inlined
def _load(row: Any, sigma: Any, known: bool, target: Any, weight: Any) -> Any:
    """Copy data and weights; return σ² of weight 1 and the bands used, 0 if refused."""
    smallest = np.inf
    n_used = 0
    for j in range(row.size):
        if np.isnan(row[j]):
            continue
        if row[j] < 0 or row[j] > HIGHEST:
            return 1.0, 0
        n_used += 1
        if known and sigma[j] < smallest:
            smallest = sigma[j]
    for j in range(row.size):
        missing = np.isnan(row[j])
        target[j] = 0.0 if missing else row[j]
        weight[j] = 0.0 if missing else 1.0
        if known and not missing:
            weight[j] = (smallest / sigma[j]) ** 2
    return (smallest * smallest if known else 1.0), n_used


@summing
def _rank_starts(problem: Any, target: Any, weight: Any, ranking: Any) -> None:
    """Write how badly each start's curve fits in every few bands, up to a constant."""
    for s in range(ranking.size):
        ranking[s] = 0.0
    for k in range(problem.sampled.size):
        j = problem.sampled[k]
        w, t = np.float32(weight[j]), np.float32(2 * target[j])
        for s in range(ranking.size):
            curve = problem.sketch[k, s]
            ranking[s] += w * curve * (curve - t)


@comparing
def _smallest(values: Any) -> float:
    """Return the least of some values, none of them NaN."""
    least = values[0]
    for s in range(values.size):
        least = values[s] if values[s] < least else least
    return least


@inlined
def _start(problem: Any, work: Any) -> float:
    """Make the best start that is left the first state; return the weights' sum."""
    least, first = _smallest(work.ranking), 0
    while work.ranking[first] != least:
        first += 1
    work.ranking[first] = np.inf
    weights = 0.0
    for j in range(work.target.size):
        work.measured[0, j] = problem.curves[first, j]
        weights += work.weight[j]
    for a in range(work.move.size):
        work.x[0, a] = problem.starts[first, a]
        for b in range(work.move.size):
            work.bend[a, b] = 0.0
        for j in range(work.target.size):
            work.jacobian[0, a, j] = problem.slopes[first, a, j]
    return weights


@inlined
def _descend(evaluate: Any, problem: Any, work: Any) -> Any:
    """Descend from the best start that is left; return state, cost, converged."""
    weights, now = _start(problem, work), 0
    low, high, bend, move = problem.low, problem.high, work.bend, work.move
    cost = _differentiate_state(now, problem, work)
    damping, growth = _FIRST_DAMPING, 2.0
    for _ in range(_MOST_STEPS):
        x, gradient, normal = work.x[now], work.gradient[now], work.normal[now]
        hold(x, gradient, low, high, work.held)
        if cost <= _EXACT**2 * weights or is_level(gradient, normal, work.held, cost):
            return now, cost, True
        promised = step(
            x, gradient, normal, bend, damping, low, high, work.held, work.room, move
        )
        if promised <= _SETTLED * cost and damping <= _TRUSTED:
            return now, cost, True
        trial = 1 - now
        if not take(x, move, low, high, work.x[trial]) or damping > _MOST_DAMPING:
            break
        evaluate(
            work.x[trial],
            problem.table,
            problem.constants,
            work.scratch,
            work.measured[trial],
            work.jacobian[trial],
        )
        new_cost = _differentiate_state(trial, problem, work)
        if not new_cost <= cost:  # NaN too
            damping *= growth
            growth *= 2
            continue
        learn_bend(
            work.jacobian[now],
            work.jacobian[trial],
            work.residual[trial],
            gradient,
            work.gradient[trial],
            move,
            work.room,
            bend,
        )
        trust = (cost - new_cost) / promised if promised > 0 else 1.0
        # Nielsen's rule: trust a step in proportion to how well it kept its word.
        damping *= max(0.1, 1 - (2 * min(trust, 1.0) - 1) ** 3)
        damping, growth = max(damping, _LEAST_DAMPING), 2.0
        now, cost = trial, new_cost
    hold(work.x[now], work.gradient[now], low, high, work.held)
    level = is_level(work.gradient[now], work.normal[now], work.held, cost)
    return now, cost, level or cost <= _MET**2 * weights


@inlined
def _differentiate_state(state: int, problem: Any, work: Any) -> float:
    """Fill in residual, gradient and matrix of a state; return its cost."""
    return differentiate(
        work.x[state],
        work.measured[state],
        work.jacobian[state],
        work.target,
        work.weight,
        problem.centre,
        work.stiffness,
        work.residual[state],
        work.gradient[state],
        work.normal[state],
    )


@summing
def _record(
    i: int, state: int, done: bool, problem: Any, work: Any, found: Any
) -> None:
    """Write one result; the priors' share of matrix and gradient is taken out."""
    p = work.move.size
    bound = False
    for a in range(p):
        off = work.x[state, a] - problem.centre[a]
        found.values[i, a] = work.x[state, a]
        found.held[i, a] = work.held[a]
        found.pull[i, a] = work.gradient[state, a] - work.stiffness[a] * off
        bound = bound or work.held[a]
        for b in range(p):
            found.information[i, a, b] = work.normal[state, a, b]
        found.information[i, a, a] -= work.stiffness[a]
    cost, sse = 0.0, 0.0
    for j in range(work.target.size):
        off = work.measured[state, j] - work.target[j]
        cost += work.weight[j] * off * off
        sse += off * off if work.weight[j] > 0 else 0.0
    found.cost[i], found.sse[i] = cost, sse
    for k in range(3):
        seen, fitted = 0.0, 0.0
        for j in range(work.target.size):
            measured = work.measured[state, j]
            # A band that was not measured counts as the fit has it.
            own = work.target[j] if work.weight[j] > 0 else measured
            seen += problem.observer[k, j] * own
            fitted += problem.observer[k, j] * measured
        found.colours[i, 0, k], found.colours[i, 1, k] = seen, fitted
    found.status[i] = (AT_BOUND if bound else CONVERGED) if done else NOT_CONVERGED


@compiled(types.void(EVALUATE, PROBLEM, MATRIX, MATRIX, types.float64, SOLUTIONS))
def solve(
    evaluate: Any, problem: Any, data: Any, sigma: Any, prior_unit: float, found: Any
) -> None:
    """Fit every row of ``data`` (m, n) and write where it ended into ``found``.

    ``sigma`` is (m, n), (1, n) for all alike, or (0, n) where it is not known;
    ``prior_unit`` is then the σ² of the data that the priors are weighed against.
    NaN bands are left out. Nothing is written to ``data``.
    """
    p, known = problem.low.size, sigma.shape[0] > 0
    work = _new_work(p, problem.table.shape[1], problem.starts.shape[0])
    for i in range(data.shape[0]):
        own = sigma[min(i, sigma.shape[0] - 1)] if known else data[i]
        unit, n_used = _load(data[i], own, known, work.target, work.weight)
        found.n_used[i] = n_used
        if n_used <= p:
            found.status[i] = REFUSED
            continue
        found.unit[i] = unit if known else np.nan
        for a in range(p):
            work.stiffness[a] = problem.stiffness[a] * (unit if known else prior_unit)
        _rank_starts(problem, work.target, work.weight, work.ranking)
        least = np.inf
        for _ in range(min(_MOST_STARTS, problem.starts.shape[0])):
            now, cost, done = _descend(evaluate, problem, work)
            if cost < least or (done and cost <= least * (1 + _SETTLED)):
                least = cost
                _record(i, now, done, problem, work, found)
            if done:
                break
