"""What holds of every surface model, with each of its maskings."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from oracles import surfaces as oracle
from strategies import log_uniform
from surface_kinds import (
    BOUNDED,
    EVERYWHERE,
    NARROWEST,
    SURFACES,
    UP,
    WIDEST,
    azimuths,
    direction,
    rotation,
    upwards,
)
from tolerances import EPS, KINKED_QUADRATURE, NORMAL, ORACLE, ROUNDING

from skinviz import ArgumentError
from skinviz._vector_math import DEEPEST
from skinviz.surface import (
    Dispersion,
    Lambert,
    Surface,
    dispersion,
    fresnel_reflectance,
    specular_albedo,
    surface_model,
    surface_models,
)
from skinviz.surface.evaluation import cosines

pytestmark = pytest.mark.usefixtures("strict_floats")

widths = log_uniform(NARROWEST, WIDEST)
indices = st.floats(1, 3)
MIRROR = 1e8  # index at which F is 1 to eight digits

every = pytest.mark.parametrize("kind", SURFACES)


def check_surface(surface, light, view, turn):
    """Check the laws of one surface, lit and seen from above.

    ``turn`` is an angle about the normal.
    """
    here = surface.evaluate(UP, light, view)
    assert np.isfinite(here)
    assert here >= 0
    # Reciprocity is a law of the BRDF, Y/((N·L) E).
    back = surface.evaluate(UP, view, light)
    assert_allclose(here / light[2], back / view[2], rtol=ORACLE, atol=1e-200)
    # No grain: turning light and viewer about the normal changes nothing. Rounding of
    # the directions, 1e-16, is magnified by what the lobe's narrowness makes of it.
    Q = rotation(UP, turn)
    turned = surface.evaluate(UP, Q @ light, Q @ view)
    power = check_twin(surface, light, view)
    rtol = 1e-11 + 1e-12 * np.sqrt(power) / width_of(surface)
    assert_allclose(turned, here, rtol=rtol, atol=1e-200)
    # The parts are the factors of the whole.
    parts = surface.parts(UP, light, view)
    product = surface.beta * np.prod(list(parts.values()), axis=0)
    assert_allclose(product, here, rtol=1e-11, atol=1e-200)


def check_twin(surface, light, view):
    """Compare the compiled lobe with its twin at 40 digits; return its exponent."""
    seen = cosines(UP, light, view)
    expected, power, magnified = twin(surface, seen)
    found = lobe(surface, seen)
    if power < DEEPEST and expected > NORMAL:
        # e^−power magnifies the rounding of the power, a few EPS of it.
        rtol = ROUNDING + 6 * EPS * magnified
        assert_allclose(found, expected, rtol=rtol, atol=0)
    else:
        assert found <= NORMAL * max(surface.beta, 1)
    return power


def lobe(surface, seen):
    """Return the compiled lobe at one point."""
    out = np.zeros(1)
    surface.lobe(*(np.array([x]) for x in seen), surface.constants, out)
    return out[0]


def twin(surface, seen):
    """Return the oracle's lobe at one point, its exponent and its magnification."""
    names = {
        "torrance-sparrow": ("beta", "gamma", "masking"),
        "cook-torrance": ("specular_scale", "roughness", "masking"),
        "phong": ("specular_scale", "exponent"),
        "lambert": (),
    }[surface.name]
    model = getattr(oracle, surface.name.replace("-", "_"))
    return oracle.spread(model, seen, **{k: getattr(surface, k) for k in names})


def width_of(surface):
    """Return about how narrow a lobe is. [rad]"""
    return min(surface.reach(0.0), 1.0)


def mirror(surface):
    """Return the surface's evaluate() with facets that are perfect mirrors."""
    return lambda N, L, V: surface.evaluate(N, L, V, MIRROR)


# --- the contract ----------------------------------------------------------------


