"""A comparison's figures: what they show is what was found, every word readable."""

import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of
from numpy.testing import assert_allclose

from skinviz import archive_study, compare_study, read_study
from skinviz.spectra.colorimetry import encode_srgb, xyz_to_linear_srgb
from skinviz.view.comparison_colours import colours_figure, colours_within
from skinviz.view.comparison_figures import (
    comparison_figures,
    spectra_figure,
    weights_figure,
)


@pytest.fixture(scope="module")
def sun():
    return compare_study(read_study("docs/examples/study"), "condition")


@pytest.fixture(scope="module")
def people():
    return compare_study(read_study("docs/examples/study"), "subject")


@pytest.fixture(scope="module")
def groups():
    return compare_study(archive_study("issa", site=["cheek", "inner arm"]), "group")


@pytest.mark.parametrize(
    ("name", "width"),
    [("sun", 4.0), ("sun", 9.0), ("people", 5.0), ("groups", 4.0), ("groups", 16.0)],
)
def test_every_word_can_be_read(request, name, width):
    found = request.getfixturevalue(name)
    figures = comparison_figures(found, "Somebody et al., CC BY 4.0. " * 3, width)
    assert list(figures) == ["spectra", "weights", "colours"]
    for figure in figures.values():
        texts = texts_of(figure)
        check_inside(figure, texts)
        check_apart(texts)
        assert figure.get_size_inches()[0] == width


def test_curves_are_the_mean_spectra_on_one_scale(sun):
    panels = [a for a in spectra_figure(sun).axes if a.get_ylabel() == "reflectance"]
    assert len({axes.get_ylim() for axes in panels}) == 1
    for stratum, axes in zip(sun.strata, panels, strict=True):
        assert axes.get_title() == str(stratum)
        curves = [own for own in axes.lines if own.get_label()[0] != "_"]
        for cell, curve in zip(sun.row(stratum), curves, strict=True):
            assert_allclose(curve.get_ydata(), cell.mean_spectrum, rtol=1e-12)


def test_marks_stand_at_the_means_and_lines_span_their_intervals(sun):
    figure = weights_figure(sun)
    panels = [axes for axes in figure.axes if axes.get_xlabel()]
    assert [axes.get_xlabel() for axes in panels][:3] == ["w_m", "w_h", "w_dh"]
    for k, axes in enumerate(panels):
        spans = [own.get_xdata() for own in axes.lines if len(own.get_xdata()) == 2]
        expected = [
            [cell.means[k].low, cell.means[k].high]
            for stratum in sun.strata
            for cell in sun.row(stratum)
        ]
        assert_allclose(spans, expected, rtol=1e-12)


def test_swatches_show_what_was_measured_and_how_far_the_fit_reaches(sun):
    figure = colours_figure(sun)
    patches = [
        image.get_array()
        for image in figure.axes[0].images
        if image.get_array().shape == (1, 4, 3)
    ]
    for cell, patch in zip(sun.row(sun.strata[0]), patches, strict=True):
        measured = encode_srgb(xyz_to_linear_srgb(cell.fit.xyz[0]))
        assert_allclose(patch[0, 0], measured, rtol=1e-12)
        assert_allclose(patch[0, 1:], colours_within(cell), rtol=1e-12)


def test_the_ends_of_a_swatch_are_95_percent_of_the_draws_apart(groups):
    for cell in groups.cells:
        low, middle, high = colours_within(cell)
        assert_allclose(
            middle, encode_srgb(xyz_to_linear_srgb(cell.fit.xyz[1])), atol=2e-3
        )
        along = cell.colour.samples - cell.colour.samples.mean(axis=0)
        variances, axes = np.linalg.eigh(np.cov(along.T))
        inside = np.abs(along @ axes[:, -1]) < 1.96 * np.sqrt(variances[-1])
        assert inside.mean() == pytest.approx(0.95, abs=0.02)
        assert np.abs(high - low).max() > 0


def test_the_matrix_has_measured_above_and_fitted_below(groups):
    figure = colours_figure(groups)
    axes = next(a for a in figure.axes if a.get_title().startswith("ΔE00"))
    values = axes.images[0].get_array()
    own = [c for c in groups.colours if c.stratum == groups.strata[0]]
    for c in own:
        i, j = groups.levels.index(c.first), groups.levels.index(c.second)
        assert values[i, j] == c.delta_e
        assert values[j, i] == c.fitted
    assert np.ma.getmaskarray(values).diagonal().all()


def test_figures_of_many_levels_show_the_first():
    found = compare_study(archive_study("issa", origin="Spain"), "subject")
    assert len(found.levels) > 12
    figures = comparison_figures(found, "")
    texts = [text for text, _ in texts_of(figures["weights"])]
    assert found.levels[11] in texts
    assert found.levels[12] not in texts
    for figure in figures.values():
        shown = texts_of(figure)
        check_inside(figure, shown)
        check_apart(shown)
