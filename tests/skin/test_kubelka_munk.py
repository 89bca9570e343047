"""One layer and two: against hundreds of digits, and against their own laws."""

import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mpmath import mp, mpf
from numpy.testing import assert_allclose, assert_array_equal
from oracles import kubelka_munk as oracle
from oracles.agreement import assert_oracle
from strategies import LARGEST, SMALLEST, coefficients, depths, drawn
from tolerances import EPS, ORACLE, ROUNDING

from skinviz import ArgumentError, kubelka_munk_layer
from skinviz.skin.kubelka_munk import (
    layer_fluxes,
    layer_slopes,
    over_backing,
    stack_reflectance,
    stack_slopes,
)

pytestmark = pytest.mark.usefixtures("strict_floats")

BACKINGS = (0.0, 0.5, 1.0)
INF = np.inf


def points(n, seed):
    """Return K, S, D (n,) of the declared range."""
    rng = np.random.default_rng(seed)
    return drawn(rng, n), drawn(rng, n), drawn(rng, n, infinite=True)


def slope_exists(K, S, D):
    """Return where R and T have a finite slope and something to be a slope of."""
    return ~((K == 0) & (np.isinf(D) | (S == 0)))


# --- one layer -----------------------------------------------------------------


def test_layer_equals_the_oracle_on_a_grid():
    ladder = [0.0, *10.0 ** np.arange(-16, 17, 4), INF]
    K, S, D = (x.ravel() for x in np.meshgrid(ladder[:-1], ladder[:-1], ladder))
    R, T, _, _ = oracle.layers(K, S, D)
    actual = kubelka_munk_layer(K, S, D)
    assert_oracle(actual[0], R)
    assert_oracle(actual[1], T)


def test_layer_and_its_complements_equal_the_oracle_at_random():
    K, S, D = points(2000, seed=1)
    fluxes = layer_fluxes(K, S, D)
    for actual, expected in zip(fluxes, oracle.layers(K, S, D), strict=True):
        assert_oracle(actual, expected)


@given(S=coefficients, D=depths)
def test_without_absorption_light_is_only_shared(S, D):
    R, T = kubelka_munk_layer(0.0, S, D)
    if S > 0 and D == INF:
        assert (R, T) == (1, 0)
    elif S == 0:
        assert (R, T) == (0, 1)
    else:
        assert_allclose([R, T], [S * D / (1 + S * D), 1 / (1 + S * D)], rtol=4 * EPS)


@given(K=coefficients, D=depths)
def test_without_scattering_bouguers_law_holds(K, D):
    R, T = kubelka_munk_layer(K, 0.0, D)
    # A float product K·D already carries eps·K·D into the exponential.
    depth = 0.0 if K == 0 else K * D
    with np.errstate(under="ignore"):
        expected = np.exp(-depth)
    assert R == 0
    assert_oracle(T, expected, rtol=4 * EPS * max(1, min(depth, 750)))


@given(K=coefficients, S=coefficients)
def test_a_layer_of_no_depth_does_nothing(K, S):
    assert kubelka_munk_layer(K, S, 0.0) == (0, 1)


@given(K=coefficients, S=coefficients.filter(bool))
def test_endless_layer_reflects_r_infinity(K, S):
    R, T = kubelka_munk_layer(K, S, INF)
    with mp.workdps(60):
        ratio = mpf(K) / mpf(S)
        expected = 1 / (1 + ratio + mp.sqrt(ratio * ratio + 2 * ratio))
    assert_allclose(R, float(expected), rtol=4 * EPS)
    assert T == 0


@given(D=depths)
def test_nothing_in_the_layer_lets_all_light_through(D):
    assert kubelka_munk_layer(0.0, 0.0, D) == (0, 1)


@given(K=coefficients, S=coefficients, D=depths)
@example(K=0.0, S=LARGEST, D=LARGEST)
def test_fluxes_conserve_energy(K, S, D):
    R, T, U, A = layer_fluxes(*(np.array(x) for x in (K, S, D)))
    assert min(R, T, U, A) >= 0
    assert R + T <= 1 + 4 * EPS
    assert_allclose(R + U, 1, rtol=4 * EPS)
    assert_allclose(R + T + A, 1, rtol=4 * EPS)


@given(K=coefficients, S=coefficients, D=depths, factor=st.floats(1, 10))
@example(K=0.0, S=1.0, D=INF, factor=2.0)
def test_more_absorption_never_brightens(K, S, D, factor):
    more = min(max(K, SMALLEST) * factor, LARGEST)
    R, T = kubelka_munk_layer([K, more], S, D)
    # Two roundings may cross where the difference is below them.
    assert R[1] <= R[0] * (1 + 4 * EPS)
    assert T[1] <= T[0] * (1 + ROUNDING)


