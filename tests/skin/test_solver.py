"""The bounded solver on problems whose minimum is known by other means."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import lsq_linear
from tolerances import SAME_OPTIMUM

from skinviz.skin.solver import solve

N, P = 12, 3


def linear(matrices):
    """Return ``predict`` of y = A x for problems told apart by their first value.

    The solver passes only some problems at a time; the others' matrices must not
    be used, so each carries its number as a fourth, fixed parameter.
    """

    def predict(values):
        A = matrices[values[:, P].astype(int)]
        jacobian = np.concatenate([A, np.zeros((*A.shape[:2], 1))], axis=2)
        return np.einsum("mnp,mp->mn", A, values[:, :P]), jacobian

    return predict


def linear_problems(m, seed):
    """Return matrices (m, n, p) and targets whose best x often is at a bound."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(m, N, P)) + 0.5
    truth = rng.normal(0.3, 0.6, size=(m, P))
    return A, np.einsum("mnp,mp->mn", A, truth) + rng.normal(0, 0.1, size=(m, N))


def solve_linear(A, target, weights, low=0.0, high=1.0):
    """Return the solution's values (m, p) and held (m, p)."""
    m = len(A)
    start = np.column_stack([np.full((m, P), 0.5), np.arange(m)])
    bounds = np.array([[low] * P + [-1.0], [high] * P + [m + 1.0]])
    found = solve(linear(A), target, weights, start, bounds)
    assert found.converged.all()
    return found.values[:, :P], found.held[:, :P]


def test_linear_problems_reach_the_bounded_optimum():
    A, target = linear_problems(150, seed=1)
    weights = np.random.default_rng(2).uniform(0.1, 3, size=target.shape)
    values, held = solve_linear(A, target, weights)
    for a, y, w, x in zip(A, target, weights, values, strict=True):
        root = np.sqrt(w)[:, None]
        best = lsq_linear(root * a, root[:, 0] * y, (0, 1), method="bvls")
        cost = (w * (a @ x - y) ** 2).sum() / 2
        assert cost <= best.cost * (1 + SAME_OPTIMUM)
        assert_allclose(x, best.x, rtol=0, atol=1e-6)
    assert held.any(axis=1).any()
    assert (~held).all(axis=1).any()


def test_held_parameters_lie_on_a_bound_that_pushes_back():
    A, target = linear_problems(150, seed=3)
    values, held = solve_linear(A, target, np.ones_like(target))
    residual = np.einsum("mnp,mp->mn", A, values) - target
    gradient = np.einsum("mnp,mn->mp", A, residual)
    assert np.isin(values[held], (0, 1)).all()
    assert (gradient[held & (values == 0)] >= 0).all()
    assert (gradient[held & (values == 1)] <= 0).all()
    free = np.abs(gradient[~held])
    assert free.max() < 1e-5 * np.abs(target).max() * N


def test_a_problem_does_not_depend_on_its_neighbours():
    A, target = linear_problems(40, seed=4)
    target[3] *= 1e6  # one that no x fits
    together, _ = solve_linear(A, target, np.ones_like(target))
    alone = [
        solve_linear(a[None], y[None], np.ones((1, N)))[0][0]
        for a, y in zip(A, target, strict=True)
    ]
    assert_allclose(together, alone, rtol=1e-9, atol=1e-12)


def test_bands_without_weight_are_not_seen():
    A, target = linear_problems(20, seed=5)
    weights = np.ones_like(target)
    weights[:, 4] = 0
    spoiled = target.copy()
    spoiled[:, 4] = 1e9
    clean, _ = solve_linear(A, target, weights)
    blind, _ = solve_linear(A, spoiled, weights)
    assert_array_equal(clean, blind)


def rosenbrock(values):
    """Return Rosenbrock's residuals 10 (y − x²), 1 − x and their derivatives."""
    x, y = values.T
    zero = np.zeros_like(x)
    rows = [[-20 * x, zero + 10], [zero - 1, zero]]
    return np.stack([10 * (y - x * x), 1 - x], axis=-1), np.moveaxis(
        np.array(rows), -1, 0
    )


def test_a_curved_valley_is_followed_to_its_end():
    start = np.array([[-1.2, 1.0], [2.0, -1.0], [0.0, 0.0]])
    bounds = np.array([[-5.0, -5.0], [5.0, 5.0]])
    zero = np.zeros((3, 2))
    found = solve(rosenbrock, zero, np.ones((3, 2)), start, bounds)
    assert found.converged.all()
    assert_allclose(found.values, 1, rtol=1e-6)


def test_a_curved_valley_is_left_where_the_bound_cuts_it():
    # With x ≤ ½ the best is x = ½, y = x².
    found = solve(
        rosenbrock,
        np.zeros((1, 2)),
        np.ones((1, 2)),
        np.array([[-1.2, 1.0]]),
        np.array([[-5.0, -5.0], [0.5, 5.0]]),
    )
    assert_array_equal(found.held, [[True, False]])
    assert_allclose(found.values, [[0.5, 0.25]], rtol=1e-6)
