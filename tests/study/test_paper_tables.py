"""The rows of Tables I to III, and the page that shows them."""

import csv
import dataclasses
import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from study_people import part

from skinviz import skin_models
from skinviz.study.orders import paired_contrast
from skinviz.study.paper_tables import (
    CLAIMS,
    PER_AREA,
    choose_subjects,
    claims,
    in_papers_layout,
    orders,
    table_1,
    table_2,
    table_3,
)
from skinviz.study.tables import COEFFICIENTS, SITES, fit_people

ROOT = Path(__file__).parents[2]
SUBJECTS = {"A": 0, "B": 3, "C": 6}


@pytest.fixture(scope="module")
def script():
    return runpy.run_path(str(ROOT / "scripts" / "tables_2_and_3.py"))


def test_subjects_are_chosen_by_colour_alone(everyone):
    subjects = choose_subjects(everyone)
    angles = everyone.typology_angle("inner arm")
    for subject, quantile in (("A", 0.9), ("B", 0.5), ("C", 0.1)):
        rank = (angles < angles[subjects[subject]]).mean()
        assert abs(rank - quantile) < 0.005


def test_table_1_is_as_printed():
    table = table_1().set_index("site")
    assert table.loc["cheek"].tolist() == [0.027, 1.491]
    assert table.loc["inner arm"].tolist() == [0.041, 1.294]


def test_table_2_holds_weights_and_means(seven, methods):
    table = table_2(seven, SUBJECTS, methods)
    assert len(table) == 4 * (3 + 1) * 4 * 3
    own = table[
        (table["coefficients"] == "effective") & (table["model"] == "two-layer")
    ]
    found = own[own["subject"] == "B"]["value"]
    assert_allclose(found, methods[0].values[3].ravel())
    means = own[own["subject"] == "mean"]["value"]
    assert_allclose(means, methods[0].values.mean(axis=0).ravel())
    bounded = own[own["subject"] != "mean"]
    assert (bounded["lower"] <= bounded["value"]).all()
    assert (bounded["value"] <= bounded["upper"]).all()


def test_the_papers_layout_has_sites_down_and_weights_across(seven, methods):
    blocks = in_papers_layout(table_2(seven, SUBJECTS, methods))
    assert list(blocks)[:2] == ["two-layer, effective", "worse, effective"]
    block = blocks["two-layer, textbook"]
    assert list(block.columns) == ["subject", "site", "w_m", "w_h", "w_dh", "status"]
    assert block["site"].tolist() == list(SITES) * 4
    assert_allclose(block["w_h"][4:8], methods[2].parameter("w_h")[3])
    assert "at_bound" not in set(block["status"])


def test_table_3_averages_errors(seven, methods):
    table = table_3(seven, SUBJECTS, methods)
    assert list(table.columns[4:]) == list(SITES)
    assert len(table) == 2 * 5 * 2
    by = table.set_index(["coefficients", "subject", "model"])[list(SITES)]
    average = [by.loc["effective", s, "two-layer"] for s in "ABC"]
    assert_allclose(
        by.loc["effective", "average", "two-layer"], np.mean(average, axis=0)
    )
    assert_allclose(
        by.loc["textbook", "mean", "worse"], 2 * methods[2].sse_61.mean(axis=0)
    )


def test_orders_of_means_are_written_out(methods):
    table = orders(SUBJECTS, methods)
    row = table.iloc[0]
    mean = methods[0].parameter("w_m").mean(axis=0)
    assert row["order of the means"].split(" > ")[0] == SITES[int(np.argmax(mean))]
    assert table["everyone"].between(0, 1).all()


