"""Tables II and III: fits to people, and how methods compare."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skinviz import fit_skin, skin_model, skin_models
from skinviz.study.tables import (
    COEFFICIENTS,
    PAPER_ERRORS,
    PAPER_WEIGHTS,
    SITES,
    compare,
    fit_people,
    order_agreement,
)


@pytest.mark.parametrize("model", skin_models())
@pytest.mark.parametrize("coefficients", COEFFICIENTS)
def test_each_site_is_fitted_with_its_own_thickness(seven, model, coefficients):
    method = fit_people(seven, model, coefficients)
    for s, site in enumerate(SITES):
        own = skin_model(
            model, site=site, specular="included", coefficients=coefficients
        )
        fit = fit_skin(seven.reflectance[2, s], seven.wavelengths, own)
        assert_allclose(method.values[2, s], fit.values, rtol=1e-6, atol=1e-9)
        assert_allclose(method.sse_61[2, s], fit.sse * 61 / 31, rtol=1e-6)
        assert method.parameters == tuple(p.name for p in own.parameters)
    assert method.n_failed == 0


def test_the_papers_figures_are_as_printed():
    assert [sum(w) for w in PAPER_WEIGHTS.values()] == [1348, 666, 706]
    assert [round(sum(e), 3) for e in PAPER_ERRORS.values()] == [0.19, 0.726]


def test_order_agreement_is_one_for_the_paper_and_none_for_its_reverse():
    for weights in PAPER_WEIGHTS.values():
        own = np.array(weights, dtype=float)
        assert order_agreement(own, weights) == 1
        assert order_agreement(np.exp(own / 99), weights) == 1
        assert order_agreement(-own, weights) == 0
        assert order_agreement(own * 0, weights) == 0.5
    one_swap = order_agreement(np.array([1.0, 2, 4, 3]), (1, 2, 3, 4))
    assert_allclose(one_swap, 5 / 6)


def test_order_agreement_averages_to_chance_over_all_orders():
    from itertools import permutations

    orders = np.array(list(permutations(range(4))), dtype=float)
    assert_allclose(order_agreement(orders, PAPER_WEIGHTS["w_h"]).mean(), 0.5)


def test_comparison_leaves_out_what_either_could_not_fit(methods):
    first, second = methods[:2]
    duel = compare(first, second)
    assert_allclose(duel.second / duel.first, 2)
    assert (duel.wins, duel.n) == (1.0, 28)
    holed = second.sse_61.copy()
    holed[0, 0] = np.nan
    duel = compare(first, dataclasses.replace(second, sse_61=holed))
    assert duel.n == 27
    assert_allclose(duel.first, first.sse_61.ravel()[1:].mean())
