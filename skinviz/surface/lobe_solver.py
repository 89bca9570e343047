"""The search for the lobe that is nearest to readings: many starts, then descents."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinviz.surface.fitted_lobe import AT_BOUND, CONVERGED, NOT_CONVERGED
from skinviz.surface.lobe_curve import BOUNDS, LobeCurve

Array = NDArray[np.float64]

_STEPS = 1000  # of the solver, at most
_TRIED = {
    "gamma": np.geomspace(*BOUNDS["gamma"], 48),
    "n": 1 + np.geomspace(1e-3, 2.0, 12),
}
_DESCENTS = 6  # of the most promising starts


def solve(
    curve: LobeCurve, data: Array, sigma: Array
) -> tuple[Array, NDArray[np.bool_], str]:
    """Return the best values (p,), which are at their bound, and how it ended."""
    sigma = sigma * np.abs(data / sigma).max()  # so that the solver's limits fit
    problem = _Problem(curve, data, sigma)
    values, converged = _best(problem)
    low, high = curve.bounds
    at_most = problem.linear and values[0] == high[0]
    if values.size > 1 and problem.linear and (at_most or not converged):
        # Where β does not follow the others any more, only they can descend.
        found, ended = _descend(problem.at_most_beta(), values[1:])
        found = np.concatenate([high[:1], found])
        if ended and problem.cost(found) <= problem.cost(values):
            values, converged = found, ended
    held = (values == low) | (values == high)
    if not converged:
        return values, held, NOT_CONVERGED
    return values, held, AT_BOUND if held.any() else CONVERGED


def _best(problem: _Problem) -> tuple[Array, bool]:
    """Return the values (p,) where the best descent ended, and whether it converged."""
    if problem.curve.names == ("beta",):
        return problem.complete(np.zeros(0)), True
    ends = [_descend(problem, start) for start in _starts(problem)]
    costs = [problem.cost(values) for values, _ in ends]
    return ends[int(np.argmin(costs))]


@dataclass(frozen=True, eq=False)
class _Problem:
    """Least squares in which β, where it is free, is the best for all the others."""

    curve: LobeCurve
    data: Array
    sigma: Array

    @property
    def linear(self) -> bool:
        """Whether β is free; it is then the first of the values."""
        return self.curve.names[0] == "beta"

    def at_most_beta(self) -> _Problem:
        """Return the problem with β at its upper bound."""
        curve = self.curve
        fixed = {**curve.fixed, "beta": BOUNDS["beta"][1]}
        return replace(self, curve=replace(curve, names=curve.names[1:], fixed=fixed))

    def complete(self, rest: Array) -> Array:
        """Return all values (..., p) from those of the others."""
        if not self.linear:
            return rest
        one = np.ones((*rest.shape[:-1], 1))
        unit = self.curve(np.concatenate([one, rest], axis=-1)) / self.sigma
        size = np.square(unit).sum(axis=-1)
        along = unit @ (self.data / self.sigma)
        best = np.divide(along, size, out=np.zeros(size.shape), where=size > 0)
        beta = np.clip(best, *BOUNDS["beta"])[..., None]
        return np.concatenate([beta, rest], axis=-1)

    def residuals(self, values: Array) -> Array:
        """Return (fitted − data)/σ (..., m)."""
        return np.asarray((self.curve(values) - self.data) / self.sigma)

    def cost(self, values: Array) -> Array:
        """Return the sum of squares (...)."""
        return np.asarray(np.square(self.residuals(values)).sum(axis=-1))

    def slopes(self, values: Array) -> Array:
        """Return the residuals' slopes by the others, β following (Kaufman's form)."""
        J = self.curve.slopes(values) / self.sigma[:, None]
        if not self.linear:
            return np.asarray(J)
        unit, rest = J[:, :1], J[:, 1:]
        size = float(np.square(unit).sum())
        low, high = BOUNDS["beta"]
        if size > 0 and low < values[0] < high:
            rest = rest - unit * (unit.T @ rest) / size
        return np.asarray(rest)


def _descend(problem: _Problem, start: Array) -> tuple[Array, bool]:
    """Return values (p,), and whether the descent to them converged."""
    from scipy.optimize import Bounds, least_squares

    low, high = problem.curve.bounds[:, -start.size :]

    def residuals(x: Array) -> Array:
        return problem.residuals(problem.complete(x * start))

    def slopes(x: Array) -> Array:
        return np.asarray(problem.slopes(problem.complete(x * start)) * start)

    result = least_squares(
        residuals,
        np.ones(start.size),
        jac=slopes,
        bounds=Bounds(low / start, high / start),
        method="dogbox",
        ftol=1e-14,
        xtol=1e-12,
        gtol=1e-15,
        max_nfev=_STEPS,
    )
    below, above = result.active_mask < 0, result.active_mask > 0
    rest = np.where(below, low, np.where(above, high, result.x * start))
    return problem.complete(rest), result.status > 0


def _starts(problem: _Problem) -> list[Array]:
    """Return the valleys of a grid over all but β, the deepest first.

    A valley is where the cost, at the best n for each γ, has a minimum.
    """
    axes = [_TRIED[name] for name in problem.curve.names if name != "beta"]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    costs = problem.cost(problem.complete(grid))
    table = costs.reshape(len(axes[0]), -1)
    best = table.argmin(axis=1)
    along = np.pad(table.min(axis=1), 1, constant_values=np.inf)
    valleys = np.flatnonzero((along[1:-1] < along[:-2]) & (along[1:-1] <= along[2:]))
    deepest = valleys[np.argsort(along[1:-1][valleys], kind="stable")][:_DESCENTS]
    return list(grid.reshape(*table.shape, -1)[deepest, best[deepest]])
