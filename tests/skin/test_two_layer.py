"""The paper's model against eqs (5)–(9) at many digits, and at its extremes."""

from itertools import product

import numpy as np
import pytest
from compiled_optics import measured_and_jacobian
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from oracles import two_layer as oracle
from oracles.agreement import assert_oracle
from strategies import log_uniform
from tolerances import EPS, ORACLE

from skinviz import ArgumentError, kubelka_munk_layer, skin_model
from skinviz.skin.coefficients import load_coefficients
from skinviz.skin.two_layer import TwoLayer

pytestmark = pytest.mark.usefixtures("strict_floats")

INF = np.inf
NM = np.array([400.0, 422.5, 545.0, 700.0])
SPECULAR = ("included", "excluded", 0.03)
EXTREME = np.array(list(product([0.0, 1e-12, 0.05, 1e12], repeat=3)))
"""Weights at the ends of what is allowed, and skin's own."""
THICKNESSES = [*product([0.0, 1e-16, 0.04, 1e16, INF], repeat=2), (0.027, 1.491)]
NO_ENDLESS = [depths for depths in THICKNESSES if INF not in depths]

weight = st.just(0.0) | st.just(1e12) | log_uniform(1e-12, 1e12)
blood = log_uniform(1e-4, 1.0)


def table(nm=NM):
    """Return K_m, K_h, K_dh, S_e, S_d (5, n) of the default set."""
    at = load_coefficients().at(nm)
    columns = (at.melanin, at.oxyhaemoglobin, at.deoxyhaemoglobin)
    return np.stack([*columns, at.epidermis, at.dermis])


def expected_reflectance(weights, thickness, hypodermis=1.0):
    """Return R_b (m, n) of the oracle."""
    with oracle.mp_digits():
        return np.array(
            [
                [
                    float(oracle.reflectance(w, c[:3], c[3:], thickness, hypodermis))
                    for c in table().T
                ]
                for w in weights
            ]
        )


def model(thickness=(0.035, 1.19), specular="excluded", hypodermis=1.0):
    """Return a two-layer model, hypodermis and all."""
    return TwoLayer(thickness, load_coefficients(), specular, hypodermis)


# --- values --------------------------------------------------------------------


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_reflectance_equals_the_oracle_at_extreme_weights(thickness):
    found = model(thickness).reflectance(EXTREME, NM)
    assert_oracle(found, expected_reflectance(EXTREME, thickness))


@pytest.mark.parametrize("hypodermis", [0.0, 0.3, 1.0])
def test_reflectance_equals_the_oracle_over_any_hypodermis(hypodermis):
    found = model(hypodermis=hypodermis).reflectance(EXTREME, NM)
    assert_oracle(found, expected_reflectance(EXTREME, (0.035, 1.19), hypodermis))


@given(weights=st.tuples(weight, weight, weight))
def test_reflectance_equals_the_oracle_at_any_weights(weights):
    expected = expected_reflectance([weights], (0.035, 1.19))
    assert_oracle(model().reflectance([weights], NM), expected)


def test_measured_with_the_surface_equals_the_oracle():
    weights = [0.1, 0.01, 0.005]
    with oracle.mp_digits():
        body = [
            oracle.reflectance(weights, c[:3], c[3:], (0.035, 1.19)) for c in table().T
        ]
        expected = [float(oracle.saunderson(b)) for b in body]
    assert_allclose(
        model(specular="included").measured(weights, NM), expected, rtol=ORACLE
    )


def test_measured_and_diffuse_are_the_interface_applied_to_the_body():
    for specular in SPECULAR:
        skin = model(specular=specular)
        body = skin.reflectance(EXTREME, NM)
        assert_allclose(
            skin.measured(EXTREME, NM), skin.interface.measured(body), rtol=4 * EPS
        )
        assert_array_equal(skin.diffuse(EXTREME, NM), skin.interface.diffuse(body))


@pytest.mark.parametrize("thickness", THICKNESSES)
@pytest.mark.parametrize("specular", ["included", "excluded"])
def test_no_skin_returns_more_light_than_it_got(thickness, specular):
    skin = model(thickness, specular)
    for values in (skin.reflectance(EXTREME, NM), skin.measured(EXTREME, NM)):
        assert (values >= 0).all()
        assert (values <= 1 + 4 * EPS).all()


def test_bloodless_white_skin_is_a_perfect_diffuser():
    assert_allclose(model().reflectance([0, 0, 0], NM), 1, rtol=4 * EPS)


def test_without_layers_the_hypodermis_is_seen():
    found = model((0.0, 0.0), hypodermis=0.3).reflectance([0.1, 0.1, 0.1], NM)
    assert_allclose(found, 0.3, rtol=4 * EPS)


@given(blood=blood, share=st.just(0.0) | log_uniform(1e-6, 1.0))
def test_saturation_is_not_seen_where_the_pigments_absorb_alike(blood, share):
    nm = 545.0
    at = load_coefficients().at([nm])
    ratio = float(at.deoxyhaemoglobin[0] / at.oxyhaemoglobin[0])
    all_oxygenated = model().reflectance([0.1, blood, 0.0], [nm])
    # The same absorption by other shares of the two pigments.
    mixed = [0.1, blood * share, blood * (1 - share) / ratio]
    assert_allclose(model().reflectance(mixed, [nm]), all_oxygenated, rtol=ORACLE)


# --- derivatives ---------------------------------------------------------------

MODERATE = np.array(list(product([0.0, 1e-12, 0.05, 3.0, 1e12], repeat=3)))