@given(S=coefficients, D=depths, K=coefficients, factor=st.floats(1, 10))
def test_more_scattering_never_darkens_over_black(K, S, D, factor):
    more = min(max(S, SMALLEST) * factor, LARGEST)
    R, _ = kubelka_munk_layer(K, [S, more], D)
    assert R[1] >= R[0] * (1 - 4 * EPS)


middling = st.floats(-8, 8).map(lambda e: 10.0**e)


@given(
    K=middling | st.just(0.0),
    S=middling | st.just(0.0),
    D=middling,
    c=st.sampled_from([2.0**-20, 0.5, 4.0, 2.0**20]),
)
def test_only_the_products_with_depth_matter(K, S, D, c):
    # A power of two, so that the arguments themselves are scaled exactly.
    scaled = kubelka_munk_layer(c * K, c * S, D / c)
    assert_oracle(scaled, kubelka_munk_layer(K, S, D), rtol=ROUNDING)


@given(K=middling | st.just(0.0), S=middling | st.just(0.0), D=middling)
@example(K=0.0, S=0.0, D=1.0)
def test_layers_of_one_matter_add_up(K, S, D):
    whole = kubelka_munk_layer(K, S, 4 * D)
    first, second = (
        layer_fluxes(*(np.array(x) for x in (K, S, depth))) for depth in (D, 3 * D)
    )
    # 1 − R₁R₂ from the complements, which keep their digits where R is near 1.
    gap = first.complement + first.reflectance * second.complement
    with np.errstate(under="ignore"):
        between = first.transmittance / gap
        R = first.reflectance + first.transmittance * between * second.reflectance
        T = between * second.transmittance
    assert_oracle([R, T], whole)


def test_the_printed_transmittance_fails_both_limits():
    clear = kubelka_munk_layer(0.1, 3.0, SMALLEST)[1]
    white_R, white_T = kubelka_munk_layer(0.0, 3.0, 1.0)
    with mp.workdps(oracle.DIGITS):
        printed_clear = oracle.printed_transmittance(0.1, 3.0, SMALLEST)
        printed_white = oracle.printed_transmittance(mpf("1e-40"), 3.0, 1.0)
    assert_allclose(clear, 1, rtol=4 * EPS)
    assert float(printed_clear) < 1e-14
    assert_allclose(white_R + white_T, 1, rtol=4 * EPS)
    assert abs(float(printed_white) + white_R - 1) > 0.2


@pytest.mark.parametrize(
    ("K", "S", "D"), [(0.2, 3.0, 1.5), (5.0, 0.1, 2.0), (0, 2.0, 0.7)]
)
def test_layer_solves_the_equations_of_two_fluxes(K, S, D):
    with mp.workdps(50):
        expected = [float(x) for x in oracle.layer_by_two_fluxes(K, S, D)]
    assert_allclose(kubelka_munk_layer(K, S, D), expected, rtol=ORACLE)


# --- its derivatives -----------------------------------------------------------


def test_layer_slopes_equal_the_oracle():
    K, S, D = points(900, seed=2)
    exists = slope_exists(K, S, D)
    K, S, D = K[exists], S[exists], D[exists]
    assert (K == 0).any()
    assert np.isinf(D).any()
    actual, expected = layer_slopes(K, S, D), oracle.layers_slopes(K, S, D)
    assert_oracle(actual.reflectance, expected[0])
    assert_oracle(actual.transmittance, expected[1])


@pytest.mark.parametrize("x", [0.9999999, 1.0, 1.0000001])
def test_layer_slopes_agree_where_series_and_formula_meet(x):
    K, S = np.array([0.3]), np.array([0.4])
    D = x / (2 * np.sqrt(K * (K + 2 * S)))
    expected = oracle.layers_slopes(K, S, D)
    assert_allclose(layer_slopes(K, S, D), expected, rtol=ORACLE)


def test_an_endless_layer_falls_infinitely_fast_at_no_absorption():
    slopes = layer_slopes(*(np.array([x]) for x in (0.0, 2.0, INF)))
    assert_array_equal(slopes.reflectance, [-INF])
    assert_array_equal(slopes.transmittance, [0])


def test_slopes_of_matter_are_right_beside_an_endless_empty_layer():
    K, S, D = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.0]), np.array([INF] * 3)
    D[2] = 2.0
    slopes = layer_slopes(K, S, D)
    assert_array_equal(slopes.reflectance, [0, 0, 0])
    assert_array_equal(slopes.transmittance[1:], [0, -2])


# --- two layers ----------------------------------------------------------------


