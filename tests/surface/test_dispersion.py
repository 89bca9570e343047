"""Refractive index by wavelength: Ding's fits, and Fresnel's law from a few indices."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import ArgumentError
from skinviz.surface import Dispersion, dispersion, dispersions, fresnel_reflectance
from skinviz.surface.dispersion import dispersion_basis

pytestmark = pytest.mark.usefixtures("strict_floats")

PAPER = np.arange(400.0, 701, 5)
VISIBLE = np.arange(380.0, 781, 1)

COSINES = np.unique(
    np.concatenate([np.linspace(0, 1, 2001), np.geomspace(1e-300, 1, 2001)])
)
"""From grazing to normal incidence."""


def worst(n, nodes, weights):
    """Return the largest relative error of F over all cosines and bands."""
    expected = fresnel_reflectance(COSINES[:, None], n)
    found = fresnel_reflectance(COSINES[:, None], nodes) @ weights
    return np.abs(found / expected - 1).max()


# --- tissues ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("nm", "epidermis", "dermis"),
    # Printed to five digits from Ding et al. (2006).
    [
        (380, 1.46816, 1.39672),
        (400, 1.46282, 1.39408),
        (450, 1.45245, 1.38894),
        (500, 1.44503, 1.38527),
        (520, 1.44265, 1.38409),
    ],
)
def test_tissues_have_dings_indices(nm, epidermis, dermis):
    assert_allclose(dispersion("epidermis").index(nm), epidermis, rtol=0, atol=5.1e-6)
    assert_allclose(dispersion("dermis").index(nm), dermis, rtol=0, atol=5.1e-6)


@pytest.mark.parametrize("name", dispersions())
def test_tissues_bend_blue_light_more(name):
    tissue = dispersion(name)
    assert (np.diff(tissue.index(VISIBLE)) < 0).all()
    assert tissue.index(VISIBLE).shape == VISIBLE.shape
    assert tissue.index(550).shape == ()


def test_an_unknown_tissue_lists_the_known():
    with pytest.raises(ArgumentError, match="choose one of: epidermis, dermis"):
        dispersion("hypodermis")


@pytest.mark.parametrize("nm", [299.0, 1601.0, [500, 2000], np.nan, 0.0, -500.0])
def test_an_index_is_never_extrapolated(nm):
    with pytest.raises(ArgumentError, match="known from 300 to 1600 nm"):
        dispersion("dermis").index(nm)


def test_cauchys_law_to_the_letter():
    glass = Dispersion("glass", 1.5, 4000.0, 2e8, 400, 800)
    for nm in (400.0, 555.5, 800.0):
        expected = 1.5 + 4000 / nm**2 + 2e8 / nm**4
        assert_allclose(glass.index(nm), expected, rtol=1e-15)


@pytest.mark.parametrize(
    "wrong",
    [
        {"a": 0.9, "b": 0.0},
        {"a": 3.1, "b": 0.0},
        {"a": 1.0, "b": -10.0},
        {"a": 1.5, "b": 1e6},
        {"a": np.nan, "b": 0.0},
        {"a": 1.4, "b": np.inf},
        {"a": 1.4, "b": 0.0, "shortest": 800, "longest": 400},
        {"a": 1.4, "b": 0.0, "shortest": 0},
        # Both ends are fine, but in between the index falls below 1.
        {"a": 1.2, "b": -1.6e5, "c": 1.85e10, "shortest": 400, "longest": 1600},
    ],
)
def test_dispersions_that_are_none_are_refused(wrong):
    with pytest.raises(ArgumentError, match="must"):
        Dispersion("stuff", **wrong)


# --- Fresnel's law from a few indices ----------------------------------------------


@pytest.mark.parametrize("name", dispersions())
@pytest.mark.parametrize("bands", [PAPER, VISIBLE])
def test_skin_needs_few_indices(name, bands):
    n = dispersion(name).index(bands)
    nodes, weights = dispersion_basis(n)
    assert nodes.size <= {"epidermis": 5, "dermis": 4}[name]
    assert weights.shape == (nodes.size, bands.size)
    assert worst(n, nodes, weights) <= 1e-9


@given(
    low=st.floats(1.2, 3),
    width=st.floats(1e-6, 0.3),
    tolerance=st.sampled_from([1e-3, 1e-6, 1e-9, 1e-12]),
)
def test_tolerance_is_kept(low, width, tolerance):
    n = np.linspace(low, low + width, 40)
    nodes, weights = dispersion_basis(n, tolerance)
    assert worst(n, nodes, weights) <= tolerance


def test_a_wider_tolerance_needs_fewer_indices():
    n = dispersion("epidermis").index(PAPER)
    sizes = [dispersion_basis(n, t)[0].size for t in (1e-1, 1e-3, 1e-6, 1e-9, 1e-12)]
    assert sizes == sorted(sizes)
    assert sizes[0] == 1
    assert sizes[-1] > sizes[0]


@pytest.mark.parametrize("n", [np.linspace(1, 3, 61), [1.0, 1.0 + 1e-9, 3.0]])
def test_a_wide_range_is_not_approximated(n):
    nodes, weights = dispersion_basis(n)
    assert_array_equal(nodes, n)
    assert_array_equal(weights, np.eye(len(n)))


def test_equal_indices_are_one():
    n = [1.4, 1.5, 1.4, 1.4]
    nodes, weights = dispersion_basis(n)
    assert_array_equal(nodes, [1.4, 1.5])
    assert_array_equal(nodes @ weights, n)
    for same in (1.0, 1.4, 3.0):
        nodes, weights = dispersion_basis(np.full(7, same))
        assert_array_equal(nodes, [same])
        assert_array_equal(weights, np.ones((1, 7)))


def test_weights_are_moderate():
    # Otherwise errors of F would be magnified.
    for name in dispersions():
        _, weights = dispersion_basis(dispersion(name).index(PAPER))
        assert np.abs(weights).sum(axis=0).max() < 3
        assert_allclose(weights.sum(axis=0), 1, rtol=0.01)


@pytest.mark.parametrize("wrong", [[0.9, 1.4], [np.nan], ["glass"]])
def test_indices_that_are_none_are_refused(wrong):
    with pytest.raises(ArgumentError, match="refractive index must be"):
        dispersion_basis(wrong)
