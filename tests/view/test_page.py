"""Pages laid out in inches: every word readable at any width."""

import matplotlib as mpl
import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of

from skinviz.errors import ArgumentError
from skinviz.view.page import STYLE, Cells, inches_of, lay_out
from skinviz.view.spectra_panels import ROW, Swatch, band_of, bands_panel, swatch_rows
from skinviz.view.styles import LINES, line

NM = np.arange(400.0, 701, 10)
NAMES = ("Sub-Saharan African", "South Asian", "Arab", "Chinese", "Caucasian", "Thai")


def spectra(k):
    rng = np.random.default_rng(k)
    own = (0.15 + 0.08 * k) * (1 + (NM - 400) / 300) / 2
    return own + 0.02 * rng.standard_normal((9, NM.size))


def a_page(width):
    with mpl.rc_context(STYLE):
        page = lay_out(
            width,
            [
                Cells(3, (1.6, 0.7)),
                Cells(1, (ROW * 3,), least=1.6),
            ],
            title="What the skin of some people reflects at three sites",
            legend=NAMES,
            caption="Mean ± standard deviation. Somebody et al., CC BY 4.0. " * 4,
        )
        for axes in page.panels():
            handles = bands_panel(
                axes, NM, [band_of(n, spectra(k)) for k, n in enumerate(NAMES)]
            )
            axes.set_title("back of hand")
        page.legend(handles, NAMES)
        for axes in page.panels(panel=1):
            axes.set_axis_off()
        swatches = [
            Swatch(n, np.full(3, 0.2 * k), np.array([60.1, 12.3, 18.4]), 0.8)
            for k, n in enumerate(NAMES[:3])
        ]
        swatch_rows(page.panels(1)[0], swatches)
    return page


@pytest.mark.parametrize("width", [3.4, 4.2, 7.0, 11.2])
def test_every_word_can_be_read(width):
    page = a_page(width)
    texts = texts_of(page.figure)
    check_inside(page.figure, texts)
    check_apart(texts)
    assert page.figure.get_size_inches()[0] == width


def test_cells_wrap_and_keep_their_heights():
    narrow, wide = a_page(3.4), a_page(11.2)
    for page, rows in ((narrow, 3), (wide, 1)):
        tops = {round(axes.get_position().y1, 6) for axes in page.panels()}
        assert len(tops) == rows
        for axes in page.panels():
            assert inches_of(axes)[1] == pytest.approx(1.6)
            assert inches_of(axes)[0] >= 1.9
    assert narrow.figure.get_figheight() > wide.figure.get_figheight()


def test_rows_are_of_like_length():
    assert Cells(4).columns(8.2) == 2  # three fit, but leave one alone
    assert Cells(6).columns(8.2) == 3


@pytest.mark.parametrize("width", [1.0, 1e3, np.nan, "wide"])
def test_impossible_widths_are_refused(width):
    with pytest.raises(ArgumentError, match="width of a figure"):
        lay_out(width, [Cells(1)])


def test_a_band_is_mean_and_standard_deviation():
    own = spectra(2)
    own[0, 3] = np.nan
    band = band_of("x", own)
    np.testing.assert_allclose(band.middle, np.nanmean(own, axis=0))
    deviation = np.nanstd(own, axis=0, ddof=1)
    np.testing.assert_allclose(band.high - band.middle, deviation)
    np.testing.assert_allclose(band.middle - band.low, deviation)
    assert band_of("x", own[:1]).low is None


def test_lines_differ_by_each_means_alone():
    for part in ("colour", "marker"):
        assert len({getattr(own, part) for own in LINES}) == len(LINES)
    assert len({str(own.dashes) for own in LINES}) == len(LINES)
    many = [line(k) for k in range(30)]
    assert len({(own.colour, str(own.dashes)) for own in many}) == 30


def test_the_strip_stays_under_its_axes_when_these_move():
    page = a_page(7.0)
    axes = page.panels()[0]
    axes.set_position((0.2, 0.5, 0.3, 0.2))
    page.figure.draw_without_rendering()
    (strip,) = axes.child_axes
    box = strip.get_window_extent()
    own = axes.get_window_extent()
    np.testing.assert_allclose([box.x0, box.x1, box.y1], [own.x0, own.x1, own.y0])
