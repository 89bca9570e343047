"""What keeping a tolerance means: ΔE00 by another library, bounds by binomials."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.stats import binom, hypergeom

from skinviz.rendering.tolerance import (
    FEW,
    Difference,
    colour_differences,
    compare,
    edge_allowance,
    percentile_bound,
)

D65 = np.array([0.95047, 1.0, 1.08883])
FLAT = np.ones(3)


def some_xyz(n, seed=0, brightest=1.0):
    return np.random.default_rng(seed).uniform(1e-4, brightest, (n, 3))


def by_colour_science(colour, xyz, reference, white):
    """ΔE00 of XYZ that colour-science finds; it wants Y = 100 for white."""
    x, y = white[:2] / white.sum()
    lab = [
        colour.XYZ_to_Lab(values / white[1], np.array([x, y]))
        for values in (xyz, reference)
    ]
    return colour.delta_E(*lab, method="CIE 2000")


# Colour differences -------------------------------------------------------------


@pytest.mark.parametrize("white", [D65, FLAT, 0.7 * D65, [1.0985, 1.0, 0.3558]])
def test_differences_are_those_of_colour_science(colour, white):
    white = np.array(white)
    xyz, reference = some_xyz(500, 1), some_xyz(500, 2)
    found = colour_differences(xyz, reference, white)
    expected = by_colour_science(colour, xyz, reference, white)
    assert_allclose(found, expected, rtol=1e-9)


def test_near_colours_differ_as_colour_science_says(colour):
    reference = some_xyz(500, 1)
    xyz = reference * np.random.default_rng(3).normal(1, 1e-3, (500, 3))
    found = colour_differences(xyz, reference, D65)
    expected = by_colour_science(colour, xyz, reference, D65)
    assert_allclose(found, expected, rtol=1e-6)
    assert found.max() < 1


def test_colours_above_white_count_as_scaled_to_it(colour):
    xyz, reference = some_xyz(500, 1, 4.0), some_xyz(500, 2, 4.0)
    assert (xyz[:, 1] > 1).sum() > 100

    def scaled(values):
        return values / np.where(values[:, 1:2] > 1, values[:, 1:2], 1)

    found = colour_differences(xyz, reference, D65)
    expected = by_colour_science(colour, scaled(xyz), scaled(reference), D65)
    assert_allclose(found, expected, rtol=1e-9)


@given(st.floats(1.0, 1e6), st.floats(1.0, 1e6))
def test_over_exposed_pixels_of_one_hue_do_not_differ(one, other):
    colour = np.array([[0.95, 1.0, 0.8]])
    assert colour_differences(one * colour, other * colour, D65) < 1e-9


@pytest.mark.parametrize(
    ("white", "stands"),
    [
        ([0.0099, 1.0, 0.5], FLAT),
        ([0.5, 1.0, 0.0099], FLAT),
        ([0.0, 2.0, 0.0], 2 * FLAT),
        ([0.0101, 1.0, 0.0101], None),
    ],
)
def test_equal_energy_stands_for_a_white_without_x_or_z(colour, white, stands):
    white = np.array(white)
    # As a lamp of one line gives: on its own ray of XYZ.
    y = np.linspace(0.05, 0.5, 9)[:, None]
    xyz, reference = y * white, 0.9 * y * white
    found = colour_differences(xyz, reference, white)
    instead = white if stands is None else stands
    expected = by_colour_science(colour, xyz, reference, instead)
    assert_allclose(found, expected, rtol=1e-9)
    assert (found > 0.5).all()


# A picture and its reference ----------------------------------------------------


def picture(n_filled, n_edge, n_empty=7, *, seed=0):
    """Colours of filled, edge and empty pixels, and how many rays hit in each."""
    rng = np.random.default_rng(seed)
    n = n_filled + n_edge + n_empty
    covered = np.concatenate(
        [
            np.full(n_filled, 16),
            1 + np.arange(n_edge) % 15,
            np.zeros(n_empty),
        ]
    ).astype(np.uint8)
    reference = rng.uniform(0.2, 0.9, (n, 3))
    reference[covered == 0] = 0
    order = rng.permutation(n)
    return reference[order], covered[order]


def off(reference, which, factor):
    """A picture that differs in some pixels."""
    xyz = reference.copy()
    xyz[which] *= factor
    return xyz


@pytest.mark.parametrize("n_filled", [FEW, 3000])
def test_filled_pixels_are_judged_by_their_99th_percentile(n_filled):
    reference, covered = picture(n_filled, 50)
    filled = np.flatnonzero(covered == 16)
    all_off = off(reference, filled, np.array([1.1, 1.05, 0.9]))
    differences = colour_differences(all_off[filled], reference[filled], D65)
    found = compare(all_off, reference, covered, D65)
    assert found.filled == pytest.approx(np.quantile(differences, 0.99), rel=1e-12)
    assert found.most_filled == differences.max()
    assert (found.n_filled, found.n_edge) == (n_filled, 50)
    assert found.edge == found.most_edge == found.unlit == 0
    assert found.kept(found.filled)
    assert not found.kept(0.999 * found.filled)


def test_fewer_than_a_thousand_filled_pixels_are_judged_by_the_largest():
    for n_filled, kept in ((FEW - 1, False), (FEW, True)):
        reference, covered = picture(n_filled, 5)
        one = np.flatnonzero(covered == 16)[:1]
        found = compare(off(reference, one, 0.3), reference, covered, D65)
        assert found.most_filled > 5
        assert found.filled == 0
        assert found.kept(1.0) is kept


def test_with_few_filled_pixels_the_largest_counts_at_edges_too():
    for n_filled, kept in ((10, False), (FEW, True)):
        reference, covered = picture(n_filled, 400)
        one = np.flatnonzero((covered > 0) & (covered < 16))[:1]
        found = compare(off(reference, one, 0.3), reference, covered, D65)
        assert found.most_edge > 5
        assert found.kept(1.0) is kept


def test_edges_are_judged_apart_and_may_always_differ_by_two():
    reference, covered = picture(2000, 300)
    edges = np.flatnonzero((covered > 0) & (covered < 16))
    found = compare(off(reference, edges, 1.03), reference, covered, D65)
    assert found.filled == found.most_filled == 0
    assert 0 < found.edge < 2
    assert found.kept(0.01)
    found = compare(off(reference, edges, 1.2), reference, covered, D65)
    assert found.edge > 2
    assert not found.kept(2.0)
    assert found.kept(found.edge)


@pytest.mark.parametrize("tolerance", [0.01, 1.0, 2.0, 2.5, 100.0])
def test_edges_are_allowed_the_tolerance_or_two(tolerance):
    assert edge_allowance(tolerance) == max(tolerance, 2.0)


def test_unlit_pixels_do_not_count_but_are_told():
    reference, covered = picture(2000, 100)
    filled = np.flatnonzero(covered == 16)
    reference[filled[:500]] = 0
    found = compare(reference, reference, covered, D65)
    assert found.unlit == 0.25
    assert found.n_filled == 1500
    assert found.filled == found.most_filled == 0


def test_light_where_the_reference_is_dark_counts():
    reference, covered = picture(2000, 100)
    filled = np.flatnonzero(covered == 16)
    reference[filled[:500]] = 0
    xyz = reference.copy()
    xyz[filled[:500]] = 0.5
    found = compare(xyz, reference, covered, D65)
    assert (found.unlit, found.n_filled) == (0.25, 1500)
    assert found.filled > 50


def test_pixels_without_the_mesh_do_not_count():
    reference, covered = picture(1000, 10, 500)
    xyz = reference.copy()
    xyz[covered == 0] = 0.7
    found = compare(xyz, reference, covered, D65)
    assert found.most_filled == found.most_edge == 0


def test_pictures_have_rows_and_columns():
    reference, covered = picture(1500, 250, 50)
    xyz = reference * 1.05
    flat = compare(xyz, reference, covered, D65)
    shape = (30, 60)
    folded = compare(
        xyz.reshape(*shape, 3).astype(np.float32),
        reference.reshape(*shape, 3),
        covered.reshape(shape),
        D65,
    )
    assert folded.filled == pytest.approx(flat.filled, rel=1e-4)
    assert (folded.n_filled, folded.n_edge) == (flat.n_filled, flat.n_edge)


def test_nothing_differs_from_nothing():
    found = compare(np.zeros((4, 4, 3)), np.zeros((4, 4, 3)), np.zeros((4, 4)), D65)
    assert found == Difference(0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    assert found.kept(0.01)


def test_the_same_picture_keeps_any_tolerance():
    reference, covered = picture(1200, 90)
    assert compare(reference, reference, covered, D65).kept(0.0)


# Bounds from samples ------------------------------------------------------------


def brute_force_rank(n, population):
    """How many of n draws may lie above a bound of the 99th percentile; -1: none.

    If it were none, as many of all would be above it as lift the percentile over it,
    of which more than so few are drawn, but for a chance of 0.001.
    """
    beyond = next(
        k for k in range(population + 1) if np.quantile(above(k, population), 0.99) > 0
    )
    fitting = [k for k in range(n) if hypergeom.cdf(k, population, beyond, n) <= 1e-3]
    return max(fitting, default=-1)


def above(k, population):
    """Of all, k that are above 0."""
    return np.repeat([0.0, 1.0], [population - k, k])


@pytest.mark.parametrize(
    ("n", "population"),
    [
        *((n, 1000) for n in (1, 300, 687, 999, 1000)),
        *((n, 1001) for n in (300, 688, 1001)),
        *((n, 1500) for n in (687, 688, 1100, 1500)),
        *((n, 40_000) for n in (688, 1100, 3000)),
    ],
)
def test_bounds_are_the_order_statistics_that_drawing_says(n, population):
    draws = np.random.default_rng(n).permutation(n).astype(float)
    spare = brute_force_rank(n, population)
    expected = np.inf if spare < 0 else n - 1 - spare
    assert percentile_bound(draws, population) == expected


@pytest.mark.parametrize("n", [688, 918, 919, 1100, 3000])
def test_of_very_many_draws_are_binomial(n):
    spare = max(k for k in range(n) if binom.cdf(k, n, 0.01) <= 1e-3)
    draws = np.random.default_rng(n).permutation(n).astype(float)
    assert percentile_bound(draws, 10**7) == n - 1 - spare


def test_samples_too_small_to_tell_have_no_bound():
    # 0.99^n falls below 0.001 at n = 688.
    assert 0.99**687 > 1e-3 > 0.99**688
    for n in (0, 1, 680):
        assert percentile_bound(np.zeros(n), 10**6) == np.inf
    assert percentile_bound(np.zeros(688), 10**6) == 0


@pytest.mark.parametrize("n", [0, 1, 500, FEW - 1])
def test_of_few_that_are_all_there_are_the_largest_is_the_bound(n):
    draws = np.random.default_rng(n).gamma(1, 1, n)
    assert percentile_bound(draws, n) == (draws.max() if n else 0.0)


@given(st.integers(FEW, 4000), st.integers(0, 2**32 - 1))
@example(1000, 0)
@example(2000, 1)
def test_of_many_that_are_all_there_are_their_percentile_is_below(n, seed):
    draws = np.random.default_rng(seed).pareto(1, n)
    bound = percentile_bound(draws, n)
    assert np.percentile(draws, 99) <= bound <= np.sort(draws)[-(n // 100)]


@pytest.mark.parametrize(("n", "population"), [(700, 1500), (1100, 10**5)])
def test_a_bound_is_too_low_in_less_than_one_case_of_a_thousand(n, population):
    rng = np.random.default_rng(n)
    every = np.sort(rng.exponential(1, population))
    true = np.percentile(every, 99)
    bounds = np.array(
        [
            percentile_bound(
                rng.choice(every, n, replace=False, shuffle=False), population
            )
            for _ in range(4000)
        ]
    )
    low = (bounds < true).sum()
    assert low <= 15  # 4 expected at most; more by a chance of 1e-5
    assert np.median(bounds) <= every[-population // 1000]


@given(st.integers(FEW, 3000), st.integers(0, 2**32 - 1), st.integers(0, 10**6))
def test_bounds_never_lie_below_the_samples_own_percentile(n, seed, more):
    draws = np.random.default_rng(seed).exponential(1, n)
    bound = percentile_bound(draws, n + more)
    assert bound >= np.quantile(draws, 0.99, method="lower")