@every
@given(light=upwards, view=upwards, turn=azimuths, width=widths, n=indices)
def test_laws_hold_all_over_the_hemisphere(kind, light, view, turn, width, n):
    surface = SURFACES[kind](width, n=n)
    check_surface(surface, direction(*light), direction(*view), turn)


@every
@given(
    light=upwards,
    off=st.floats(0, 4),
    azimuth=azimuths,
    turn=azimuths,
    width=log_uniform(NARROWEST, 0.3),
)
def test_laws_hold_within_narrow_lobes(kind, light, off, azimuth, turn, width):
    # Facets up to four widths from the normal.
    L, H = direction(*light), direction(off * width / 2, azimuth)
    V = 2 * (L @ H) * H - L
    if V[2] > 1e-3:
        check_surface(SURFACES[kind](width), L, V / np.linalg.norm(V), turn)


@every
@pytest.mark.parametrize("width", [NARROWEST, 1e-3, 0.27, WIDEST])
@pytest.mark.parametrize("n", [1.0, 1.4, 3.0])
def test_value_is_a_number_everywhere(kind, width, n):
    surface = SURFACES[kind](width, n=n)
    values = surface.evaluate(UP, EVERYWHERE[:, None], EVERYWHERE)
    assert np.isfinite(values).all()
    assert (values >= 0).all()
    assert_array_equal(values[EVERYWHERE[:, 2] <= 0], 0)
    if n == 1:
        assert_array_equal(values, 0)


@every
@pytest.mark.parametrize("width", [NARROWEST, WIDEST])
def test_the_twin_agrees_everywhere(kind, width):
    surface = SURFACES[kind](width)
    for light in EVERYWHERE:
        for view in EVERYWHERE:
            if np.linalg.norm(light + view) > 1e-6:
                check_twin(surface, light, view)


@every
def test_a_block_is_its_points(kind):
    # As a picture's loops call it: many points at once, the same to the last bit.
    surface = SURFACES[kind](0.3)
    rng = np.random.default_rng(1)
    L, V = rng.normal(size=(2, 509, 3))
    L, V = (x / np.linalg.norm(x, axis=1)[:, None] for x in (L, V))
    seen, out = cosines(UP, L, V), np.zeros(509)
    surface.lobe(*seen, surface.constants, out)
    assert_allclose(out, [lobe(surface, point) for point in seen.T], rtol=4 * EPS)
    assert_allclose(
        surface.evaluate(UP, L, V),
        out * fresnel_reflectance(seen[4], surface.n),
        rtol=8 * EPS,
    )


# --- energy ----------------------------------------------------------------------


@pytest.mark.parametrize("kind", BOUNDED)
@pytest.mark.parametrize("width", [NARROWEST, 0.01, 0.1, 0.27, 0.6, 1.0, WIDEST])
def test_facets_that_are_mirrors_reflect_at_most_all_light(kind, width):
    surface = SURFACES[kind](width)
    for degrees in (60, 89):  # nine angles up to each
        found = specular_albedo(surface, np.deg2rad(degrees), n=MIRROR)
        assert 0 <= found <= 1 + KINKED_QUADRATURE


@pytest.mark.parametrize("kind", SURFACES)
@pytest.mark.parametrize("width", [0.2, 0.5, WIDEST])
def test_specular_albedo_equals_an_integral_over_directions(kind, width):
    surface = SURFACES[kind](width)
    angles = np.linspace(0, np.deg2rad(80), 9)
    expected = max(oracle.albedo(surface.evaluate, a) for a in angles)
    # Without masking the integral over facets has a step where they turn out of sight.
    rtol = 4e-3 if kind.endswith("none") else KINKED_QUADRATURE
    assert_allclose(specular_albedo(surface), expected, rtol=rtol, atol=0)


