"""Means, differences and Holm's correction against SciPy and the formulas by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

from skinviz import ArgumentError
from skinviz.study.statistics import (
    ALIKE,
    CONFOUNDED,
    TOO_FEW,
    difference_within,
    holm,
    mean_interval,
    paired_difference,
    unpaired_difference,
)

RNG = np.random.default_rng(11)
FIRST, SECOND = RNG.normal(5, 2, 12), RNG.normal(6.5, 3, 12)
SAME = 1e-12  # another order of the same sums


def test_the_interval_of_a_mean_is_scipys():
    found = mean_interval(FIRST)
    expected = stats.t.interval(0.95, 11, FIRST.mean(), stats.sem(FIRST))
    assert_allclose([found.low, found.high], expected, rtol=SAME)
    assert_allclose(found.deviation, FIRST.std(ddof=1), rtol=SAME)
    assert found.n == 12


def test_numbers_that_were_not_measured_are_left_out():
    holed = np.concatenate([FIRST, [np.nan, np.nan]])
    assert mean_interval(holed) == mean_interval(FIRST)
    assert unpaired_difference(holed, SECOND) == unpaired_difference(FIRST, SECOND)
    pairs = paired_difference(holed, np.concatenate([SECOND, [1.0, np.nan]]))
    assert pairs == paired_difference(FIRST, SECOND)


def test_too_few_numbers_have_a_mean_and_no_interval():
    assert mean_interval([]).mean is None
    one = mean_interval([3.0])
    assert (one.n, one.mean, one.low, one.high, one.deviation) == (
        *(1, 3.0, None, None, None),
    )
    for found in (
        paired_difference([1.0], [3.0]),
        unpaired_difference([1.0], [3.0, 3.5]),
        difference_within([1.0, 2.0], [3.0], ["a", "a"], ["a"]),
    ):
        assert found.why == TOO_FEW
        assert found.p is found.effect is found.low is None
        assert found.difference is not None
    assert unpaired_difference([], [1.0, 2.0]).difference is None


def test_pairs_are_tested_as_scipy_tests_them():
    found = paired_difference(FIRST, SECOND)
    expected = stats.ttest_rel(SECOND, FIRST)
    assert_allclose(found.p, expected.pvalue, rtol=1e-10)
    interval = expected.confidence_interval(0.95)
    assert_allclose([found.low, found.high], [*interval], rtol=1e-10)
    apart = SECOND - FIRST
    assert_allclose(found.effect, apart.mean() / apart.std(ddof=1), rtol=SAME)
    assert (found.test, found.effect_name) == ("paired t", "Cohen d_z")


def test_two_sets_are_tested_as_welch_does():
    few = SECOND[:7]
    found = unpaired_difference(FIRST, few)
    expected = stats.ttest_ind(few, FIRST, equal_var=False)
    assert_allclose(found.p, expected.pvalue, rtol=1e-10)
    interval = expected.confidence_interval(0.95)
    assert_allclose([found.low, found.high], [*interval], rtol=1e-10)
    assert found.n == (12, 7)


def test_hedges_g_by_its_formula():
    a, b = np.array([1.0, 2.0, 4.0]), np.array([3.0, 5.0, 9.0, 6.0])
    pooled = np.sqrt((2 * a.var(ddof=1) + 3 * b.var(ddof=1)) / 5)
    d = (b.mean() - a.mean()) / pooled
    found = unpaired_difference(a, b)
    assert found.effect_name == "Hedges g"
    # The exact factor; 1 − 3/(4·5 − 1) is its usual approximation.
    exact = 1.3293403881791370 / (np.sqrt(2.5) * 1.0)  # Γ(5/2)/(√(5/2) Γ(2))
    assert_allclose(found.effect, exact * d, rtol=1e-12)
    assert_allclose(found.effect, (1 - 3 / 19) * d, rtol=2e-3)


def test_hedges_g_is_unbiased_in_small_sets():
    rng = np.random.default_rng(5)
    draws = rng.normal(0, 1, (20_000, 8)) + np.repeat([0.0, 0.8], 4)
    effects = [unpaired_difference(d[:4], d[4:]).effect for d in draws[:4000]]
    error = np.std(effects) / np.sqrt(len(effects))
    assert abs(np.mean(effects) - 0.8) < 3.5 * error


def test_origin_is_a_factor_of_least_squares():
    origins_1, origins_2 = np.repeat(["x", "y"], [8, 4]), np.repeat(["x", "y"], [3, 9])
    first, second = FIRST + 10 * (origins_1 == "y"), SECOND + 10 * (origins_2 == "y")
    found = difference_within(first, second, origins_1, origins_2)
    values = np.concatenate([first, second])
    design = np.column_stack(
        [
            np.ones(24),
            np.repeat([0.0, 1.0], 12),
            np.concatenate([origins_1, origins_2]) == "y",
        ]
    )
    solution, rest, *_ = np.linalg.lstsq(design, values, rcond=None)
    variance = rest[0] / 21 * np.linalg.inv(design.T @ design)[1, 1]
    t = solution[1] / np.sqrt(variance)
    assert_allclose(found.difference, solution[1], rtol=1e-10)
    assert_allclose(found.p, 2 * stats.t.sf(abs(t), 21), rtol=1e-9)
    reach = stats.t.ppf(0.975, 21) * np.sqrt(variance)
    assert_allclose([found.low, found.high], solution[1] + [-reach, reach], rtol=1e-9)


def test_with_one_origin_the_factor_changes_nothing_but_the_pooling():
    found = difference_within(FIRST, SECOND, ["x"] * 12, ["x"] * 12)
    expected = stats.ttest_ind(SECOND, FIRST)
    assert_allclose(found.p, expected.pvalue, rtol=1e-10)
    assert_allclose(found.effect, unpaired_difference(FIRST, SECOND).effect, rtol=1e-10)


def test_origins_with_one_set_only_do_not_count():
    both = difference_within(FIRST, SECOND, ["x"] * 12, ["x"] * 12)
    more = difference_within(
        [*FIRST, 99.0, -99.0], SECOND, [*["x"] * 12, "y", "y"], ["x"] * 12
    )
    assert more == both


def test_sets_of_other_origins_cannot_be_told_from_these():
    found = difference_within(FIRST, SECOND, ["x"] * 12, ["y"] * 12)
    assert found.why == CONFOUNDED
    assert found.p is found.difference is found.low is None
    assert found.n == (12, 12)


@pytest.mark.parametrize("level", [0.0, 0.1, 1e-300, 1e12])
def test_without_variance_there_is_no_test(level):
    alike = np.full(5, level)
    moved = alike + 1.0
    for found in (
        paired_difference(alike, moved),
        unpaired_difference(alike, moved),
        difference_within(alike, moved, ["x"] * 5, ["x"] * 5),
        paired_difference(alike, alike),
        unpaired_difference(alike, alike),
    ):
        assert found.why == ALIKE
        assert found.p is found.effect is None


def test_rounding_is_no_variance():
    first = np.array([0.1, 0.2, 0.3, 0.7])
    found = paired_difference(first, first + 0.1)
    assert found.why == ALIKE


def test_pairs_must_be_pairs():
    with pytest.raises(ArgumentError, match="pairs need two lists as long"):
        paired_difference([1.0, 2.0], [1.0])


def holm_by_hand(p):
    """Return Holm's corrected p-values one by one."""
    order = sorted(range(len(p)), key=lambda i: p[i])
    corrected, highest = [0.0] * len(p), 0.0
    for rank, i in enumerate(order):
        highest = max(highest, (len(p) - rank) * p[i])
        corrected[i] = min(highest, 1.0)
    return corrected


