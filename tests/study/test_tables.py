"""Tables II and III: what is computed, and what the script makes of it."""

import csv
import dataclasses
import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import fit_skin, load_archive, skin_model, skin_models
from skinviz.study.people import people_at
from skinviz.study.tables import (
    COEFFICIENTS,
    PAPER_ERRORS,
    PAPER_WEIGHTS,
    SITES,
    compare,
    fit_people,
    order_agreement,
)

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def everyone():
    return people_at(load_archive("issa"), SITES)


@pytest.fixture(scope="module")
def script():
    return runpy.run_path(str(ROOT / "scripts" / "tables_2_and_3.py"))


def part(people, which):
    """Return some of the people."""
    return dataclasses.replace(
        people,
        names=tuple(people.names[i] for i in which),
        descriptions=tuple(people.descriptions[i] for i in which),
        reflectance=people.reflectance[which],
    )


@pytest.fixture(scope="module")
def seven(everyone):
    return part(everyone, list(range(0, 598, 90)))


@pytest.fixture(scope="module")
def methods(seven):
    own = [fit_people(seven, "two-layer", name) for name in COEFFICIENTS]
    worse = [
        dataclasses.replace(m, model="worse", sse_61=m.sse_61 * 2, status=m.status)
        for m in own
    ]
    return [own[0], worse[0], own[1], worse[1]]


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


def test_subjects_are_chosen_by_colour_alone(everyone, script):
    subjects = script["choose"](everyone)
    angles = everyone.typology_angle("inner arm")
    for subject, quantile in (("A", 0.9), ("B", 0.5), ("C", 0.1)):
        rank = (angles < angles[subjects[subject]]).mean()
        assert abs(rank - quantile) < 0.005


def test_tables_have_the_papers_layout_for_every_method(seven, methods, script):
    subjects = {"A": 0, "B": 3, "C": 6}
    head, *rows = script["table_3"](seven, subjects, methods)
    assert head[4:] == list(SITES)
    assert len(rows) == 2 * 5 * 2
    by = {(row[0], row[1], row[3]): [float(x) for x in row[4:]] for row in rows}
    average = [by["effective", s, "two-layer"] for s in "ABC"]
    assert_allclose(
        by["effective", "average", "two-layer"], np.mean(average, axis=0), atol=1e-4
    )
    assert_allclose(
        by["textbook", "mean", "worse"], 2 * methods[2].sse_61.mean(axis=0), atol=1e-4
    )
    head, *rows = script["table_2"](seven, subjects, methods)
    assert len(rows) == 4 * (3 + 1) * 4 * 3
    found = [float(r[7]) for r in rows if r[:3] == ["effective", "two-layer", "B"]]
    assert_allclose(found, methods[0].values[3].ravel(), rtol=1e-5)


def test_the_page_ranks_by_the_numbers_it_was_given(seven, methods, script):
    subjects = {"A": 0, "B": 3, "C": 6}
    text = script["page"](seven, subjects, methods)
    assert "`effective`: `two-layer` beats `worse`" in text
    assert "a ratio of 2.00; it fits 100% of 28 spectra better" in text
    better = [
        dataclasses.replace(m, sse_61=m.sse_61 / 4) if m.model == "worse" else m
        for m in methods
    ]
    text = script["page"](seven, subjects, better)
    assert "`textbook`: `two-layer` does not beat `worse`" in text
    assert "no other model" in script["page"](seven, subjects, methods[::2])
    for fact in ("61/31", "specular included", "cannot be compared", "7 people"):
        assert fact in text


def test_the_tables_in_the_docs_are_of_this_version(everyone, script):
    """If this fails, run ``python scripts/tables_2_and_3.py``."""
    text = (ROOT / "docs" / "tables" / "table_3.csv").read_text("utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    assert {row["model"] for row in rows} == set(skin_models())
    chosen = part(everyone, list(script["choose"](everyone).values()))
    for model in skin_models():
        for coefficients in COEFFICIENTS:
            errors = fit_people(chosen, model, coefficients).sse_61
            written = [
                [float(row[site]) for site in SITES]
                for row in rows
                if (row["model"], row["coefficients"]) == (model, coefficients)
                and row["subject"] in "ABC"
            ]
            assert_allclose(written, errors, atol=1e-4)
    people = [row["person"] for row in rows if row["subject"] in "ABC"]
    assert_array_equal(np.unique(people), np.unique(chosen.names))


def test_the_script_writes_all_its_files(seven, methods, script, tmp_path, monkeypatch):
    main = script["main"]
    monkeypatch.setitem(main.__globals__, "people_at", lambda *_: seven)
    main(tmp_path)
    written = sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*.*"))
    assert written == [
        "tables.md",
        "tables/table_2.csv",
        "tables/table_2.txt",
        "tables/table_3.csv",
        "tables/table_3.txt",
    ]
    assert "two-layer, effective" in (tmp_path / "tables/table_2.txt").read_text(
        "utf-8"
    )
