"""Hands of a comparison: whose they are, one scale, the surface of their readings."""

import dataclasses

import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of

from skinviz import compare_study, read_mesh, read_study, write_mesh
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.spectra.archive_selection import select
from skinviz.study.study import Shape
from skinviz.view.comparison_hands import comparison_hands

BACKGROUND = 46


def pictures_of(figure):
    """Return the pictures of a figure by what stands above them."""
    return {
        axes.texts[0].get_text(): axes.images[0].get_array()
        for axes in figure.axes
        if axes.images and axes.images[0].get_array().shape[0] > 10
    }


@pytest.fixture(scope="module")
def study():
    """Two people of the example at one site, before sun."""
    own = read_study("docs/examples/study")
    few = select(own.spectra, subject=["A", "B"], site="back of hand")
    before = few.isel(record=np.flatnonzero(few["condition"].values == "before"))
    return dataclasses.replace(own, spectra=before)


@pytest.fixture(scope="module")
def small(study, tmp_path_factory):
    """The same, with a hand of A's own that is 0.7 times as large."""
    mesh = read_mesh(shipped_mesh(TRUE_SHAPE), "m").copy()
    mesh.points *= 0.7
    path = write_mesh(tmp_path_factory.mktemp("hand") / "A.ply", mesh)
    shapes = {"A": Shape(path, None, raw=False)}
    return dataclasses.replace(study, shapes=shapes, gonio={})


def test_a_subjects_own_hand_is_drawn_at_the_common_scale(small):
    told = []
    made = comparison_hands(compare_study(small, "subject"), advance=told.append)
    assert told == [1, 1]
    assert made.notes == ()
    own = {
        name: (picture.max(axis=-1) > 1.3 * BACKGROUND).sum()
        for name, picture in pictures_of(made.figure).items()
    }
    assert own["A"] / own["B"] == pytest.approx(0.7**2, rel=0.03)
    texts = texts_of(made.figure)
    check_inside(made.figure, texts)
    check_apart(texts)
    assert any(
        "own hands of A and the MakeHuman hand" in t.replace("\n", " ")
        for t, _ in texts
    )


def test_the_lobe_of_a_subjects_readings_is_used(study):
    found = compare_study(study, "subject")
    usual = dataclasses.replace(found, study=dataclasses.replace(study, gonio={}))
    with_lobe, without = (
        pictures_of(comparison_hands(f).figure) for f in (found, usual)
    )
    assert not np.array_equal(with_lobe["A"], without["A"])
    assert np.array_equal(with_lobe["B"], without["B"])