@pytest.mark.parametrize("kind", [k for k in BOUNDED if k != "lambert"])
@pytest.mark.parametrize("degrees", [0, 30, 50])
def test_a_nearly_smooth_surface_reflects_as_fresnel_says(kind, degrees):
    surface, angle = SURFACES[kind](0.02), np.deg2rad(degrees)
    found = _share(surface, angle)
    expected = float(fresnel_reflectance(np.cos(angle), 1.4))
    # Phong's lobe has no facets: its light falls off with the cosine of incidence.
    share = np.cos(angle) if kind == "phong" else 1.0
    assert_allclose(found, expected * share, rtol=0.02)


def _share(surface, angle):
    from skinviz.surface.energy import _albedo

    return _albedo(surface, angle, None)


@every
def test_light_is_proportional_to_the_scale(kind):
    if kind == "lambert":
        return
    at = (UP, direction(0.6), direction(0.4, 3.0))
    one, two = (SURFACES[kind](0.3, specular_scale=s) for s in (1.0, 2.5))
    assert_allclose(two.evaluate(*at), 2.5 * one.evaluate(*at), rtol=4 * EPS)
    assert one.beta == one.physical_beta
    assert SURFACES[kind](0.3, specular_scale=0.0).evaluate(*at) == 0


# --- Fresnel's law -----------------------------------------------------------------


@pytest.mark.parametrize("kind", [k for k in SURFACES if k != "lambert"])
@pytest.mark.parametrize("n", [1.1, 1.4, 3.0])
def test_fresnels_law_is_that_of_the_facets(kind, n):
    surface = SURFACES[kind](0.3, n=n)
    brewster = np.arctan(n)
    light, view = direction(brewster), direction(brewster, np.pi)
    s = ((n * n - 1) / (n * n + 1)) ** 2
    assert_allclose(surface.parts(UP, light, view)["fresnel"], s / 2, rtol=ORACLE)
    light, view = direction(np.pi / 2), direction(np.pi / 2 - 1e-9, np.pi)
    assert_allclose(surface.parts(UP, light, view)["fresnel"], 1, rtol=1e-7)


@every
def test_an_index_that_is_given_takes_the_place_of_ones_own(kind):
    surface, at = SURFACES[kind](0.3), (UP, direction(0.3), direction(0.5, 2.0))
    n = np.array([1.0, 1.3, 2.0])
    found = surface.evaluate(*at, n)
    assert found.shape == (3,)
    expected = [SURFACES[kind](0.3, n=x).evaluate(*at) for x in n]
    if kind != "lambert":
        assert_allclose(found, expected, rtol=4 * EPS)
        assert found[0] == 0 < found[1] < found[2]
    assert_array_equal(surface.parts(*at, n)["fresnel"].shape, (3,))


@pytest.mark.parametrize("kind", [k for k in SURFACES if k != "lambert"])
def test_an_index_that_varies_is_asked_for(kind):
    tissue = dispersion("epidermis")
    surface, at = SURFACES[kind](0.3, n=tissue), (UP, direction(0.3), direction(0.1))
    for call in (surface.evaluate, surface.parts):
        with pytest.raises(ArgumentError, match=r"epidermis, varies .* give n"):
            call(*at)
    n = tissue.index([400, 550, 700])
    assert (np.diff(surface.evaluate(*at, n)) < 0).all()
    assert specular_albedo(surface, n=1.45) > specular_albedo(surface, n=1.43)
    assert "n of epidermis" in surface.description


# --- shapes and refusals -----------------------------------------------------------


@every
def test_shapes_broadcast(kind):
    surface = SURFACES[kind](0.5)
    lights, views = EVERYWHERE[:4, None], EVERYWHERE[None, :5]
    values = surface.evaluate(UP, lights, views)
    assert values.shape == (4, 5)
    assert values[1, 4] == surface.evaluate(UP, EVERYWHERE[1], EVERYWHERE[4])
    assert surface.evaluate(UP, UP, UP).shape == ()
    assert surface.evaluate(UP, UP, np.zeros((0, 3))).shape == (0,)
    parts = surface.parts(UP, lights, views)
    assert list(parts) == ["distribution", "attenuation", "fresnel"]
    assert all(part.shape == (4, 5) for part in parts.values())