@pytest.mark.parametrize("thickness", [(0.027, 1.491), (0.5, 0.01), (0.04, 1e16)])
def test_jacobian_equals_the_oracle(thickness):
    weights = MODERATE[::3]
    _, jacobian = measured_and_jacobian(model(thickness), weights, NM)
    expected = np.array(
        [
            [
                [float(oracle.slope(i, w, c[:3], c[3:], thickness)) for i in range(3)]
                for c in table().T
            ]
            for w in weights
        ]
    )
    assert_oracle(jacobian, expected)


@pytest.mark.parametrize("specular", SPECULAR)
def test_jacobian_carries_the_surface(specular):
    weights = np.array([[0.1, 0.01, 0.005]])
    body, inner = measured_and_jacobian(model(), weights, NM)
    measured, outer = measured_and_jacobian(model(specular=specular), weights, NM)
    skin = model(specular=specular)
    assert_allclose(measured, skin.measured(weights, NM), rtol=4 * EPS)
    assert_allclose(outer, inner * (skin.interface.slope(body)[..., None]))


@pytest.mark.parametrize("thickness", NO_ENDLESS)
def test_more_pigment_never_brightens_finite_skin(thickness):
    _, jacobian = measured_and_jacobian(model(thickness, "included"), EXTREME, NM)
    assert np.isfinite(jacobian).all()
    assert (jacobian <= 0).all()


@pytest.mark.parametrize("thickness", [d for d in THICKNESSES if INF in d])
def test_more_pigment_never_brightens_endless_skin(thickness):
    # Without pigment its slope is infinite; it is never undefined.
    _, jacobian = measured_and_jacobian(model(thickness, "included"), EXTREME, NM)
    assert (jacobian <= 0).all()


def test_layers_of_no_depth_have_no_pigment_to_change():
    _, jacobian = measured_and_jacobian(model((0.0, 0.0)), EXTREME, NM)
    assert_array_equal(jacobian, 0)


# --- shapes and refusals -------------------------------------------------------


@pytest.mark.parametrize("shape", [(), (4,), (2, 3)])
def test_batches_keep_their_shape(shape):
    weights = np.full((*shape, 3), 0.01)
    found = model().reflectance(weights, NM)
    assert found.shape == (*shape, NM.size)
    assert_array_equal(found, np.broadcast_to(found[(0,) * len(shape)], found.shape))


def test_weights_may_be_read_only_broadcast_or_of_another_order():
    weights = np.array([[0.1, 0.01, 0.0], [0.2, 0.0, 0.01]])
    expected = model().measured(weights, NM)
    weights.setflags(write=False)
    assert_array_equal(model().measured(weights, NM), expected)
    assert_array_equal(model().measured(np.asfortranarray(weights), NM), expected)
    alike = np.broadcast_to(weights[0], (4, 3))
    assert_array_equal(model().measured(alike, NM), np.tile(expected[0], (4, 1)))


@pytest.mark.parametrize("wrong", [-1e-3, 1.1e12, np.nan, INF])
def test_weights_out_of_bounds_are_refused(wrong):
    with pytest.raises(ArgumentError, match="must be between 0 and 1e"):
        model().reflectance([0.1, wrong, 0.1], NM)


@pytest.mark.parametrize("wrong", [0.1, [0.1, 0.1], np.ones((3, 2))])
def test_the_wrong_number_of_weights_is_refused(wrong):
    with pytest.raises(ArgumentError, match="takes 3 weights on the last axis"):
        model().reflectance(wrong, NM)


def test_wavelengths_outside_the_table_are_refused():
    with pytest.raises(ArgumentError, match="nothing is extrapolated"):
        model().reflectance([0.1, 0.1, 0.1], [370.0, 400.0])


@pytest.mark.parametrize("wrong", [-0.1, 1e-17, 2e16, np.nan])
@pytest.mark.parametrize("tissue", ["epidermis", "dermis"])
def test_impossible_thickness_is_refused_by_tissue(wrong, tissue):
    depths = (wrong, 1.0) if tissue == "epidermis" else (0.03, wrong)
    with pytest.raises(ArgumentError, match=f"thickness of the {tissue}"):
        model(depths)


@pytest.mark.parametrize("wrong", [-0.1, 1.1, np.nan])
def test_impossible_hypodermis_is_refused(wrong):
    with pytest.raises(ArgumentError, match="hypodermis must be in"):
        model(hypodermis=wrong)


def test_description_makes_the_model_anew():
    first = skin_model(thickness=(0.03, 1.3), coefficients="textbook", specular=0.02)
    told = dict(first.description)
    again = skin_model(
        told.pop("model"), thickness=tuple(told.pop("thickness_mm")), **told
    )
    weights = [0.1, 0.01, 0.01]
    assert_array_equal(again.measured(weights, NM), first.measured(weights, NM))


def test_layers_together_are_the_body():
    """R_b = R_e + T_e² R_d / (1 - R_e R_d), eq. (9), by the layers' own R and T."""
    model = skin_model(site="cheek", specular="included")
    values = np.array([[0.1, 0.008, 0.004], [0.02, 0.001, 0.0]])
    R_e, R_d = model.layers(values, NM)
    own = model.coefficients.at(NM)
    _, T_e = kubelka_munk_layer(
        values[:, :1] * own.melanin, own.epidermis, model.thickness[0]
    )
    body = R_e + T_e**2 * R_d / (1 - R_e * R_d)
    assert_allclose(body, model.reflectance(values, NM), rtol=ORACLE)
