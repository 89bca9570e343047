"""The figure of a few fitted spectra: right data, every word readable."""

import dataclasses

import numpy as np
import pytest
from drawn_texts import check_apart, check_inside, texts_of
from rival_model import Rival

from skinviz import fit_skin
from skinviz.view.fits_figure import STYLES, FittedSpectrum, fits_figure

TITLE = "two-layer, cotton, lambert-beer, extended models, effective coefficients"
CAPTION = "specular included; /home/someone/spectra of 2024/hands and cheeks.csv"


def padded(fit, n):
    """Return a fit with n parameters more, which change no curve."""
    values, names = np.full(n, -0.1234), [f"melanin_slope{i}"[-13:] for i in range(n)]
    more = dataclasses.replace(
        fit,
        parameters=(*fit.parameters, *names),
        values=np.concatenate([fit.values, values]),
        interval=np.concatenate([fit.interval, np.stack([values, values], -1)]),
    )
    more.__dict__["fitted"] = fit.fitted  # computed when asked for, then kept
    return more


def spectrum(site, models=1, parameters=3):
    """Return a site's fit, by a model or several, padded to more parameters."""
    names = ("two-layer", "lambert-beer", "cotton", "extended")
    fits = []
    for name in names[:models]:
        fit = site.fit
        if name != "two-layer":
            named = type("Named", (Rival,), {"name": name})
            model = fit.model
            other = named(model.thickness, model.coefficients, model.specular)
            fit = fit_skin(site.measured, fit.wavelengths, other)
        fits.append(padded(fit, parameters - len(fit.parameters)))
    return FittedSpectrum(site.name, site.measured, tuple(fits))


@pytest.mark.parametrize("n", [1, 2, 4])
@pytest.mark.parametrize("models", [1, 2, 4])
@pytest.mark.parametrize("parameters", [3, 7])
def test_every_word_can_be_read(sites, n, models, parameters):
    shown = [spectrum(site, models, parameters) for site in sites[:n]]
    figure = fits_figure(shown, TITLE, CAPTION)
    texts = texts_of(figure)
    check_inside(figure, texts)
    check_apart(texts)
    for axes in figure.axes:
        if axes.get_ylabel() != "reflectance":
            continue
        legend = axes.get_legend().get_window_extent()
        for line in axes.lines:
            x = np.linspace(400, 700, 601)
            y = np.interp(x, line.get_xdata(), line.get_ydata())
            at = axes.transData.transform(np.column_stack([x, y]))
            inside = (at > legend.p0) & (at < legend.p1)
            assert not inside.all(axis=1).any(), line.get_label()


def test_curves_are_the_data_one_style_a_model(sites):
    shown = [spectrum(site, 2) for site in sites[:2]]
    figure = fits_figure(shown, TITLE, CAPTION)
    curves = [axes for axes in figure.axes if axes.get_ylabel() == "reflectance"]
    residuals = [axes for axes in figure.axes if axes.get_ylabel() == "residual"]
    for axes, below, own in zip(curves, residuals, shown, strict=True):
        lines = {line.get_label(): line for line in axes.lines}
        np.testing.assert_array_equal(lines["measured"].get_ydata(), own.measured)
        for k, fit in enumerate(own.fits):
            line = lines[fit.model.name]
            np.testing.assert_array_equal(line.get_ydata(), fit.fitted)
            assert (line.get_color(), line.get_linestyle()) == STYLES[k]
            rest = below.lines[k + 1].get_ydata()  # the first is zero
            np.testing.assert_array_equal(rest, own.measured - fit.fitted)
            assert np.abs(rest).max() < below.get_ylim()[1]
    assert len({axes.get_ylim() for axes in (*curves,)}) == 1


def test_a_refused_spectrum_is_drawn_without_a_fit(sites):
    site = sites[0]
    measured = np.full_like(site.measured, np.nan)
    fit = fit_skin(measured, site.fit.wavelengths, site.fit.model)
    figure = fits_figure([FittedSpectrum("gone", measured, (fit,))], TITLE, CAPTION)
    words = "\n".join(text for text, _ in texts_of(figure))
    assert "refused" in words


def test_a_long_name_keeps_its_end(sites):
    name = "UK3/" + "x" * 60 + " back of hand"
    own = dataclasses.replace(spectrum(sites[0]), name=name)
    titles = [axes.get_title() for axes in fits_figure([own], TITLE, CAPTION).axes]
    assert titles[0].startswith("…")
    assert titles[0].endswith(" back of hand")
