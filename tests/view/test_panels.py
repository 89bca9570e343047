"""Panels draw the numbers that they are given; seen from the artists, not pixels."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from skinviz.rendering.shade import VertexSpectrum, vertex_spectrum
from skinviz.view import panels


@pytest.fixture
def axes():
    return Figure(figsize=(4, 3), dpi=100).add_subplot()


def line(axes, label):
    (found,) = [line for line in axes.lines if line.get_label() == label]
    return found.get_xdata(), found.get_ydata()


def test_reflectance_curves_are_the_data_and_the_fit(axes, sites):
    site = sites[0]
    panels.reflectance_panel(axes, site.measured, site.fit)
    for label, expected in (("measured", site.measured), ("fitted", site.fit.fitted)):
        x, y = line(axes, label)
        np.testing.assert_array_equal(x, site.fit.wavelengths)
        np.testing.assert_array_equal(y, expected)
    assert axes.get_xlim() == (400, 700)
    low, high = axes.get_ylim()
    assert low == 0
    assert high > max(site.measured.max(), site.fit.fitted.max())
    assert axes.get_ylabel() == "reflectance"
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["measured", "fitted"]


def test_residuals_are_measured_minus_fitted(axes, sites):
    site = sites[1]
    panels.residual_panel(axes, site.measured, site.fit)
    (points,) = [line for line in axes.lines if line.get_marker() == "o"]
    np.testing.assert_array_equal(points.get_ydata(), site.measured - site.fit.fitted)
    low, high = axes.get_ylim()
    assert low == -high
    assert high > np.abs(points.get_ydata()).max()
    assert axes.get_xlim() == (400, 700)
    assert axes.get_xlabel() == "wavelength (nm)"


def test_a_band_that_was_not_measured_leaves_a_gap(axes, sites):
    measured = sites[0].measured.copy()
    measured[3] = np.nan
    panels.reflectance_panel(axes, measured, sites[0].fit)
    assert np.isnan(line(axes, "measured")[1][3])
    other = Figure().add_subplot()
    panels.residual_panel(other, measured, sites[0].fit)
    assert np.isfinite(other.get_ylim()).all()


def test_radiance_is_drawn_in_units_of_white_with_its_parts(axes, scene):
    spectrum = vertex_spectrum(scene, 10)
    panels.radiance_panel(axes, spectrum)
    unit = spectrum.white[np.argmin(np.abs(spectrum.wavelengths - 560))]
    total, diffuse, specular = (
        line(axes, label)[1] for label in ("total", "diffuse", "specular")
    )
    np.testing.assert_allclose(diffuse, spectrum.diffuse / unit, rtol=1e-12)
    np.testing.assert_allclose(specular, spectrum.specular / unit, rtol=1e-12)
    np.testing.assert_allclose(total, diffuse + specular, rtol=1e-12)
    assert axes.get_xlim() == (400, 700)
    assert axes.get_ylim()[0] == 0
    assert axes.get_ylim()[1] > total.max()


def test_a_vertex_in_the_dark_is_drawn_as_zero(axes, scene):
    zero = np.zeros(61)
    spectrum = VertexSpectrum(scene.wavelengths, zero, zero, np.ones(61))
    panels.radiance_panel(axes, spectrum)
    assert (line(axes, "total")[1] == 0).all()
    assert axes.get_ylim() == (0, 1)


def test_a_light_without_power_at_560_nm_still_has_a_unit(axes, scene):
    white = np.where(scene.wavelengths > 600, 2.0, 0.0)
    spectrum = VertexSpectrum(scene.wavelengths, 0.5 * white, 0 * white, white)
    panels.radiance_panel(axes, spectrum)
    assert line(axes, "total")[1].max() == pytest.approx(0.5)


def test_curves_differ_in_more_than_colour(axes, scene):
    panels.radiance_panel(axes, vertex_spectrum(scene, 10))
    styles = {line.get_linestyle() for line in axes.lines}
    assert len(styles) == len(axes.lines) == 3


def test_the_wavelength_axis_is_ticked_every_50_nm(axes):
    panels.wavelength_axis(axes)
    np.testing.assert_array_equal(axes.get_xticks(), np.arange(400, 701, 50))
    assert axes.get_xlim() == (400, 700)
    other = Figure().add_subplot()
    panels.wavelength_axis(other, labelled=False)
    assert other.get_xlabel() == ""
    assert other.get_xlim() == (400, 700)


def test_the_strip_under_the_axis_runs_over_the_same_wavelengths(axes):
    panels.wavelength_axis(axes)
    (strip,) = axes.child_axes
    left, right, _, _ = strip.images[0].get_extent()
    assert (left, right) == (400, 700)
    assert strip.get_position().width == pytest.approx(axes.get_position().width)


def test_spectral_colours_go_from_blue_over_green_to_red():
    wavelengths = np.linspace(400, 700, 301)
    colours = panels.spectral_colours(wavelengths)
    assert colours.shape == (301, 3)
    assert colours.min() >= 0
    assert colours.max() <= 1
    strongest = {nm: int(colours[nm - 400].argmax()) for nm in (450, 530, 640)}
    assert strongest == {450: 2, 530: 1, 640: 0}
    # No edges: neighbours a nanometre apart look alike.
    assert np.abs(np.diff(colours, axis=0)).max() < 0.04


def test_swatches_are_the_colours_under_d65(sites):
    site = sites[0]
    measured, fitted = panels.swatch_colours(site.fit, site.measured)
    for colour in (measured, fitted):
        assert colour.shape == (3,)
        assert 1 > colour[0] > colour[1] > colour[2] > 0  # skin
    same, again = panels.swatch_colours(site.fit, site.fit.fitted)
    np.testing.assert_array_equal(same, again)
    np.testing.assert_array_equal(again, fitted)
    white, _ = panels.swatch_colours(site.fit, np.ones_like(site.measured))
    np.testing.assert_allclose(white, 1, atol=0.003)


def test_weights_are_told_with_their_intervals(sites):
    fit = sites[0].fit
    lines = panels.weights_text(fit).splitlines()
    assert len(lines) == len(fit.parameters) == 3
    for text, value, (low, high) in zip(lines, fit.values, fit.interval, strict=True):
        for number in (value, low, high):
            assert f"{number:.4f}" in text
    names = ("w_m", "w_h", "w_{dh}")
    assert all(name in text for name, text in zip(names, lines, strict=True))
