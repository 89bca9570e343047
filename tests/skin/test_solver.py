"""The bounded solver on problems whose minimum is known by other means."""

import numba
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import lsq_linear
from tolerances import SAME_OPTIMUM

from skinviz.skin.problem import AT_BOUND, CONVERGED, NOT_CONVERGED, Problem, room
from skinviz.skin.solver import solve

N, P = 12, 3
UNKNOWN = np.zeros((0, N))


@numba.njit
def linear(values, table, constants, scratch, measured, jacobian):
    """Fill in y = A x + shift, with Aᵀ in the table."""
    for j in range(measured.size):
        measured[j] = constants[0]
        for a in range(values.size):
            measured[j] += table[a, j] * values[a]
    for a in range(jacobian.shape[0]):
        for j in range(measured.size):
            jacobian[a, j] = table[a, j]


SHIFT = 0.75  # data must look like reflectance
SCALE = 0.02


def problem(evaluate, table, low, high, starts, priors=None):
    """Return the solver's problem, its starts evaluated."""
    starts = np.array(starts, dtype=float)
    p, n = starts.shape[1], table.shape[1]
    curves, slopes = np.zeros((len(starts), n)), np.zeros((*starts.shape, n))
    constants = np.array([SHIFT])
    for x, curve, slope in zip(starts, curves, slopes, strict=True):
        evaluate(x, table, constants, np.zeros((1, 1)), curve, slope)
    centre, stiffness = priors or (np.zeros(p), np.zeros(p))
    return Problem(
        table=table,
        constants=constants,
        low=np.full(p, low) if np.isscalar(low) else np.array(low),
        high=np.full(p, high) if np.isscalar(high) else np.array(high),
        centre=centre,
        stiffness=stiffness,
        starts=starts,
        curves=curves,
        slopes=slopes,
        sampled=np.arange(n),
        sketch=np.array(curves.T, dtype=np.float32, order="C"),
        observer=np.zeros((3, n)),
    )


def linear_problems(m, seed):
    """Return Aᵀ (m, p, n) and targets (m, n) whose best x often is at a bound."""
    rng = np.random.default_rng(seed)
    A = SCALE * (rng.normal(size=(m, P, N)) + 0.5)
    truth = rng.normal(0.3, 0.6, size=(m, P))
    noise = rng.normal(0, 0.1 * SCALE, size=(m, N))
    return A, SHIFT + np.einsum("mpn,mp->mn", A, truth) + noise


def solve_linear(A, target, sigma=UNKNOWN, **options):
    """Return the solutions' values and held (m, p), all converged."""
    values, held = np.zeros((len(A), P)), np.zeros((len(A), P), dtype=bool)
    for i, own in enumerate(A):
        found = room(1, P)
        case = problem(linear, own, 0.0, 1.0, np.full((1, P), 0.5), **options)
        solve(linear, case, target[i : i + 1], sigma[i : i + 1], 1.0, found)
        values[i], held[i] = found.values[0], found.held[0]
        assert found.status[0] == (AT_BOUND if held[i].any() else CONVERGED)
    return values, held


def test_linear_problems_reach_the_bounded_optimum():
    A, target = linear_problems(150, seed=1)
    sigma = np.random.default_rng(2).uniform(0.3, 3, size=target.shape)
    values, held = solve_linear(A, target, sigma)
    for a, y, s, x in zip(A, target, sigma, values, strict=True):
        best = lsq_linear((a / s).T, (y - SHIFT) / s, (0, 1), method="bvls")
        cost = (((x @ a + SHIFT - y) / s) ** 2).sum() / 2
        assert cost <= best.cost * (1 + SAME_OPTIMUM)
        assert_allclose(x, best.x, rtol=0, atol=1e-3)
    assert held.any(axis=1).any()
    assert (~held).all(axis=1).any()


def test_priors_are_measurements_of_the_parameters():
    A, target = linear_problems(40, seed=6)
    centre, stiffness = np.array([0.2, 0.8, 0.5]), np.array([4e-3, 1e-3, 0.0])
    values, _ = solve_linear(A, target, priors=(centre, stiffness))
    for a, y, x in zip(A, target, values, strict=True):
        root = np.diag(np.sqrt(stiffness))
        matrix = np.concatenate([a.T, root])
        right = np.concatenate([y - SHIFT, root @ centre])
        best = lsq_linear(matrix, right, (0, 1), method="bvls")
        assert_allclose(x, best.x, rtol=0, atol=1e-3)


