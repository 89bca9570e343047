"""The surface models by name."""

import pytest

from skinviz import ArgumentError
from skinviz.surface import (
    CookTorrance,
    Lambert,
    Phong,
    TorranceSparrow,
    dispersion,
    surface_model,
    surface_models,
)
from skinviz.surface.models import surface_parameters


def test_all_models_have_names():
    made = [type(surface_model(name)) for name in surface_models()]
    assert made == [TorranceSparrow, CookTorrance, Phong, Lambert]
    assert [surface_model(name).name for name in surface_models()] == list(
        surface_models()
    )


@pytest.mark.parametrize("name", surface_models())
def test_a_model_takes_its_parameters_by_name(name):
    plain = surface_model(name)
    own = {
        key: getattr(plain, key) for key in surface_parameters(name) if key != "beta"
    }
    assert surface_model(name, **own) == plain


def test_the_papers_surface_is_the_first():
    assert surface_model() == TorranceSparrow()
    assert surface_model(beta=0.7, gamma=0.2) == TorranceSparrow.from_beta(0.7, 0.2)


def test_a_tissue_stands_for_its_index():
    for name in ("torrance-sparrow", "cook-torrance", "phong"):
        assert surface_model(name, n="dermis").n == dispersion("dermis")
    made = surface_model(beta=0.7, n="epidermis")
    assert made == TorranceSparrow.from_beta(0.7, n=dispersion("epidermis"))


@pytest.mark.parametrize(
    ("name", "parameters", "told"),
    [
        ("fong", {}, "choose one of: torrance-sparrow, .* did you mean 'phong'"),
        ("phong", {"gamma": 1}, "it has exponent, n, specular_scale$"),
        ("cook-torrance", {"beta": 1}, "no parameter 'beta'; it has roughness, n,"),
        ("torrance-sparrow", {"gama": 1}, "gamma, n, specular_scale, masking, beta$"),
        ("lambert", {"n": 1.4}, "it has none"),
        ("phong", {"n": "glass"}, "choose one of: epidermis, dermis"),
        ("torrance-sparrow", {"beta": 1, "specular_scale": 1}, "not both"),
    ],
)
def test_what_no_model_has_is_refused(name, parameters, told):
    with pytest.raises(ArgumentError, match=told):
        surface_model(name, **parameters)
