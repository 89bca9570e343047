"""Each rule against the assumption it is made from."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from numpy.testing import assert_allclose
from oracles import transport
from scipy.linalg import expm
from tolerances import ROUNDING

from skinviz.errors import ArgumentError
from skinviz.skin.kubelka_munk import kubelka_munk_layer
from skinviz.skin.scattering_rules import (
    SCATTERING_RULES,
    gate,
    klier,
    meador_weaver,
    star,
    toon,
)

TISSUES = [(1e-3, 5.0, 1.3), (0.3, 5.0, 1.3), (4.0, 8.0, 0.1), (10.0, 5.0, 0.3)]
"""μ_a, μ_s′ [mm⁻¹] and thickness [mm], from nearly white to nearly black."""

COEFFICIENT = st.floats(1e-6, 1e3)


def slab(slope, outwards):
    """R and T of fluxes y' = M y, from the two boundary rows of each side.

    ``outwards`` holds the rows that give the downward and the upward flux of y.
    """
    down, up = outwards
    through = expm(slope)
    # Rows: downward flux at the top is 1, upward flux at the bottom is 0.
    state = np.linalg.solve(np.array([down, up @ through]), [1.0, 0.0])
    return up @ state, down @ through @ state


@pytest.mark.parametrize("tissue", TISSUES)
def test_star_is_diffusion_with_marshaks_boundary(tissue):
    a, s, depth = tissue
    # (φ, J)' with φ' = −3 (μ_a + μ_s′) J and J' = −μ_a φ; fluxes φ/4 ± J/2.
    slope = np.array([[0, -3 * (a + s)], [-a, 0]]) * depth
    fluxes = np.array([0.25, 0.5]), np.array([0.25, -0.5])
    assert_allclose(
        kubelka_munk_layer(*star(a, s), depth), slab(slope, fluxes), rtol=1e-9
    )


@pytest.mark.parametrize("tissue", TISSUES)
def test_meador_weaver_is_the_first_discrete_ordinate(tissue):
    a, s, depth = tissue
    g = 0.6
    nu, mu_s = 1 / np.sqrt(3), s / (1 - g)
    forward, backward = mu_s * (1 + 3 * g * nu**2) / 2, mu_s * (1 - 3 * g * nu**2) / 2
    loss = a + mu_s - forward
    slope = np.array([[-loss, backward], [-backward, loss]]) * depth / nu
    found = slab(slope, (np.array([1.0, 0.0]), np.array([0.0, 1.0])))
    rule = meador_weaver(a, s)
    assert_allclose(kubelka_munk_layer(*rule, depth), found, rtol=1e-9)


def test_toon_is_exact_for_thin_layers_in_diffuse_light():
    thin, a, s = 1e-5, 2.0, 7.0
    R, T = (
        transport.total(m, points=32)
        for m in transport.layer(a, s, 0.0, thin, points=32)
    )
    K, S = toon(a, s)
    # The thin limit is approached as thin · log(thin): grazing light never sees it.
    assert_allclose(R.diffuse, S * thin, rtol=2e-3)
    assert_allclose(1 - R.diffuse - T.diffuse, K * thin, rtol=2e-3)


def test_gate_is_star_without_absorption():
    s = np.array([0.1, 5.0, 20.0])
    assert_allclose(gate(0.0, s), star(0.0, s), rtol=0)
    assert_allclose(gate(1e-9, s).S, star(1e-9, s).S, rtol=1e-8)


@pytest.mark.parametrize("ratio", ["1e-14", "1e-6", "0.01", "0.4", "1.5", "30", "200"])
def test_klier_has_the_asymptotic_radiance(ratio):
    with mp.workdps(250):  # 1 − k is e^−400 at the last ratio
        x = mpf(ratio)
        albedo = 1 / (1 + x)
        start = mp.sqrt(3 * x + x * x)
        y = mp.findroot(lambda y: albedo * y / mp.tanh(y) - 1, start)
        k = mp.tanh(y)
        down, up = -k - mp.log(1 - k), k - mp.log(1 + k)
        R = up / down
        expected = (1 + x) * k * (1 - R) / (1 + R), (1 + x) * k * 2 * R / (1 - R * R)
    assert_allclose(
        klier(float(ratio), 1.0), [float(e) for e in expected], rtol=ROUNDING
    )


@pytest.mark.parametrize(("a", "s"), [(0.05, 5.0), (1.0, 5.0), (4.0, 5.0)])
def test_klier_attenuates_as_transport_does_deep_inside(a, s):
    depth = 8.0 if a < 1 else 3.0  # till what the far side sends back is gone
    (_, T1), (_, T2) = (transport.layer(a, s, 0.0, d) for d in (depth, depth + 0.5))
    K, S = klier(a, s)
    seen = np.log(transport.total(T1).diffuse / transport.total(T2).diffuse) / 0.5
    assert_allclose(seen, np.sqrt(K * (K + 2 * S)), rtol=2e-3)


def test_klier_is_gate_in_white_matter_and_bouguer_in_clear():
    assert_allclose(klier(1e-9, 5.0), gate(1e-9, 5.0), rtol=1e-8)
    assert_allclose(klier([0.0, 0.0, 3.0], [5.0, 0.0, 0.0]), [[0, 0, 3], [3.75, 0, 0]])


@given(COEFFICIENT, COEFFICIENT, COEFFICIENT)
def test_rules_have_units(a, s, unit):
    """A change of the unit of length changes K and S alike."""
    for name, rule in SCATTERING_RULES.items():
        if name == "star" and a > 2.9 * s:
            continue
        assert_allclose(
            rule(a * unit, s * unit), np.multiply(rule(a, s), unit), rtol=1e-11
        )


@given(COEFFICIENT, COEFFICIENT)
def test_klier_lies_between_its_limits(a, s):
    K, S = klier(a, s)
    assert a * (1 - ROUNDING) <= K <= 2 * a * (1 + ROUNDING)
    assert (1 - np.log(2)) * s * (1 - ROUNDING) <= S <= 0.75 * s * (1 + ROUNDING)


def test_klier_is_continuous_where_its_form_changes():
    """At x = 1e±15 and where the series ends."""
    for x in (1e-15, 1e15, 0.0132977, 0.313035):
        below, above = (klier(x * f, 1.0) for f in (1 - 1e-6, 1 + 1e-6))
        assert_allclose(below.S, above.S, rtol=1e-6)
        assert_allclose(below.K, above.K, rtol=3e-6)


@pytest.mark.parametrize("rule", SCATTERING_RULES.values())
def test_rules_broadcast_and_keep_the_shape(rule):
    K, S = rule(np.full((3, 1), 0.2), np.full(4, 5.0))
    assert K.shape == S.shape == (3, 4)
    assert (K >= 0).all()
    assert (S >= 0).all()
    assert rule(0.2, 5).K.shape == ()


@pytest.mark.parametrize("rule", SCATTERING_RULES.values())
@pytest.mark.parametrize(
    ("a", "s", "said"),
    [
        (-0.1, 5, "mu_a must be finite and ≥ 0 mm⁻¹; got -0.1"),
        (np.nan, 5, "mu_a must be finite"),
        (0.1, [5, np.inf], "mu_s_prime must be finite"),
        ([1, 2, 3], [1, 2], r"mu_a \(3,\) and mu_s_prime \(2,\) do not broadcast"),
        ("dark", 5, "mu_a must be numbers"),
    ],
)
def test_rules_refuse_what_is_no_coefficient(rule, a, s, said):
    with pytest.raises(ArgumentError, match=said):
        rule(a, s)


def test_star_says_where_it_leaves_its_range():
    with pytest.raises(ArgumentError, match=r"at \(1,\) mu_a is 16 .* another rule"):
        star([1.0, 16.0], 5.0)
    assert star(15.0, 5.0).S == 0