def test_claims_are_paired_contrasts_corrected_within_a_method(seven, methods):
    table = claims(seven, methods)
    assert len(table) == 4 * (len(CLAIMS) + 2) * 3
    cheek, hand = (methods[0].parameter("w_m")[:, s] for s in (0, 1))
    row = table.iloc[0]
    assert (row["site"], row["against"]) == ("cheek", "back of hand")
    contrast = paired_contrast(cheek, hand)
    assert (row["p"], row["difference"]) == (contrast.p, contrast.difference)
    first = table.iloc[:15]
    assert (first["p_corrected"] >= first["p"]).all()
    assert first["p_corrected"].min() == pytest.approx(15 * first["p"].min())
    area = table[table["quantity"] == PER_AREA].iloc[0]
    own = paired_contrast(0.027 * cheek, 0.035 * hand)
    assert area["difference"] == pytest.approx(own.difference)


def test_the_archive_bears_out_the_papers_orders_but_for_thickness(everyone):
    table = claims(everyone, [fit_people(everyone, "two-layer", "effective")])
    told = table.groupby(["quantity", "site"])["verdict"].first()
    assert told["w_m", "cheek"] == told["w_m", "inner arm"] == "holds"
    assert told["w_h", "cheek"] == "holds"
    assert told[PER_AREA, "cheek"] == "contradicted"


def test_the_page_ranks_by_the_numbers_it_was_given(methods, script):
    text = script["duels"](methods)
    assert "`effective`: `two-layer` beats `worse`" in text
    assert "a ratio of 2.00; it fits 100% of 28 spectra better" in text
    better = [
        dataclasses.replace(m, sse_61=m.sse_61 / 4) if m.model == "worse" else m
        for m in methods
    ]
    assert "`textbook`: `two-layer` does not beat `worse`" in script["duels"](better)
    assert "no other model" in script["duels"](methods[::2])


def test_a_verdict_comes_with_the_p_that_decides_it(seven, methods, script):
    table = claims(seven, methods).iloc[:3].copy()
    table["claim"], table["effect"] = "most", [0.5, -0.4, 0.3]
    table["p_corrected"], table["verdict"] = [1e-9, 2e-3, 1e-4], "contradicted"
    assert script["verdict_of"](table) == "contradicted, p = 2e-03"
    table["verdict"] = "open"
    assert script["verdict_of"](table) == "open, p = 2e-03"
    table["p_corrected"], table["verdict"] = [1e-9, 1e-4, 1e-3], "holds"
    assert script["verdict_of"](table) == "holds, p = 1e-03"


def test_the_tables_in_the_docs_are_of_this_version(everyone):
    """If this fails, run ``python scripts/tables_2_and_3.py``."""
    text = (ROOT / "docs" / "tables" / "table_3.csv").read_text("utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    assert {row["model"] for row in rows} == set(skin_models())
    chosen = part(everyone, list(choose_subjects(everyone).values()))
    for model in skin_models():
        for coefficients in COEFFICIENTS:
            errors = fit_people(chosen, model, coefficients).sse_61
            written = [
                [float(row[site]) for site in SITES]
                for row in rows
                if (row["model"], row["coefficients"]) == (model, coefficients)
                and row["subject"] in "ABC"
            ]
            assert_allclose(written, errors, atol=1e-5)
    people = [row["person"] for row in rows if row["subject"] in "ABC"]
    assert_array_equal(np.unique(people), np.unique(chosen.names))


def test_the_script_writes_all_its_files(script, tmp_path):
    script["main"](tmp_path)
    written = sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*.*"))
    assert written == [
        "tables.md",
        "tables/table_2.csv",
        "tables/table_2.txt",
        "tables/table_2_claims.csv",
        "tables/table_2_orders.csv",
        "tables/table_3.csv",
        "tables/table_3.txt",
    ]
    text = (tmp_path / "tables" / "table_2.txt").read_text("utf-8")
    assert "two-layer, effective" in text
    page = (tmp_path / "tables.md").read_text("utf-8")
    for fact in ("61/31", "specular included", "cannot be compared", "598 people"):
        assert fact in page
    assert "| holds, p = " in page
