"""Paired tests against enumeration, closed testing and their own definitions."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skinviz.errors import ArgumentError
from skinviz.study.orders import Contrast, paired_contrast, verdict
from skinviz.study.statistics import holm


def a_sample(n, shift, seed=3, digits=6):
    rng = np.random.default_rng(seed)
    second = rng.gamma(2, 1, n)
    return (second + rng.normal(shift, 1, n)).round(digits), second.round(digits)


def signed_rank(gap):
    """Return the sum of ranks of positive differences, ranks averaged by hand."""
    size = np.abs(gap)
    ranks = [(size < s).sum() + ((size == s).sum() + 1) / 2 for s in size]
    return np.array(ranks), float(np.sum(np.array(ranks)[gap > 0]))


@pytest.mark.parametrize("shift", [0.0, 0.3, -0.6])
def test_p_is_that_of_all_signs(shift):
    first, second = a_sample(14, shift)
    ranks, own = signed_rank(first - second)
    signs = np.array(list(itertools.product((0, 1), repeat=14)))
    sums = signs @ ranks
    middle = ranks.sum() / 2
    exact = np.mean(np.abs(sums - middle) >= abs(own - middle) - 1e-9)
    assert paired_contrast(first, second).p == pytest.approx(exact)


def test_p_with_ties_and_zeros_is_near_that_of_random_signs():
    first, second = a_sample(60, 0.35, digits=1)
    gap = first - second
    assert (gap == 0).any()
    ranks, _ = signed_rank(gap)
    kept, sign = ranks[gap != 0], np.sign(gap[gap != 0])
    flips = np.random.default_rng(1).choice((-1, 1), (100_000, kept.size))
    expected = np.mean(np.abs(flips @ kept) >= abs(sign @ kept) - 1e-9)
    assert paired_contrast(first, second).p == pytest.approx(expected, abs=0.004)


def test_the_difference_is_the_median_of_all_means_of_two():
    first, second = a_sample(25, 0.4)
    gap = first - second
    means = [(a + b) / 2 for i, a in enumerate(gap) for b in gap[i:]]
    contrast = paired_contrast(first, second)
    assert contrast.difference == pytest.approx(np.median(means))
    low, high = contrast.interval
    assert low < contrast.difference < high


def test_the_interval_ends_where_the_test_stops_rejecting():
    first, second = a_sample(80, 0.4)
    low, high = paired_contrast(first, second).interval
    width = high - low
    for end, outwards in ((low, -1), (high, 1)):
        inside = paired_contrast(first - end + outwards * 0.03 * width, second)
        outside = paired_contrast(first - end - outwards * 0.03 * width, second)
        assert inside.p > 0.05 or outside.p > 0.05
        assert min(inside.p, outside.p) < 0.06


def test_turned_round_all_but_p_changes_sign():
    first, second = a_sample(40, 0.3, digits=1)  # with ties and zeros
    one, other = paired_contrast(first, second), paired_contrast(second, first)
    assert one.p == pytest.approx(other.p)
    assert one.effect == pytest.approx(-other.effect)
    assert one.difference == pytest.approx(-other.difference)
    assert one.share == pytest.approx(1 - other.share)
    assert_allclose(one.interval, -np.array(other.interval)[::-1])


def test_effect_and_share_at_their_ends():
    x = np.arange(12.0)
    always = paired_contrast(x + 1 + x / 10, x)
    assert (always.effect, always.share, always.n) == (1, 1, 12)
    same = paired_contrast(x, x)
    assert (same.effect, same.share, same.p, same.difference) == (0, 0.5, 1, 0)


def test_people_without_a_value_are_left_out():
    first, second = a_sample(30, 0.4)
    holed = np.append(first, [np.nan, 1.0])
    other = np.append(second, [1.0, np.nan])
    assert paired_contrast(holed, other) == paired_contrast(first, second)


def test_holm_is_closed_testing_by_bonferroni():
    rng = np.random.default_rng(5)
    for _ in range(20):
        p = rng.uniform(0, 0.2, 5).round(3)
        expected = [
            max(
                min(1, len(own) * min(p[list(own)]))
                for n in range(1, 6)
                for own in itertools.combinations(range(5), n)
                if i in own
            )
            for i in range(5)
        ]
        assert_allclose(holm(p), expected)


def contrast(effect):
    return Contrast(50, effect, (0, 0), effect, 0.5, 0.0)


@pytest.mark.parametrize(
    ("effects", "p", "told"),
    [
        ((0.5, 0.4, 0.3), (0.001, 0.001, 0.04), "holds"),
        ((0.5, 0.4, 0.3), (0.001, 0.001, 0.06), "open"),
        ((0.5, -0.4, 0.3), (0.001, 0.2, 0.001), "open"),
        ((0.5, -0.4, 0.3), (0.001, 0.01, 0.001), "contradicted"),
    ],
)
def test_verdicts(effects, p, told):
    assert verdict([contrast(e) for e in effects], p, "most") == told
    assert verdict([contrast(-e) for e in effects], p, "least") == told


def test_wrong_use_is_told():
    with pytest.raises(ArgumentError, match="at least 6 people"):
        paired_contrast([1, 2, 3], [2, 3, 4])
    with pytest.raises(ArgumentError, match="equal length"):
        paired_contrast(np.ones(9), np.ones(8))
    with pytest.raises(ArgumentError, match="did you mean 'most'"):
        verdict([contrast(1)], [0.1], "mosts")
