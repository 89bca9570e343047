"""Whole figures: the right data in them, and every word readable."""

import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of
from matplotlib.figure import Figure
from PIL import Image

from skinviz.errors import SkinvizError
from skinviz.rendering.shade import vertex_spectrum
from skinviz.view.figures import (
    MarkedPoint,
    hands_figure,
    save_figure,
    sites_figure,
)

CAPTION = (
    "Two-layer Kubelka–Munk skin, Torrance–Sparrow surface, 61 wavelengths through "
    "CIE XYZ.  Spectrum: ISSA subject 186 (China); Lu et al., Sci. Data 12:487 (2025), "
    "CC BY 4.0.  Hand: MakeHuman, CC0, simulated range scan."
)
TITLE = (
    "Four body sites of ISSA subject 186 (China): measured and fitted, 95 % intervals "
    "of the weights"
)
SHORT = "Specular included (8°/sphere), 400–700 nm at 10 nm."


def hands(picture, site, scene, n_pictures=2):
    titles = ("illuminant D65, 0/0", "illuminant A, 0/0", "illuminant FL2, 60/60")
    return hands_figure(
        dict.fromkeys(titles[:n_pictures], picture),
        site,
        [MarkedPoint(np.array([5.0, 20.0, 0.0]), vertex_spectrum(scene, 10))],
        CAPTION,
    )


@pytest.fixture(scope="module", params=["hands", "dark hands", "sites", "two sites"])
def drawn(request, picture, sites, darkest, scene):
    """Each kind of figure that comes out, drawn, and the texts in it."""
    kinds = {
        "hands": lambda: hands(picture, sites[0], scene),
        "dark hands": lambda: hands(picture, darkest, scene),
        "sites": lambda: sites_figure(sites, TITLE, SHORT),
        "two sites": lambda: sites_figure([darkest, sites[1]], "Two cheeks", SHORT),
    }
    figure = kinds[request.param]()
    return figure, texts_of(figure)


# What is in them ------------------------------------------------------------


def test_hands_stand_beside_their_spectra(picture, sites, scene):
    figure = hands(picture, sites[0], scene)
    shown = [axes for axes in figure.axes if axes.images and axes.get_title()]
    titles = [axes.get_title() for axes in shown]
    assert titles == ["illuminant D65, 0/0", "illuminant A, 0/0"]
    for axes in shown:
        np.testing.assert_array_equal(axes.images[0].get_array(), picture.rgb)
    labels = [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]
    assert labels == ["reflectance", "residual", "radiance / white's"]
    measured = next(
        line
        for axes in figure.axes
        for line in axes.lines
        if line.get_label() == "measured"
    )
    np.testing.assert_array_equal(measured.get_ydata(), sites[0].measured)


def test_the_marked_point_is_where_the_picture_shows_it(picture, sites, scene):
    figure = hands(picture, sites[0], scene)
    column, row = picture.view.project([5.0, 20.0, 0.0])
    for axes in figure.axes[:2]:
        for mark in axes.lines:
            # Pixel centres lie at whole numbers in an image's axes.
            assert mark.get_xdata()[0] == pytest.approx(column, abs=0.51)
            assert mark.get_ydata()[0] == pytest.approx(row, abs=0.51)


def test_each_site_has_its_column_of_data(sites):
    figure = sites_figure(sites, TITLE, SHORT)
    curves = [axes for axes in figure.axes if axes.get_ylabel() == "reflectance"]
    assert [axes.get_title() for axes in curves] == [site.name for site in sites]
    for axes, site in zip(curves, sites, strict=True):
        by_label = {line.get_label(): line.get_ydata() for line in axes.lines}
        np.testing.assert_array_equal(by_label["measured"], site.measured)
        np.testing.assert_array_equal(by_label["fitted"], site.fit.fitted)
    # One scale for all, so that sites can be compared by eye.
    assert len({axes.get_ylim() for axes in curves}) == 1
    residuals = [axes for axes in figure.axes if axes.get_ylabel() == "residual"]
    assert len({axes.get_ylim() for axes in residuals}) == 1
    limit = residuals[0].get_ylim()[1]
    largest = max(np.abs(site.measured - site.fit.fitted).max() for site in sites)
    assert limit > largest


def test_errors_of_the_fit_are_told_as_they_are(sites):
    figure = sites_figure(sites, TITLE, SHORT)
    titles = [axes.get_title() for axes in figure.axes]
    for site in sites:
        scaled = float(site.fit.sse) * 61 / int(site.fit.n_bands)
        assert any(f"{scaled:.4f}" in title for title in titles)
        assert any(f"{float(site.fit.delta_e):.2f}" in title for title in titles)


# Whether they can be read -----------------------------------------------------


def test_no_word_is_outside_the_canvas(drawn):
    figure, texts = drawn
    assert len(texts) > 20
    check_inside(figure, texts)


def test_no_words_overlap(drawn):
    check_apart(drawn[1])


def test_no_words_lie_on_the_curves(drawn):
    figure, texts = drawn
    for axes in figure.axes:
        if axes.get_ylabel() not in ("reflectance", "radiance / white's"):
            continue
        inside = [(t, b) for t, b in texts if axes.get_window_extent().overlaps(b)]
        assert inside
        for line in axes.lines:
            x = np.linspace(400, 700, 601)
            y = np.interp(x, line.get_xdata(), line.get_ydata())
            at = axes.transData.transform(np.column_stack([x, y]))
            for text, box in inside:
                hit = (at > [box.x0, box.y0]) & (at < [box.x1, box.y1])
                assert not hit.all(axis=1).any(), f"{text!r} on {line.get_label()}"


# Whether they can be saved ------------------------------------------------------


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf", ".PDF"])
def test_figures_are_saved_in_each_format(picture, sites, scene, tmp_path, suffix):
    figure = hands(picture, sites[0], scene)
    file = save_figure(figure, tmp_path / "new" / f"figure{suffix}")
    content = file.read_bytes()
    starts = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}
    assert content.startswith(starts[suffix.lower()])
    assert [f.name for f in file.parent.iterdir()] == [f"figure{suffix}"]
    for stamp in (b"CreationDate", b"<dc:date>", b"tIME"):
        assert stamp not in content


def test_a_saved_figure_has_its_size_and_is_the_same_each_time(sites, tmp_path):
    figure = sites_figure(sites, TITLE, SHORT)
    first, second = (save_figure(figure, tmp_path / f"{i}.png") for i in range(2))
    assert first.read_bytes() == second.read_bytes()
    with Image.open(first) as image:
        expected = np.round(figure.get_size_inches() * figure.dpi)
        assert list(image.size) == expected.tolist()


@pytest.mark.parametrize("name", ["figure", "figure.foo", "figure.csv"])
def test_an_unknown_suffix_is_refused_and_nothing_written(tmp_path, name):
    figure = Figure()
    with pytest.raises(SkinvizError, match=r"\.png"):
        save_figure(figure, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_making_figures_leaves_matplotlibs_settings(picture, sites, scene):
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    hands(picture, sites[0], scene)
    sites_figure(sites, TITLE, SHORT)
    assert dict(mpl.rcParams) == before
