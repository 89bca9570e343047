"""Polarisers: against Fresnel's law elsewhere, Stokes vectors, and each other."""

import numpy as np
import pytest
from benches import NM, bench, skin, subject
from numpy.testing import assert_allclose

from skinviz.errors import ArgumentError
from skinviz.instruments.arrangement import STATES, Arrangement
from skinviz.instruments.polarisation import (
    Polarisers,
    Shared,
    fresnel_amplitudes,
    leaving_asymmetry,
    separate,
    weights,
)
from skinviz.surface.fresnel import fresnel_reflectance

ANGLES = np.deg2rad([0, 10, 30, 45, 60, 80])


@pytest.mark.parametrize("n", [1.0, 1.4, 1.55])
def test_amplitudes_are_those_of_unpolarised_reflectance(n):
    for angle in ANGLES:
        s, p = fresnel_amplitudes(angle, n)
        expected = fresnel_reflectance(np.cos(angle), n)
        assert_allclose((s * s + p * p) / 2, expected, rtol=1e-12, atol=1e-15)


def test_p_vanishes_at_brewsters_angle():
    assert abs(fresnel_amplitudes(np.arctan(1.4), 1.4)[1]) < 1e-15


def test_the_asymmetry_at_the_papers_angle():
    assert leaving_asymmetry(np.pi / 3, 1.4) == pytest.approx(0.862, abs=5e-4)
    assert leaving_asymmetry(np.pi / 3, 1.55) == pytest.approx(0.807, abs=5e-4)
    assert leaving_asymmetry(0.0, 1.4) == pytest.approx(1)


def test_no_polariser_weighs_both_parts_alike():
    for illumination in (-0.5, 0.0, 0.8, 1.4):
        found = weights("open", illumination, 1.0, Polarisers())
        assert_allclose(found, (1, 1), rtol=1e-12)


def test_s_and_p_together_are_no_polariser():
    s, p = (weights(state, 0.8, 1.0, Polarisers()) for state in "sp")
    assert_allclose(np.add(s, p) / 2, (1, 1), rtol=1e-12)


def test_crossed_polarisers_stop_a_mirror_at_normal_incidence():
    diffuse, specular = weights("crossed", 0.0, 0.0, Polarisers())
    assert diffuse == pytest.approx(1)
    assert abs(specular) < 1e-30
    assert weights("parallel", 0.0, 0.0, Polarisers()) == pytest.approx((1, 2))
    leaky = weights("crossed", 0.0, 0.0, Polarisers(leakage=0.01))
    assert leaky[1] == pytest.approx(2 * 2 * 0.01 * 0.99)


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize(
    "angles", [(45.0, 0.0), (0.0, 60.0), (75.0, 60.0), (-30.0, 60.0)]
)
@pytest.mark.parametrize("leakage", [0.0, 0.01])
def test_weights_are_those_of_stokes_vectors(state, angles, leakage):
    given = Polarisers(leakage=leakage)
    lobe = 0.07
    factors = {}
    for scale in (0.0, 1.0):
        on = bench(
            subject=subject(
                lambda light, _, k=scale: k * lobe * np.cos(np.deg2rad(light))
            ),
            leakage=leakage,
            ambient=0.0,
            grating=0.03,
        )
        seen = {}
        for target in ("white", "sample"):
            on.arrange(Arrangement(target, True, *angles, state))
            seen[target] = on.radiance(NM)
        factors[scale] = seen["sample"] / seen["white"] * on.tile[1]
    diffuse, specular = weights(state, *np.deg2rad(angles), given)
    # The grating's preference cancels but for the polarisation behind the analyser.
    tolerance = 0.02 if STATES[state][1] is None else 2e-3
    assert_allclose(factors[0.0], diffuse * skin(), rtol=tolerance)
    apart = factors[1.0] - factors[0.0]
    assert_allclose(apart, specular * lobe, rtol=0.03, atol=1e-6)


@pytest.mark.parametrize("states", [("s", "p"), ("open", "s", "p")])
def test_parts_are_told_apart_exactly(states):
    given = Polarisers(leakage=0.002)
    body, mirror = np.array([0.1, 0.4]), np.array([0.03, 0.0])
    at = {"illumination": 0.9, "viewing": np.pi / 3, "given": given}
    rows = np.array([weights(s, 0.9, np.pi / 3, given) for s in states])
    factors = rows @ np.array([body, mirror])
    found = separate(states, factors, np.full(factors.shape, 1e-3), **at)
    assert_allclose(found.diffuse, body, rtol=1e-12)
    assert_allclose(found.specular, mirror, rtol=1e-12, atol=1e-15)
    moved = separate(
        states, factors, np.full(factors.shape, 1e-3), **at, shared=Shared(0.02)
    )
    assert (moved.u_specular > found.u_specular).all()
    assert_allclose(found.u_shared, 0, atol=1e-15)
    scaled = separate(
        states, factors, np.full(factors.shape, 1e-3), **at, shared=Shared(scale=0.01)
    )
    assert_allclose(scaled.u_shared, 0.01 * np.abs(found.specular), atol=1e-15)
    bent = tuple(0.01 for _ in states)
    each = separate(
        states, factors, np.full(factors.shape, 1e-3), **at, shared=Shared(0, bent)
    )
    # In the band without gloss it is the body's share that leaks into the lobe.
    assert 1e-3 < each.u_shared[1] / body[1] < 1e-2


def test_uncertainties_are_those_of_many_trials():
    rng = np.random.default_rng(1)
    given = Polarisers()
    rows = np.array([weights(s, 0.7, np.pi / 3, given) for s in "sp"])
    clean = rows @ np.array([0.3, 0.05])
    u = np.array([0.002, 0.004])
    noisy = clean[:, None] + rng.normal(0, 1, (2, 20_000)) * u[:, None]
    found = separate(
        "sp", noisy, np.broadcast_to(u[:, None], noisy.shape),
        illumination=0.7, viewing=np.pi / 3, given=given,
    )  # fmt: skip
    assert found.specular.std() == pytest.approx(found.u_specular[0], rel=0.03)
    assert found.diffuse.std() == pytest.approx(found.u_diffuse[0], rel=0.03)


def test_a_difference_with_k_of_1_is_off_by_what_the_docs_say():
    given = Polarisers()
    rows = np.array([weights(s, -0.5, np.pi / 3, given) for s in "sp"])
    s, p = rows @ np.array([1.0, 0.0])
    # The specular part that the plain difference finds in diffuse light alone.
    assert (s - p) / 2 == pytest.approx(-0.074, abs=2e-3)


@pytest.mark.parametrize(
    ("states", "illumination"), [(("s",), 0.7), (("parallel", "crossed"), 0.86)]
)
def test_states_that_tell_nothing_apart_are_refused(states, illumination):
    one = np.ones((len(states), 3))
    with pytest.raises(ArgumentError, match="tell surface and body apart"):
        separate(
            states, one, one, illumination=illumination, viewing=np.pi / 3,
            given=Polarisers(),
        )  # fmt: skip


def test_polarisers_that_there_are_not_are_refused():
    with pytest.raises(ArgumentError, match="crossed"):
        weights("cross", 0, 0, Polarisers())
    with pytest.raises(ArgumentError, match="leakage"):
        Polarisers(leakage=0.5)