@pytest.mark.parametrize("backing", BACKINGS)
def test_layer_over_backing_equals_the_oracle(backing):
    K, S, D = points(600, seed=3)
    base, complement = over_backing(layer_fluxes(K, S, D), backing)
    with mp.workdps(oracle.DIGITS):
        exact = [
            oracle.over(oracle.layer(*args), mpf(backing))
            for args in zip(K, S, D, strict=True)
        ]
        # Nothing is lost over a perfect backing without absorption.
        lost = (K > 0) | ((backing < 1) & ~(np.isinf(D) & (S > 0)))
        expected = np.array([float(x) for x in exact])
        remainder = np.array(
            [float((1 - x) * int(f)) for x, f in zip(exact, lost, strict=True)]
        )
    assert_oracle(base, expected)
    assert_oracle(complement, remainder)


def stacks(n, seed):
    """Return K, S, D, each (top, bottom) of (n,)."""
    first, second = points(n, seed), points(n, seed + 100)
    return tuple(zip(first, second, strict=True))


@pytest.mark.parametrize("backing", BACKINGS)
def test_stack_equals_the_oracle(backing):
    K, S, D = stacks(600, seed=4)
    top, bottom = (layer_fluxes(*args) for args in zip(K, S, D, strict=True))
    with mp.workdps(oracle.DIGITS):
        expected = [
            oracle.stack(k, s, d, backing)
            for k, s, d in zip(*(zip(*x, strict=True) for x in (K, S, D)), strict=True)
        ]
    expected = np.array([float(x) for x in expected])
    assert_oracle(stack_reflectance(top, bottom, backing), expected)


@pytest.mark.parametrize("backing", BACKINGS)
def test_stack_slopes_equal_the_oracle(backing):
    K, S, D = stacks(160, seed=5)
    for i in range(K[0].size):
        k, s, d = ((float(x[0][i]), float(x[1][i])) for x in (K, S, D))
        if not all(slope_exists(*args) for args in zip(k, s, d, strict=True)):
            continue
        actual = stack_slopes(
            tuple(np.array([x]) for x in k),
            tuple(np.array([x]) for x in s),
            d,
            backing,
        )
        by_top = oracle.slope(
            lambda x, k=k, s=s, d=d: oracle.stack((x, k[1]), s, d, backing), k[0]
        )
        by_bottom = oracle.slope(
            lambda x, k=k, s=s, d=d: oracle.stack((k[0], x), s, d, backing), k[1]
        )
        assert_oracle(actual.top, np.array([float(by_top)]))
        assert_oracle(actual.bottom, np.array([float(by_bottom)]))


def test_nothing_under_an_opaque_layer_changes_what_is_seen():
    # The endless dermis has an infinite slope at K = 0; no light comes to it.
    K = (np.array([1e12]), np.array([0.0]))
    S = (np.array([1.0]), np.array([3.0]))
    slopes = stack_slopes(K, S, (1.0, INF), 1.0)
    assert_array_equal(slopes.bottom, [0])


@given(K=coefficients, S=coefficients, D=depths, backing=st.sampled_from(BACKINGS))
def test_a_layer_of_no_depth_on_top_is_not_seen(K, S, D, backing):
    bottom = layer_fluxes(*(np.array(x) for x in (K, S, D)))
    nothing = layer_fluxes(np.array(1.0), np.array(1.0), np.array(0.0))
    alone, _ = over_backing(bottom, backing)
    assert stack_reflectance(nothing, bottom, backing) == alone


@given(K=coefficients, S=coefficients, D=depths)
def test_black_backing_leaves_the_layers_own_reflectance(K, S, D):
    layer = layer_fluxes(*(np.array(x) for x in (K, S, D)))
    assert over_backing(layer, 0.0)[0] == layer.reflectance


# --- arguments -----------------------------------------------------------------


def test_arguments_broadcast():
    R, T = kubelka_munk_layer(np.ones((2, 1)), [1.0, 2.0, 3.0], 0.5)
    assert R.shape == T.shape == (2, 3)
    assert_array_equal(R[0], R[1])


@pytest.mark.parametrize("name", ["K", "S", "thickness"])
@pytest.mark.parametrize("value", [-1.0, 1e-17, 1.1e16, np.nan, -INF])
def test_out_of_range_is_refused_by_name(name, value):
    arguments = {"K": 1.0, "S": 1.0, "thickness": 1.0, name: [1.0, value]}
    with pytest.raises(
        ArgumentError, match=f"^{name} must be .* got {re.escape(f'{value:g}')}$"
    ):
        kubelka_munk_layer(**arguments)


@pytest.mark.parametrize("name", ["K", "S"])
def test_only_thickness_may_be_infinite(name):
    arguments = {"K": 1.0, "S": 1.0, "thickness": INF, name: INF}
    with pytest.raises(ArgumentError, match=f"^{name} must be"):
        kubelka_munk_layer(**arguments)


def test_shapes_that_do_not_broadcast_are_refused():
    with pytest.raises(ArgumentError, match=r"\(2,\).*\(3,\).*do not broadcast"):
        kubelka_munk_layer([1.0, 2.0], [1.0, 2.0, 3.0], 1.0)
