"""The compiled layer and stack against hundreds of digits, for ``skin_fit.py``."""

import sys
from pathlib import Path

import numpy as np
from _print import Row
from mpmath import mp

# The oracle and its like are no part of the package.
sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
from compiled_optics import layers, stacks
from oracles import kubelka_munk as oracle
from strategies import drawn
from tolerances import NORMAL

BACKINGS = (0.0, 0.5, 1.0)
RANGE = "0, 1e-16 … 1e16, D also inf"
NOTHING = 1e-48  # what 1 − R − T may be at K = 0, where κ is 1e-80


def rows(n: int) -> list[Row]:
    """Return the worst relative errors over the declared range."""
    return [*_layer_rows(n), *_stack_rows(n)]


def _layer_rows(n: int) -> list[Row]:
    """Return how far one layer is off, and its slopes by K."""
    K, S, D = points(n, seed=1)
    fluxes, _ = layers(K, S, D)
    names = ("R", "T", "1 − R", "1 − R − T")
    worst = [
        f"{name} {largest_error(own, true):.1e}"
        for name, own, true in zip(names, fluxes, oracle.layers(K, S, D), strict=True)
    ]
    K, S, D = (x[: n // 2] for x in (K, S, D))
    there = slope_exists(K, S, D)
    K, S, D = K[there], S[there], D[there]
    slopes = largest_error(layers(K, S, D)[1], oracle.layers_slopes(K, S, D))
    return [
        Row(f"layer, {n:,} points of {RANGE}", "1e-12", ", ".join(worst)),
        Row(f"layer, ∂R/∂K and ∂T/∂K, {K.size:,} points", "1e-12", f"{slopes:.1e}"),
    ]


def _stack_rows(n: int) -> list[Row]:
    """Return how far two layers over three backings are off, and their slopes."""
    value, by_K, by_S, by_D, n_slopes = 0.0, 0.0, 0.0, 0.0, 0
    for seed, backing in enumerate(BACKINGS, start=4):
        K, S, D = (np.stack(two) for two in zip(
            points(n, seed), points(n, seed + 100), strict=True
        ))  # fmt: skip
        with mp.workdps(oracle.DIGITS):
            true = [
                float(oracle.stack(*one, backing))
                for one in zip(K.T, S.T, D.T, strict=True)
            ]
        value = max(value, largest_error(stacks(K, S, D, backing)[0], true))
        there = np.flatnonzero(slope_exists(K, S, D).all(axis=0))[: n // 6]
        K, S, D = K[:, there], S[:, there], D[:, there]
        own, true = stacks(K, S, D, backing)[1], oracle.stacks_slopes(K, S, D, backing)
        n_slopes += there.size
        by_K = max(by_K, largest_error(own[0], true[0]))
        by_S = max(by_S, largest_error(own[1], true[1]))
        by_D = max(by_D, _depth_error(own[2], true, K, S, D))
    return [
        Row(
            f"two layers over backings 0, ½, 1: R_b, {3 * n:,} stacks",
            "1e-12",
            f"{value:.1e}",
        ),
        Row(
            f"– ∂R_b by K, S and D of either layer, {n_slopes:,} stacks",
            "1e-12",
            f"K {by_K:.1e}, S {by_S:.1e}, D {by_D:.1e} of its two parts",
        ),
    ]


def points(n: int, seed: int) -> tuple[np.ndarray, ...]:
    """Return K, S, D (n,) of the declared range, zeros and both ends among them."""
    rng = np.random.default_rng(seed)
    return drawn(rng, n), drawn(rng, n), drawn(rng, n, infinite=True)


def slope_exists(K: np.ndarray, S: np.ndarray, D: np.ndarray) -> np.ndarray:
    """Return where R and T have a finite slope and something to be a slope of."""
    return ~((K == 0) & (np.isinf(D) | (S == 0)))


def largest_error(actual: np.ndarray, expected: np.ndarray) -> float:
    """Return the worst relative error where the truth is a normal float.

    Where it is not, the result must be as small, else the error is infinite.
    """
    actual, expected = np.asarray(actual), np.asarray(expected)
    normal = np.abs(expected) >= NORMAL
    small = NOTHING if (expected == 0).any() else NORMAL
    if not (np.abs(actual[~normal]) <= small).all():
        return np.inf
    return float((np.abs(actual - expected)[normal] / np.abs(expected[normal])).max())


def _depth_error(
    own: np.ndarray, true: np.ndarray, K: np.ndarray, S: np.ndarray, D: np.ndarray
) -> float:
    """Return the worst error of ∂R_b/∂D over its two parts.

    D ∂/∂D = K ∂/∂K + S ∂/∂S: what absorption takes and scattering gives. Of their
    difference only as many digits can be right as it shares with the two.
    """
    finite = (D > 0) & np.isfinite(D)
    parts = (np.abs(true[:2]) * [K, S]).sum(axis=0)[finite] / D[finite]
    some = parts >= NORMAL
    gap = np.maximum(np.abs(own - true[2])[finite] - NOTHING, 0)
    return float((gap[some] / parts[some]).max())
