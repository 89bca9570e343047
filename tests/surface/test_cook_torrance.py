"""Cook and Torrance's surface: Beckmann's facets, Smith's masking, Mitsuba's BRDF."""

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose
from oracles import fresnel
from scipy.integrate import quad
from scipy.special import erf
from strategies import log_uniform
from surface_kinds import HALF_PI, UP, direction, upwards
from tolerances import EPS, ORACLE

from skinviz.surface import CookTorrance, TorranceSparrow
from skinviz.surface.cook_torrance import MASKINGS, facet_distribution

pytestmark = pytest.mark.usefixtures("strict_floats")

slopes = log_uniform(1e-4, HALF_PI)
WALTER = 3.6e-3
"""How far Walter's G₁ is from Smith's, as they say; relative."""


@given(m=slopes)
def test_facets_cover_the_surface_once(m):
    # In units of the slope, tan θ = m t, the integrand is smooth for every m.
    def covered(t):
        cosine = 1 / np.sqrt(1 + (m * t) ** 2)
        D = facet_distribution(m * t * cosine, cosine, m)
        return 2 * np.pi * D * cosine * m * t * cosine * m * cosine**2

    assert_allclose(quad(covered, 0, 8.5, epsrel=1e-12)[0], 1, rtol=1e-10)


@pytest.mark.parametrize("masking", MASKINGS)
@pytest.mark.parametrize("m", [1e-4, 0.3, HALF_PI])
def test_value_along_the_normal_has_a_closed_form(masking, m):
    # D = 1/(π m²), G = 1, F = ((n − 1)/(n + 1))²; Y = π f for E = 1.
    found = CookTorrance(m, 1.5, masking=masking).evaluate(UP, UP, UP)
    assert_allclose(found, 0.04 / (4 * m * m), rtol=ORACLE)


@given(light=upwards, view=upwards, m=log_uniform(0.1, HALF_PI))
def test_without_masking_it_is_facets_over_four_cosines(light, view, m):
    L, V = direction(*light), direction(*view)
    H = (L + V) / np.linalg.norm(L + V)
    D = np.exp(-((H[0] ** 2 + H[1] ** 2) / (m * H[2]) ** 2)) / (
        np.pi * m**2 * H[2] ** 4
    )
    F = float(fresnel.reflectance(V @ H, 1.4))
    brdf = D * F / (4 * L[2] * V[2])
    found = CookTorrance(m, masking="none").evaluate(UP, L, V) / (np.pi * L[2])
    assert_allclose(found, brdf, rtol=1e-9, atol=1e-200)


@given(light=upwards, view=upwards, m=slopes)
def test_grooves_mask_as_torrance_and_sparrows(light, view, m):
    # The same G whatever the facets' distribution is.
    L, V = direction(*light), direction(*view)
    found, other = (s.parts(UP, L, V) for s in (CookTorrance(m), TorranceSparrow(m)))
    assert found["attenuation"] == other["attenuation"]
    assert found["fresnel"] == other["fresnel"]


# --- Smith's masking -----------------------------------------------------------------


def g1(polar, m):
    """Return G₁ of a direction, from light along the normal, of which all is seen."""
    surface, view = CookTorrance(m, masking="smith"), direction(polar)
    return surface.parts(UP, UP, view)["attenuation"] * view[2]


@pytest.mark.parametrize("m", [0.01, 0.1, 0.3, 0.7, HALF_PI])
@pytest.mark.parametrize("degrees", [0, 20, 45, 60, 75, 85, 89, 89.9])
def test_smiths_integral_is_met_to_walters_error(m, degrees):
    polar = np.deg2rad(degrees)
    a = np.divide(np.cos(polar), m * np.sin(polar)) if degrees else np.inf
    hidden = (erf(a) - 1) / 2 + np.exp(-a * a) / (2 * a * np.sqrt(np.pi))
    assert_allclose(g1(polar, m), 1 / (1 + hidden), rtol=WALTER)


@pytest.mark.parametrize("m", [0.1, 0.3, 0.7, HALF_PI])
@pytest.mark.parametrize("degrees", [0, 30, 60, 80])
def test_seen_facets_project_to_the_surface(m, degrees):
    # ∫ G₁(V) max(V·H, 0) D(H) dω = N·V: what is seen is the surface's own projection.
    polar = np.deg2rad(degrees)
    x, w = np.polynomial.legendre.leggauss(200)
    tilt = (x + 1) / 2 * np.arctan(8 * m)
    turn = (np.arange(240) + 0.5) * np.pi / 120
    D = facet_distribution(np.sin(tilt), np.cos(tilt), m)
    VH = np.cos(polar) * np.cos(tilt)[:, None] + np.sin(polar) * np.outer(
        np.sin(tilt), np.cos(turn)
    )
    area = (w / 2 * np.arctan(8 * m) * np.sin(tilt) * D)[:, None] * np.pi / 120
    seen = g1(polar, m) * (np.maximum(VH, 0) * area).sum()
    assert_allclose(seen, np.cos(polar), rtol=WALTER)


@given(light=upwards, view=upwards, m=slopes)
def test_masking_only_takes_light_away(light, view, m):
    at = (UP, direction(*light), direction(*view))
    whole = CookTorrance(m, masking="none").evaluate(*at)
    for masking in ("v-cavity", "smith"):
        assert CookTorrance(m, masking=masking).evaluate(*at) <= whole * (1 + 1e-4)


# --- another renderer ----------------------------------------------------------------


@pytest.fixture(scope="module")
def mitsuba():
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    return mitsuba


@pytest.mark.parametrize("m", [0.1, 0.3, 0.7])
@pytest.mark.parametrize("n", [1.3, 1.4, 2.5])
def test_brdf_is_mitsubas_rough_conductor(mitsuba, m, n):
    material = mitsuba.load_dict(
        {
            "type": "roughconductor",
            "distribution": "beckmann",
            "alpha": m,
            "eta": n,
            "k": 0.0,
        }
    )
    surface = CookTorrance(m, n, masking="smith")
    rng = np.random.default_rng(3)
    compared = 0
    for polars, turns in rng.uniform(0, [[np.deg2rad(88)], [2 * np.pi]], (200, 2, 2)):
        L, V = (direction(p, a) for p, a in zip(polars, turns, strict=True))
        point = mitsuba.SurfaceInteraction3f()
        point.wi = mitsuba.Vector3f(*V)
        found = material.eval(mitsuba.BSDFContext(), point, mitsuba.Vector3f(*L))[0]
        if found > 1e-4:  # it is in float32, and drops the lobe's far tail
            # Both are f (N·L): of unit irradiance, E is 1/π.
            expected = surface.evaluate(UP, L, V) / np.pi
            assert_allclose(found, expected, rtol=2e-4)
            compared += 1
    assert compared > 20


def test_the_narrowest_facets_are_a_mirror():
    surface, light = CookTorrance(1e-4), direction(0.7)
    onwards = [direction(0.7 + off, np.pi) for off in (0.0, 1e-3, 0.01)]
    values = surface.evaluate(UP, light, np.stack(onwards))
    assert values[0] > 1e5
    assert values[1] < values[0] * 1e-10
    assert values[2] == 0


def test_facets_on_edge_and_facets_that_face_away_are_none():
    sine, cosine = np.array([1.0, 1.0, 0.0]), np.array([0.0, 1e-300, -1.0])
    assert (facet_distribution(sine, cosine, HALF_PI) == 0).all()
    assert facet_distribution(np.array(0.0), np.array(1.0), 0.5) == pytest.approx(
        1 / (np.pi * 0.25), rel=4 * EPS
    )