@every
def test_many_points_are_worked_on_in_pieces(kind):
    surface, n = SURFACES[kind](0.4), 40_000
    rng = np.random.default_rng(2)
    views = rng.normal(size=(n, 3))
    views /= np.linalg.norm(views, axis=1)[:, None]
    values = surface.evaluate(UP, direction(0.3), views)
    some = np.array([0, 511, 512, 16_383, 16_384, n - 1])
    alone = surface.evaluate(UP, direction(0.3), views[some])
    assert_allclose(values[some], alone, rtol=4 * EPS)


@every
@pytest.mark.parametrize(
    ("vectors", "told"),
    [
        ((UP, UP, 2 * UP), "view must be unit vectors; .* has length 2"),
        ((UP, np.zeros(3), UP), "light must be unit vectors; .* has length 0"),
        (([np.nan, 0, 1], UP, UP), "normals must be unit vectors; .* length nan"),
        ((UP, UP, [1e200, 0, 0]), "view must be unit vectors; .* length inf"),
        ((UP, [1.0, 0.0], UP), r"light must be vectors \(..., 3\); got shape \(2,\)"),
        ((UP, 1.0, UP), r"light must be vectors \(..., 3\); got shape \(\)"),
        ((["a", "b", "c"], UP, UP), "normals must be numbers"),
        (([UP, UP, [0, 3, 0]], UP, UP), r"that at index \(2,\) has length 3"),
    ],
)
def test_vectors_that_are_none_are_refused(kind, vectors, told):
    surface = SURFACES[kind](0.4)
    for call in (surface.evaluate, surface.parts):
        with pytest.raises(ArgumentError, match=told):
            call(*vectors)


@every
@pytest.mark.parametrize("n", [0.9, np.nan, np.inf, [1.4, -1.0]])
def test_indices_that_are_none_are_refused(kind, n):
    with pytest.raises(ArgumentError, match="refractive index must be at least 1"):
        SURFACES[kind](0.4).evaluate(UP, UP, UP, n)


WRONG = {
    "torrance-sparrow": [{"gamma": 0.0}, {"gamma": 1.6}, {"masking": "smith"}],
    "cook-torrance": [{"roughness": 0}, {"roughness": 2}, {"masking": "walter"}],
    "phong": [{"exponent": -1}, {"exponent": 2e9}, {"exponent": "sharp"}],
    "lambert": [{"n": 1.4}],
}
SHARED = [
    *({"n": 0.9}, {"n": 3.5}, {"n": np.nan}, {"n": "glass"}, {"n": None}),
    *({"specular_scale": -0.1}, {"specular_scale": np.inf}, {"gloss": 1}),
]


@pytest.mark.parametrize("name", surface_models())
def test_surfaces_that_are_none_are_refused(name):
    for wrong in WRONG[name] + SHARED:
        with pytest.raises(ArgumentError):
            surface_model(name, **wrong)


@every
def test_a_surface_is_frozen_and_has_the_face(kind):
    surface = SURFACES[kind](0.4)
    assert isinstance(surface, Surface)
    assert surface == SURFACES[kind](0.4)
    assert len({surface, SURFACES[kind](0.4)}) == 1
    with pytest.raises(AttributeError):
        surface.specular_scale = 0.5
    told = surface.description
    assert told.lower().startswith(surface.name.split(maxsplit=1)[0])
    assert "\n" not in told


def test_no_surface_is_not_one():
    assert not isinstance(Dispersion("air", 1.0, 0.0), Surface)


def test_lambert_reflects_nothing():
    surface = Lambert()
    assert_array_equal(surface.evaluate(UP, EVERYWHERE[:, None], EVERYWHERE), 0)
    assert specular_albedo(surface) == surface.beta == 0