def test_held_parameters_lie_on_a_bound_that_pushes_back():
    A, target = linear_problems(150, seed=3)
    values, held = solve_linear(A, target)
    residual = np.einsum("mpn,mp->mn", A, values) + SHIFT - target
    gradient = np.einsum("mpn,mn->mp", A, residual)
    assert np.isin(values[held], (0, 1)).all()
    assert (gradient[held & (values == 0)] >= 0).all()
    assert (gradient[held & (values == 1)] <= 0).all()
    sizes = np.sqrt((A**2).sum(axis=2) * (residual**2).sum(axis=1)[:, None])
    assert (np.abs(gradient) / sizes)[~held].max() < 2e-3


def test_missing_bands_are_not_seen():
    A, target = linear_problems(20, seed=5)
    holes, fewer = target.copy(), np.delete(np.arange(N), 4)
    holes[:, 4] = np.nan
    expected, _ = solve_linear(
        np.ascontiguousarray(A[:, :, fewer]),
        np.ascontiguousarray(target[:, fewer]),
        np.zeros((0, N - 1)),
    )
    assert_allclose(solve_linear(A, holes)[0], expected, rtol=1e-9)


@numba.njit
def rosenbrock(values, table, constants, scratch, measured, jacobian):
    """Fill in Rosenbrock's 10 (y − x²) and 1 − x about the shift, and nothing."""
    x, y = values
    measured[0] = constants[0] + 0.01 * 10 * (y - x * x)
    measured[1] = constants[0] + 0.01 * (1 - x)
    measured[2] = constants[0]
    if jacobian.shape[0] == 2:
        jacobian[:, :] = 0.0
        jacobian[0, 0], jacobian[1, 0] = -0.2 * x, 0.1
        jacobian[0, 1] = -0.01


def solve_rosenbrock(start, high):
    """Return the solution from one start below upper bounds."""
    found = room(1, 2)
    case = problem(rosenbrock, np.zeros((1, 3)), [-5.0, -5.0], high, [start])
    solve(rosenbrock, case, np.full((1, 3), SHIFT), np.zeros((0, 3)), 1.0, found)
    return found


@pytest.mark.parametrize("start", [(-1.2, 1.0), (2.0, -1.0), (0.0, 0.0)])
def test_a_curved_valley_is_followed_to_its_end(start):
    found = solve_rosenbrock(start, [5.0, 5.0])
    assert found.status[0] == CONVERGED
    assert_allclose(found.values, 1, rtol=1e-6)


def test_a_curved_valley_is_left_where_the_bound_cuts_it():
    # With x ≤ ½ the best is x = ½, y = x².
    found = solve_rosenbrock((-1.2, 1.0), [0.5, 5.0])
    assert_array_equal(found.held, [[True, False]])
    assert_allclose(found.values, [[0.5, 0.25]], rtol=1e-5)


@numba.njit
def undefined(values, table, constants, scratch, measured, jacobian):
    """Fill in what is defined at the start x = 0 only."""
    measured[:] = constants[0] + (0.1 if values[0] == 0 else np.nan)
    for a in range(jacobian.shape[0]):
        jacobian[a, :] = 1.0


def test_where_no_step_can_be_taken_the_start_is_told_as_not_converged():
    found = room(1, 1)
    case = problem(undefined, np.zeros((1, N)), -1.0, 1.0, [[0.0]])
    solve(undefined, case, np.full((1, N), SHIFT), UNKNOWN, 1.0, found)
    assert found.status[0] == NOT_CONVERGED
    assert found.values[0, 0] == 0


@numba.njit
def two_valleys(values, table, constants, scratch, measured, jacobian):
    """Fill in what has a kink at −½, where the slope misleads, and is right at 1."""
    x = values[0]
    measured[:] = constants[0]
    measured[:] += 0.05 * (x - 1) ** 2 if x > 0 else 0.1 + np.abs(x + 0.5)
    for a in range(jacobian.shape[0]):
        jacobian[a, :] = 0.1 * (x - 1) if x > 0 else 1e-3


def test_another_start_is_tried_where_the_first_fails():
    found = room(1, 1)
    case = problem(two_valleys, np.zeros((1, N)), -1.0, 2.0, [[-0.5], [1.9]])
    case.sketch[:, 0] = SHIFT  # so that the start that fails is tried first
    solve(two_valleys, case, np.full((1, N), SHIFT), UNKNOWN, 1.0, found)
    assert found.status[0] == CONVERGED
    assert_allclose(found.values, [[1.0]], atol=1e-2)
