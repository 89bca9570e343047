"""The colour error that a fit's covariance implies, against its linearisation."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import fit_skin, load_archive, skin_model
from skinviz.errors import ArgumentError
from skinviz.spectra.archive_selection import select
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab
from skinviz.study.colour_error import colour_error, difference_interval


@pytest.fixture(scope="module")
def fit():
    archive = select(load_archive("issa"), site="back of hand", origin="China")
    model = skin_model(site="back of hand", specular=archive.attrs["specular"])
    spectra = archive.reflectance.values[:24]
    return fit_skin(spectra, archive.wavelength.values, model)


def lab_of(fit, values, illuminant="D65"):
    bands = fit.wavelengths
    white = spectrum_to_xyz(np.ones(bands.size), bands, illuminant)
    reflectance = fit.model.measured(values, bands)
    return xyz_to_lab(spectrum_to_xyz(reflectance, bands, illuminant), white)


def slopes(fit):
    """Return dLab/dparameter (m, 3, p) by central differences."""
    p = len(fit.parameters)
    step = 1e-5 * np.maximum(fit.values, 1e-6)
    columns = []
    for k in range(p):
        move = np.where(np.arange(p) == k, step, 0)
        low, high = fit.values - move, fit.values + move
        apart = lab_of(fit, high) - lab_of(fit, low)
        columns.append(apart / (2 * step[:, k])[:, None])
    return np.stack(columns, axis=-1)


def inside(fit):
    """Return the fits none of whose draws reach a bound, errors made 30 times less."""
    deviation = np.sqrt(np.einsum("mpp->mp", fit.covariance))
    far = (fit.values > 6 * deviation / 30).all(axis=1) & (fit.status == "converged")
    return fit[np.flatnonzero(far)]


def test_small_errors_follow_the_linearised_model(fit):
    own = inside(fit)
    small = dataclasses.replace(own, covariance=own.covariance * 1e-4)
    error = colour_error(small, draws=20_000, seed=3)
    J = slopes(own)
    expected = J @ small.covariance @ np.swapaxes(J, -1, -2)
    size = np.sqrt(np.einsum("mpp->mp", expected))
    unit = size[:, :, None] * size[:, None, :]
    # 20,000 draws give a variance to 1 %, three of which are allowed.
    assert_allclose(error.covariance / unit, expected / unit, atol=0.035)
    assert_allclose(error.lab, lab_of(own, own.values), rtol=1e-12)
    # ΔE00 of Gaussian colours drawn from the linearised covariance.
    rng = np.random.default_rng(8)
    roots = np.linalg.cholesky(expected + 1e-18 * np.eye(3))
    normal = rng.standard_normal((len(roots), 20_000, 3))
    drawn = error.lab[:, None] + normal @ np.swapaxes(roots, -1, -2)
    apart = delta_e_2000(error.lab[:, None], drawn)
    assert_allclose(error.delta_e, np.quantile(apart, 0.95, axis=1), rtol=0.04)


def test_the_ellipse_holds_95_percent_of_the_draws(fit):
    own = inside(fit)
    small = dataclasses.replace(own, covariance=own.covariance * 1e-3)
    error = colour_error(small, draws=20_000)
    radii, angle = error.ellipse()
    assert (radii[:, 0] >= radii[:, 1]).all()
    away = error.samples[..., 1:] - error.lab[:, None, 1:]
    turn = np.stack(
        [np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=-1
    ).reshape(-1, 2, 2)
    within = (((away @ turn) / radii[:, None]) ** 2).sum(axis=-1) <= 1
    assert_allclose(within.mean(axis=1), 0.95, atol=0.006)


def test_a_certain_fit_has_no_error_and_its_difference_is_delta_e(fit):
    sure = dataclasses.replace(fit, covariance=np.zeros_like(fit.covariance))
    error = colour_error(sure, draws=5)
    assert_allclose(error.delta_e, 0, atol=1e-7)
    first, second = (colour_error(sure[i], draws=5) for i in (0, 1))
    apart = delta_e_2000(first.lab, second.lab)
    assert_allclose(difference_interval(first, second), apart, rtol=1e-9)


def test_seeds_and_batches(fit):
    one, same = (colour_error(fit, draws=50, seed=1) for _ in range(2))
    assert_array_equal(one.samples, same.samples)
    assert not np.array_equal(one.samples, colour_error(fit, draws=50, seed=2).samples)
    assert one.delta_e.shape == fit.status.shape
    # Draws of different spectra are independent of each other.
    unit = one.samples - one.samples.mean(axis=1, keepdims=True)
    unit /= unit.std(axis=1, keepdims=True)
    assert abs((unit[0, :, 0] * unit[1, :, 0]).mean()) < 0.6


def test_bounds_refusals_and_the_undetermined(fit):
    wide = dataclasses.replace(fit, covariance=fit.covariance * 1e4)
    assert np.isfinite(colour_error(wide, draws=20).samples).all()
    spectra = np.stack([fit.fitted[0], np.full(fit.wavelengths.size, np.nan)])
    broken = fit_skin(spectra, fit.wavelengths, fit.model)
    error = colour_error(broken, draws=20)
    assert np.isfinite(error.delta_e[0])
    assert np.isnan(error.delta_e[1])
    loose = fit.covariance.copy()
    loose[:, 2, 2] = np.inf
    assert np.isinf(
        colour_error(dataclasses.replace(fit, covariance=loose)).delta_e
    ).all()


def test_another_light_and_other_wavelengths(fit):
    under_a = colour_error(fit, illuminant="A", draws=20)
    assert_allclose(under_a.lab, lab_of(fit, fit.values, "A"), rtol=1e-12)
    fine = colour_error(fit, fit.model, np.arange(400.0, 701, 5), "D65", draws=20)
    assert delta_e_2000(fine.lab, lab_of(fit, fit.values)).max() < 0.2


def test_wrong_use_is_told(fit):
    other = skin_model("lambert-beer", site="cheek", specular="included")
    with pytest.raises(ArgumentError, match="w_m, w_h, w_dh"):
        colour_error(fit, other)
    with pytest.raises(ArgumentError, match="draws"):
        colour_error(fit, draws=1)
