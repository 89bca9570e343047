"""Models by name: exactly one of site and thickness, and clear refusals."""

import numpy as np
import pytest

from skinviz import ArgumentError, fit_skin, skin_model, skin_models
from skinviz.skin.coefficients import body_sites, layer_thickness


def test_every_listed_model_can_be_made():
    assert "two-layer" in skin_models()
    for name in skin_models():
        assert skin_model(name, site="cheek", specular="excluded").name == name


@pytest.mark.parametrize("site", body_sites())
def test_a_site_is_its_thickness(site):
    by_site = skin_model(site=site, specular="included")
    by_depth = skin_model(thickness=layer_thickness(site), specular="included")
    assert by_site.description == by_depth.description


def test_parameters_declare_names_units_and_bounds():
    declared = skin_model(site="cheek", specular="included").parameters
    assert [p.name for p in declared] == ["w_m", "w_h", "w_dh"]
    for parameter in declared:
        assert (parameter.unit, parameter.lower) == ("1", 0.0)
        assert parameter.upper > 1
        assert parameter.meaning


def test_how_it_was_measured_has_no_default():
    with pytest.raises(TypeError, match="specular"):
        skin_model(site="cheek")


@pytest.mark.parametrize(
    "given", [{}, {"site": "cheek", "thickness": (0.03, 1.0)}], ids=["none", "both"]
)
def test_exactly_one_of_site_and_thickness_is_wanted(given):
    with pytest.raises(ArgumentError, match="exactly one of site and thickness"):
        skin_model(specular="included", **given)


@pytest.mark.parametrize(
    "wrong", [(0.03,), (0.03, 1.0, 2.0), 0.03, (0.03, None), ("thin", 1.0), ()]
)
def test_thickness_must_be_two_depths(wrong):
    with pytest.raises(ArgumentError, match="thickness"):
        skin_model(thickness=wrong, specular="included")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"name": "two-layers"}, "did you mean 'two-layer'"),
        ({"site": "elbow"}, "unknown body site 'elbow'"),
        ({"coefficients": "tuned"}, "unknown coefficient set .or a .csv file. 'tuned'"),
        ({"specular": "sometimes"}, "choose one of: excluded, included"),
        ({"specular": 0.7}, "specular must be in"),
    ],
)
def test_unknown_names_are_refused(wrong, told):
    given = {"site": "cheek", "specular": "included", **wrong}
    with pytest.raises(ArgumentError, match=told):
        skin_model(**given)


def test_a_model_cannot_be_changed():
    with pytest.raises(AttributeError):
        skin_model(site="cheek", specular="included").specular = "excluded"


def test_only_the_extended_model_leaves_more_free():
    options = {"site": "cheek", "specular": "included"}
    with pytest.raises(ArgumentError, match="only the extended model leaves more"):
        skin_model("cotton", free=("surface",), **options)
    with pytest.raises(ArgumentError, match="unknown free parameter 'surf'"):
        skin_model("extended", free=("surf",), **options)
    with pytest.raises(ArgumentError, match="must be named once"):
        skin_model("extended", free=("surface", "surface"), **options)


def test_a_free_epidermis_makes_melanin_as_uncertain_as_its_thickness():
    # Nearly only w_m D_e shows: what is not known of D_e is not known of w_m.
    nm = np.arange(400.0, 701.0, 10.0)
    skin = skin_model("extended", free=("epidermis",), site="cheek", specular=0.03)
    spectrum = skin.measured([0.1, 0.01, 0.005, 1.0], nm)
    fit = fit_skin(spectrum, nm, skin, uncertainty=np.full(31, 0.02))
    relative = np.sqrt(fit.covariance[0, 0]) / fit.values[0]
    spread = skin.parameters[3].spread
    assert 0.8 * spread < relative <= 1.05 * spread
    assert ("w_m", "epidermis") in fit.indistinct()
