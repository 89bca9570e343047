"""Hands side by side: one scale and one exposure, every word readable."""

import dataclasses

import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of

from meshes import sphere
from skinviz.errors import ArgumentError
from skinviz.view.hands_grid import Hand, grid_figure, render_linked


@pytest.fixture(scope="module")
def pictures(scene):
    small, large = scene, scene.replace(mesh=sphere(60, 2), exposure=3.0)
    camera = dataclasses.replace(scene.camera, size=(30, 40))
    return render_linked([small.replace(camera=camera), large], exposure=1.5)


def test_scale_size_and_exposure_are_shared(pictures):
    assert {p.size for p in pictures} == {(30, 40)}
    assert {p.scene.exposure for p in pictures} == {1.5}
    assert pictures[0].view.pixel == pictures[1].view.pixel
    widths = [(p.covered > 0).any(axis=0).sum() for p in pictures]
    assert widths[1] / widths[0] == pytest.approx(60 / 40, rel=0.1)


def test_a_shared_exposure_keeps_ratios(scene, pictures):
    (alone,) = render_linked([pictures[0].scene], exposure=0.75)
    middle = np.s_[20, 15]
    np.testing.assert_allclose(
        pictures[0].xyz[middle], 2 * alone.xyz[middle], rtol=0.02
    )


def test_progress_is_told(scene):
    told = []
    camera = dataclasses.replace(scene.camera, size=(12, 16))
    render_linked([scene.replace(camera=camera)] * 3, advance=told.append)
    assert told == [1, 1, 1]


def grid(pictures, n_rows=3, n_columns=4):
    hand = Hand(
        pictures[0].rgb,
        "China/186",
        [np.array([0.5, 0.4, 0.3]), np.array([0.8, 0.7, 0.6])],
        ["L* 55.2 a* 12.0 b* 15.1", "± 0.7 ΔE00"],
    )
    rows = [[hand] * n_columns for _ in range(n_rows)]
    rows[1][2] = None
    return rows


@pytest.mark.parametrize("width", [4.2, 7.0, 11.2])
def test_every_word_can_be_read(pictures, width):
    figure = grid_figure(
        grid(pictures),
        width,
        pixel=pictures[0].view.pixel,
        row_labels=["melanin × 0.5", "melanin × 1", "melanin × 2"],
        column_labels=[f"oxyhaemoglobin × {k}" for k in (0.5, 1, 2, 4)],
        title="Hands with several amounts of melanin and oxyhaemoglobin",
        caption="Spectra: somebody, CC BY 4.0. " * 6,
    )
    texts = texts_of(figure)
    check_inside(figure, texts)
    check_apart(texts)
    assert any(text.endswith(" mm") for text, _ in texts)


def test_pictures_are_shown_as_they_are(pictures):
    rows = [[Hand(p.rgb) for p in pictures]]
    figure = grid_figure(rows, 5.0, pixel=1.0)
    shown = [axes.images[0].get_array() for axes in figure.axes if axes.images]
    for own, picture in zip(shown, pictures, strict=True):
        np.testing.assert_array_equal(own, picture.rgb)
    for axes in figure.axes:
        box = axes.get_window_extent()
        assert box.height / box.width == pytest.approx(40 / 30, rel=1e-6)


def test_wrong_grids_are_told(pictures, scene):
    hand = Hand(pictures[0].rgb)
    other = Hand(pictures[0].rgb[:-1])
    with pytest.raises(ArgumentError, match="one size"):
        grid_figure([[hand, other]], 5.0, pixel=1.0)
    with pytest.raises(ArgumentError, match="one size"):
        grid_figure([[None]], 5.0, pixel=1.0)
    with pytest.raises(ArgumentError, match="equal length"):
        grid_figure([[hand, hand], [hand]], 5.0, pixel=1.0)
    with pytest.raises(ArgumentError, match="row_labels must be 1"):
        grid_figure([[hand]], 5.0, pixel=1.0, row_labels=["a", "b"])
    with pytest.raises(ArgumentError, match="no scene"):
        render_linked([])
