"""One layer and two: against hundreds of digits, and against their own laws."""

import re

import numpy as np
import pytest
from compiled_optics import layers, stacks
from hypothesis import example, given
from hypothesis import strategies as st
from mpmath import mp, mpf
from numpy.testing import assert_allclose, assert_array_equal
from oracles import kubelka_munk as oracle
from oracles.agreement import assert_oracle
from strategies import LARGEST, SMALLEST, coefficients, depths, drawn
from tolerances import EPS, ORACLE, ROUNDING

from skinviz import ArgumentError, kubelka_munk_layer

pytestmark = pytest.mark.usefixtures("strict_floats")

BACKINGS = (0.0, 0.5, 1.0)
INF = np.inf
NO_ABSORPTION = 1e-48
"""What 1 − R and 1 − R − T may be where they are 0: κ is 1e-80, D up to 1e16."""


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
    fluxes, expected = layers(K, S, D)[0], oracle.layers(K, S, D)
    none = (K == 0) & (expected == 0)
    assert (np.abs(fluxes[none]) < NO_ABSORPTION).all()
    assert_oracle(fluxes[~none], expected[~none])


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
    R, T, U, A = layers(K, S, D)[0][:, 0]
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
    (R1, R2), (T1, T2), (U1, U2), _ = layers(K, S, [D, 3 * D])[0]
    # 1 − R₁R₂ from the complements, which keep their digits where R is near 1.
    with np.errstate(under="ignore"):
        between = T1 / (U1 + R1 * U2)
        assert_oracle([R1 + T1 * between * R2, between * T2], whole)


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
    K, S, D = points(700, seed=2)
    exists = slope_exists(K, S, D)
    K, S, D = K[exists], S[exists], D[exists]
    assert (K == 0).any()
    assert np.isinf(D).any()
    assert_oracle(layers(K, S, D)[1], oracle.layers_slopes(K, S, D))


@pytest.mark.parametrize("y", [0.2499999, 0.25, 0.2500001, 708.3, 708.38])
def test_layer_slopes_agree_where_formulas_meet(y):
    K, S = np.array([0.3]), np.array([0.4])
    D = y / np.sqrt(K * (K + 2 * S))
    assert_oracle(layers(K, S, D)[1], oracle.layers_slopes(K, S, D))


def test_an_endless_layer_falls_beyond_all_bounds_at_no_absorption():
    _, (by_R, by_T) = layers(0.0, 2.0, INF)
    assert -INF < by_R < -1e70
    assert by_T == 0


# --- two layers ----------------------------------------------------------------


def pairs(n, seed):
    """Return K, S, D (2, n) of the declared range, top and bottom."""
    return np.stack([points(n, seed), points(n, seed + 100)], axis=1)


@pytest.mark.parametrize("backing", BACKINGS)
def test_stack_equals_the_oracle(backing):
    K, S, D = pairs(600, seed=4)
    with mp.workdps(oracle.DIGITS):
        expected = [
            float(oracle.stack(k, s, d, backing))
            for k, s, d in zip(K.T, S.T, D.T, strict=True)
        ]
    assert_oracle(stacks(K, S, D, backing)[0], expected)


@pytest.mark.parametrize("backing", BACKINGS)
def test_stack_slopes_equal_the_oracle(backing):
    K, S, D = pairs(120, seed=5)
    exists = slope_exists(K, S, D).all(axis=0)
    K, S, D = K[:, exists], S[:, exists], D[:, exists]
    actual, expected = (
        stacks(K, S, D, backing)[1],
        oracle.stacks_slopes(K, S, D, backing),
    )
    assert_oracle(actual[:2], expected[:2])
    # By thickness light is won by scattering and lost by absorption; of the
    # difference only as many digits can be right as it shares with the two.
    finite = (D > 0) & (D < INF)
    with np.errstate(under="ignore"):
        parts = (np.abs(expected[:2]) * [K, S]).sum(axis=0)[finite] / D[finite]
        gap = np.abs(actual[2] - expected[2])[finite]
        assert (gap <= ORACLE * parts + NO_ABSORPTION).all()
    assert_array_equal(actual[2][D == INF], 0)


@given(K=middling, S=middling, D=middling, backing=st.sampled_from(BACKINGS))
def test_slopes_obey_the_scaling_of_matter_and_depth(K, S, D, backing):
    # R_b depends on K D and S D alone: K ∂K + S ∂S = D ∂D of either layer (Euler).
    _, slopes = stacks([[K], [S]], [[S], [K]], [[D], [D / 3]], backing)
    matter = np.array([[[K], [S]], [[S], [K]], [[-D], [-D / 3]]])
    with np.errstate(under="ignore"):
        terms = matter * slopes
        assert np.abs(terms.sum(axis=0)).max() <= ORACLE * np.abs(terms).max()


def test_nothing_under_an_opaque_layer_changes_what_is_seen():
    # The endless dermis falls vertically at K = 0; no light comes to it.
    _, slopes = stacks([[1e12], [0.0]], [[1.0], [3.0]], [[1.0], [INF]], 1.0)
    assert_array_equal(slopes[:, 1], 0)


@given(K=coefficients, S=coefficients, D=depths, backing=st.sampled_from(BACKINGS))
def test_a_layer_of_no_depth_on_top_is_not_seen(K, S, D, backing):
    with_it, _ = stacks([[1.0], [K]], [[1.0], [S]], [[0.0], [D]], backing)
    on_it, _ = stacks([[K], [1.0]], [[S], [1.0]], [[D], [0.0]], backing)
    assert_allclose(with_it, on_it, rtol=4 * EPS)


@given(K=coefficients, S=coefficients, D=depths)
def test_black_backing_leaves_the_layers_own_reflectance(K, S, D):
    body, _ = stacks([[K], [0.0]], [[S], [0.0]], [[D], [0.0]], 0.0)
    assert_allclose(body, layers(K, S, D)[0][0], rtol=4 * EPS)


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
