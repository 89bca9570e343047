"""Few nodes are as good as single exchanges make them, and found by sound shortcuts."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz.spectra.node_choice import _NOISE, _compressed, _exchanged, few_nodes


def left_of(rows, goal, nodes):
    """Return what weights of any sign leave of a goal, noise of each node counted."""
    noisy = np.concatenate([rows[:, nodes], _NOISE * np.eye(len(nodes))])
    padded = np.concatenate([goal, np.zeros((len(nodes), goal.shape[1]))])
    weights = np.linalg.lstsq(noisy, padded, rcond=None)[0]
    return ((noisy @ weights - padded) ** 2).sum()


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_no_exchange_of_one_node_would_help_much(seed, n):
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((12, 30)) * np.geomspace(1, 1e-3, 12)[:, None]
    goal = rows @ rng.uniform(0, 1, (30, 3))
    start = np.sort(rng.choice(30, n, replace=False))
    nodes = _exchanged(rows, goal, start)
    assert np.unique(nodes).size == n
    reached = left_of(rows, goal, nodes)
    assert reached <= left_of(rows, goal, start) * (1 + 1e-9)
    for i in range(n):
        others = np.delete(nodes, i)
        held = left_of(rows, goal, others) - reached
        for new in np.setdiff1d(np.arange(30), nodes):
            gain = reached - left_of(rows, goal, [*others, new])
            assert gain <= 1.001e-3 * held + 1e-9 * (goal**2).sum()


def test_one_node_is_the_best_of_all():
    rng = np.random.default_rng(1)
    rows, goal = rng.standard_normal((5, 40)), rng.standard_normal((5, 3))
    best = np.argmin([left_of(rows, goal, [i]) for i in range(40)])
    (node,) = _exchanged(rows, goal, np.array([7]))
    assert left_of(rows, goal, [node]) <= left_of(rows, goal, [best]) * 1.001


def test_few_rows_stand_for_many_spectra():
    rng = np.random.default_rng(2)
    nm = np.linspace(0, 1, 100)
    spectra = rng.uniform(0, 1, (500, 1)) + rng.standard_normal((500, 6)) @ np.cos(
        np.arange(1, 7)[:, None] * nm
    )
    *rows, white = _compressed(spectra)
    assert len(rows) <= 40
    assert_array_equal(white, white[0])
    for _ in range(20):
        weights = rng.standard_normal(100)
        expected = np.linalg.norm(spectra @ weights)
        assert_allclose(np.linalg.norm(np.array(rows) @ weights), expected, rtol=1e-6)


def test_smooth_spectra_need_few_nodes():
    # Parabolas and their squares are five functions, which n nodes integrate well.
    nm = np.arange(400.0, 701)
    x = (nm - 550) / 150
    rng = np.random.default_rng(3)
    spectra = 0.4 + rng.uniform(-0.15, 0.15, (100, 3)) @ np.stack([x**0, x, x**2])
    weights = np.stack([np.exp(-0.5 * ((x - c) / 0.3) ** 2) for c in (-0.5, 0, 0.4)], 1)
    off = []
    for n in (3, 5, 8):
        nodes, found = few_nodes(spectra, nm, weights, n)
        error = spectra[:, nodes] @ found / (spectra @ weights) - 1
        off.append(np.abs(error).max())
    assert off[0] < 0.05
    assert off[1] < 0.01
    assert off[2] < 2e-3


def test_dark_wavelengths_are_not_chosen():
    nm = np.arange(400.0, 701)
    weights = np.where(((nm > 450) & (nm < 600))[:, None], [1.0, 2.0, 0.5], 0.0)
    nodes, found = few_nodes(np.linspace(0.2, 0.6, 301)[None], nm, weights, 6)
    assert ((nm[nodes] > 450) & (nm[nodes] < 600)).all()
    assert_allclose(found.sum(axis=0), weights.sum(axis=0))