@given(st.lists(st.floats(0, 1), max_size=20))
def test_holm_by_hand(p):
    assert_allclose(holm(p), holm_by_hand(p), rtol=1e-15)


def test_holm_passes_over_what_was_not_tested():
    assert_array_equal(holm([0.01, np.nan, 0.04]), [0.02, np.nan, 0.04])
    assert holm([]).size == 0


def test_holm_keeps_its_promise():
    """Of ten true null hypotheses one or more is rejected in at most 5 % of cases."""
    rng = np.random.default_rng(8)
    wrong = np.mean([(holm(rng.random(10)) < 0.05).any() for _ in range(4000)])
    assert wrong < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 4000)


def held(difference, truth):
    """Return whether an interval holds the true difference."""
    return difference.low <= truth <= difference.high


def test_intervals_hold_at_their_rate():
    rng = np.random.default_rng(21)
    n, paired, welch, within = 2000, 0, 0, 0
    for _ in range(n):
        person = rng.normal(0, 2, 6)
        first, second = person + rng.normal(0, 1, 6), person + rng.normal(1, 1, 6)
        paired += held(paired_difference(first, second), 1.0)
        few, many = rng.normal(0, 3, 5), rng.normal(1, 1, 9)
        welch += held(unpaired_difference(few, many), 1.0)
        lab = np.array([0, 0, 0, 5, 5, 5.0])
        one, two = rng.normal(lab, 1), rng.normal(lab[::-1][:4] + 1, 1)
        names = np.where(lab == 5, "y", "x")
        within += held(difference_within(one, two, names, names[::-1][:4]), 1.0)
    error = np.sqrt(0.95 * 0.05 / n)
    for hits in (paired, welch, within):
        assert abs(hits / n - 0.95) < 3.5 * error
