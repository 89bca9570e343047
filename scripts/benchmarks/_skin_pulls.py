"""Are the intervals honest? Known truths, known noise, for ``skin_fit.py``."""

import numpy as np
from _print import Row, columns
from _skin_data import NM

from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model
from skinviz.skin.skin_fit import SkinFit

SIGMA = 2e-3
LOW, HIGH = np.array((0.05, 0.004, 0.004)), np.array((0.3, 0.02, 0.02))
NEAR = (3e-4, 6e-4, 6e-4)  # so near 0 that many a fit stops there
SMALL = 5e-4  # noise at which the model is straight over an interval


def rows(n: int) -> list[Row]:
    """Return spread of pulls and coverage, within and at the bounds."""
    rng = np.random.default_rng(6)
    return [*_interior(n, rng), *_at_zero(n, rng), _stopped(n, rng)]


def _interior(n: int, rng: np.random.Generator) -> list[Row]:
    """Return the figures of truths well inside, σ given and not."""
    truth = rng.uniform(LOW, HIGH, (n, 3))
    given, unknown = _fit(truth, SIGMA, rng), _fit(truth, SIGMA, rng, known=False)
    free = given.status == "converged"
    deviation = np.sqrt(np.einsum("mpp->mp", given.covariance))[free]
    pulls = (given.values - truth)[free] / deviation
    return [
        Row(
            f"pulls of w_m, w_h, w_dh, {int(free.sum()):,} of {n:,} optima within the "
            f"bounds, σ = {SIGMA:g} given: SD (mean)",
            "1.0 ± 0.1",
            f"{columns(pulls.std(axis=0))} ({columns(pulls.mean(axis=0))})",
        ),
        Row(
            "95 % intervals hold the truth, σ given; σ from the residuals",
            "93–97 %",
            f"{_covered(given, truth)}; {_covered(unknown, truth)}",
        ),
    ]


def _at_zero(n: int, rng: np.random.Generator) -> list[Row]:
    """Return coverage where one weight is truly 0.

    Half the estimates then stop at 0 and the other half would; only those that are
    1.96 σ off exclude it: 97.5 % by what the interval means.
    """
    told = []
    for k in range(3):
        truth = rng.uniform(LOW, HIGH, (n // 3, 3))
        truth[:, k] = 0
        told.append(_covered(_fit(truth, SIGMA, rng), truth))
    return [
        Row(
            f"– a weight truly 0, {n // 3:,} each: w_m = 0; w_h = 0; w_dh = 0",
            "93–97 %, its own 97.5 %",
            "; ".join(told),
        )
    ]


def _stopped(n: int, rng: np.random.Generator) -> Row:
    """Return the share of one-sided intervals that hold truths drawn evenly."""
    told = []
    for k in range(3):
        truth = rng.uniform(LOW, HIGH, (n, 3))
        truth[:, k] = rng.uniform(0, NEAR[k], n)
        fit = _fit(truth, SMALL, rng)
        at = fit.values[:, k] == 0
        inside = truth[at, k] <= fit.interval[at, k, 1]
        told.append(f"{inside.mean():.1%} of {int(at.sum()):,}")
    return Row(
        "– one-sided intervals of fits that stop at 0, truths drawn evenly from 0 on",
        "93–97 %",
        ", ".join(told),
    )


def _fit(
    truth: np.ndarray, sigma: float, rng: np.random.Generator, *, known: bool = True
) -> SkinFit:
    """Return the fit of truths with noise."""
    model = skin_model(site="back of hand", specular="included")
    data = model.measured(truth, NM) + rng.normal(0, sigma, (len(truth), NM.size))
    given = np.full(NM.size, sigma) if known else None
    return fit_skin(data, NM, model, uncertainty=given)


def _covered(fit: SkinFit, truth: np.ndarray) -> str:
    """Return for each weight the share of intervals that hold the truth."""
    inside = (fit.interval[..., 0] <= truth) & (truth <= fit.interval[..., 1])
    return ", ".join(f"{share:.1%}" for share in inside.mean(axis=0))
