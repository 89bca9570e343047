"""Torrance and Sparrow's surface: reciprocity, energy, and eq. (10) to the letter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from oracles import torrance_sparrow as oracle
from strategies import log_uniform
from surface_kinds import HALF_PI, UP, azimuths, direction, rotation, upwards
from tolerances import KINKED_QUADRATURE, ORACLE, QUADRATURE

from skinviz import ArgumentError, TorranceSparrow
from skinviz.surface import fresnel_reflectance, physical_beta, specular_albedo
from skinviz.surface.torrance_sparrow import MASKINGS

pytestmark = pytest.mark.usefixtures("strict_floats")

gammas = log_uniform(1e-4, HALF_PI)
indices = st.floats(1, 3)


# --- values --------------------------------------------------------------------


@given(light=upwards, view=upwards, gamma=log_uniform(0.02, HALF_PI), n=indices)
@pytest.mark.parametrize("masking", MASKINGS)
def test_value_is_eq_10_to_the_letter(masking, light, view, gamma, n):
    surface = TorranceSparrow(gamma, n, 1.0, masking)
    L, V = direction(*light), direction(*view)
    expected = oracle.evaluate(
        UP, L, V, gamma=gamma, n=n, beta=surface.beta, masked=masking == "v-cavity"
    )
    # D magnifies the rounding of its angle by (φ/γ)²; V·H and R_p = 0 theirs.
    assert_allclose(surface.evaluate(UP, L, V), expected, rtol=1e-10, atol=1e-200)


@pytest.mark.parametrize("gamma", [1e-4, 1e-3, 0.02])
def test_narrow_lobes_keep_their_digits(gamma):
    surface = TorranceSparrow(gamma, 1.4)
    light = direction(0.7)
    for off in np.array([0.0, 0.3, 1.0, 3.0]) * gamma:
        view = direction(0.7 + 2 * off, np.pi)
        expected = oracle.evaluate(
            UP, light, view, gamma=gamma, n=1.4, beta=surface.beta, masked=True
        )
        # An angle of 1e-4 is known to 1e-16 of the vectors' length.
        assert_allclose(surface.evaluate(UP, light, view), expected, rtol=1e-10)


@pytest.mark.parametrize("gamma", [1e-4, 0.02, 0.27, HALF_PI])
def test_facets_are_half_as_many_at_the_half_width(gamma):
    surface, along = TorranceSparrow(gamma), direction(gamma)
    assert_allclose(surface.parts(UP, along, along)["distribution"], 0.5, rtol=1e-10)
    assert surface.parts(UP, UP, UP)["distribution"] == 1


def test_without_contrast_nothing_is_reflected():
    views = np.stack([direction(a, b) for a in (0, 0.5, 1.5) for b in (0, 2, 4)])
    assert_array_equal(TorranceSparrow(0.3, 1.0).evaluate(UP, UP, views), 0)


def test_switched_off_it_is_dark():
    off = TorranceSparrow(specular_scale=0.0)
    assert off.beta == 0
    assert off.evaluate(UP, direction(0.5), direction(0.5, np.pi)) == 0


def test_masking_only_takes_light_away():
    light = direction(1.2)
    angles = np.deg2rad(np.arange(0, 90, 3))
    views = np.stack([direction(a, b) for a in angles for b in (0.0, 1.0, np.pi)])
    masked, printed = (
        TorranceSparrow(masking=name).evaluate(UP, light, views) for name in MASKINGS
    )
    assert (masked <= printed).all()
    assert (masked < 0.5 * printed).any()
    # Near the normal facets hide nothing of one another.
    near = direction(0.1, np.pi)
    both = [TorranceSparrow(masking=m).evaluate(UP, near, UP) for m in MASKINGS]
    assert both[0] == both[1]


# --- symmetries ----------------------------------------------------------------


@given(
    light=upwards,
    view=upwards,
    axis=upwards,
    angle=azimuths,
    gamma=log_uniform(0.02, HALF_PI),
)
def test_turning_everything_changes_nothing(light, view, axis, angle, gamma):
    surface = TorranceSparrow(gamma)
    vectors = [UP, direction(*light), direction(*view)]
    turn = rotation(direction(*axis), angle)
    here = surface.evaluate(*vectors)
    # (φ/γ)² at 1.6/0.02 magnifies rounding some 1e4 times; grazing as much.
    assert_allclose(
        surface.evaluate(*(turn @ v for v in vectors)), here, rtol=1e-8, atol=1e-200
    )


# --- energy --------------------------------------------------------------------


@given(gamma=gammas)
def test_physical_beta_equals_adaptive_quadrature(gamma):
    assert_allclose(physical_beta(gamma), oracle.physical_beta(gamma), rtol=QUADRATURE)


def test_narrow_lobes_have_the_limit_of_a_plane_gaussian():
    # For small γ the hemisphere is a plane: ∫ D dω = π γ²/ln 2.
    gamma = 1e-4
    assert_allclose(physical_beta(gamma), np.log(2) / (4 * gamma**2), rtol=1e-7)


def mirror(surface):
    """Return evaluate() with F = 1: facets that are perfect mirrors."""

    def value(N, L, V):
        half = (L + V) / np.linalg.norm(L + V, axis=-1, keepdims=True)
        F = fresnel_reflectance(np.clip((half * V).sum(axis=-1), 0, 1), surface.n)
        return surface.evaluate(N, L, V) / F

    return value


@pytest.mark.parametrize("gamma", [0.02, 0.1, 0.27, 0.6, 1.0, HALF_PI])
@pytest.mark.parametrize("degrees", [0, 30, 60, 75, 85, 89])
def test_albedo_of_mirror_facets_is_at_most_1(gamma, degrees):
    surface = TorranceSparrow(gamma, 3.0)
    found = oracle.albedo(mirror(surface), np.deg2rad(degrees), gamma)
    assert 0.3 < found <= 1 + KINKED_QUADRATURE


@pytest.mark.parametrize("n", [1.0, 1.4, 3.0])
@pytest.mark.parametrize("gamma", [0.02, 0.27, HALF_PI])
def test_albedo_is_at_most_1_for_every_index(n, gamma):
    surface = TorranceSparrow(gamma, n)
    for degrees in (0, 45, 80, 89):
        found = oracle.albedo(surface.evaluate, np.deg2rad(degrees), gamma)
        assert 0 <= found <= 1 + KINKED_QUADRATURE


@pytest.mark.parametrize("gamma", [0.02, 0.05])
def test_a_nearly_smooth_surface_reflects_as_fresnel_says(gamma):
    for degrees in (0, 30, 50):
        angle = np.deg2rad(degrees)
        found = oracle.albedo(TorranceSparrow(gamma).evaluate, angle, gamma)
        expected = fresnel_reflectance(np.cos(angle), 1.4)
        assert_allclose(found, expected, rtol=6 * gamma)


@pytest.mark.parametrize("gamma", [0.2, 0.27, 0.5, 1.0])
@pytest.mark.parametrize("masking", MASKINGS)
def test_specular_albedo_equals_an_independent_quadrature(gamma, masking):
    surface = TorranceSparrow(gamma, masking=masking)
    angles = np.linspace(0, np.deg2rad(80), 9)
    expected = max(oracle.albedo(surface.evaluate, a, gamma) for a in angles)
    assert_allclose(specular_albedo(surface), expected, rtol=KINKED_QUADRATURE)


@pytest.mark.parametrize("gamma", [1e-4, 1e-3, 0.01, 0.05])
def test_specular_albedo_sees_narrow_lobes(gamma):
    surface = TorranceSparrow(gamma)
    angles = np.linspace(0, np.deg2rad(80), 9)
    expected = max(oracle.albedo(surface.evaluate, a, gamma) for a in angles)
    assert_allclose(specular_albedo(surface), expected, rtol=KINKED_QUADRATURE)


def test_too_much_beta_reflects_more_than_came():
    # PHYSICS.md section 7: F = 1 and β = 1 give 2.6 at γ = 1.
    surface = TorranceSparrow.from_beta(1.0, 1.0, n=3.0)
    angles = np.deg2rad([0, 40, 60, 80, 89])
    found = max(oracle.albedo(mirror(surface), a, 1.0) for a in angles)
    assert_allclose(found, 2.6, rtol=0, atol=0.1)


# --- β -------------------------------------------------------------------------


@given(beta=log_uniform(1e-3, 1e3), gamma=log_uniform(0.02, HALF_PI), n=indices)
def test_beta_comes_back(beta, gamma, n):
    surface = TorranceSparrow.from_beta(beta, gamma, n, "none")
    assert_allclose(surface.beta, beta, rtol=ORACLE)
    assert (surface.gamma, surface.n, surface.masking) == (gamma, n, "none")


def test_scale_1_is_the_physical_beta():
    assert TorranceSparrow(0.4).beta == physical_beta(0.4)
    assert_allclose(
        TorranceSparrow.from_beta(physical_beta(0.4), 0.4).specular_scale, 1
    )


# --- at the silhouette ----------------------------------------------------------


def test_with_masking_only_double_grazing_is_bright():
    # G/(N·V) ≤ 2 (N·H)/(V·H), and V·H = 0 needs light against the line of sight.
    surface = TorranceSparrow(0.27)
    light = direction(np.deg2rad(60))
    views = np.stack([direction(HALF_PI - e, np.pi) for e in (1e-1, 1e-2, 2e-3)])
    ceiling = surface.beta * 2 / np.cos(np.deg2rad(75))
    assert (surface.evaluate(UP, light, views) <= ceiling).all()


@pytest.mark.parametrize("masking", MASKINGS)
def test_a_normal_turned_from_the_viewer_is_bent_back(masking):
    # As interpolated normals are at silhouettes: no black rims, no infinities.
    surface = TorranceSparrow(0.5, masking=masking)
    light = direction(np.deg2rad(70))
    rim = [direction(HALF_PI + e, np.pi) for e in (-1e-4, 0.0, 1e-4)]
    values = surface.evaluate(UP, light, np.stack(rim))
    assert (values > 0).all()
    assert_allclose(values, values[1], rtol=1e-2)


# --- refusals ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"gamma": 0.0}, "gamma must be in"),
        ({"gamma": 1.6}, "gamma must be in .* rad; got 1.6"),
        ({"gamma": np.nan}, "gamma must be in"),
        ({"gamma": "wide"}, "gamma must be a number"),
        ({"n": 0.9}, "refractive index n must be in"),
        ({"n": 3.5}, "refractive index n must be in"),
        ({"specular_scale": -0.1}, "specular_scale must be in"),
        ({"specular_scale": np.inf}, "specular_scale must be in"),
        ({"masking": "smith"}, "choose one of: v-cavity, none"),
    ],
)
def test_surfaces_that_are_none_are_refused(wrong, told):
    with pytest.raises(ArgumentError, match=told):
        TorranceSparrow(**wrong)


@pytest.mark.parametrize(("beta", "gamma"), [(-1.0, 0.3), (np.nan, 0.3), (1.0, 0.0)])
def test_betas_that_are_none_are_refused(beta, gamma):
    with pytest.raises(ArgumentError, match="must be in"):
        TorranceSparrow.from_beta(beta, gamma)
