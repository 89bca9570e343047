"""Spectra that are hard to fit, or no skin's at all."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracles.best_fit import smallest_sse
from tolerances import SAME_OPTIMUM

from skinviz import ArgumentError, fit_skin, skin_model
from skinviz.skin.coefficients import body_sites, load_coefficients

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="back of hand", specular="included")
TRUTH = np.array([0.1, 0.01, 0.005])

HARD = {
    "dark": ((0.3, 0, 0), (0.8, 0.03, 0.02), 2e-3),
    "bloodless": ((0.02, 0, 0), (0.5, 3e-4, 3e-4), 2e-3),
    "pale": ((0, 0, 0), (0.02, 0.02, 0.02), 2e-3),
    "bloody": ((0, 0.05, 0.05), (0.1, 0.4, 0.4), 2e-3),
    "noisy": ((0, 0, 0), (0.3, 0.03, 0.02), 1e-2),
}
"""Weights from and to, noise."""


def table(model):
    """Return what the oracle takes of a model: table, thickness, interface."""
    at, face = load_coefficients().at(NM), model.interface
    pigments = (at.melanin, at.oxyhaemoglobin, at.deoxyhaemoglobin)
    return (
        np.stack([*pigments, at.epidermis, at.dermis]),
        model.thickness,
        (face.offset, face.transmission, face.internal),
    )


@pytest.mark.parametrize("site", body_sites())
@pytest.mark.parametrize("kind", HARD)
def test_hard_spectra_reach_the_optimum_that_scipy_finds(kind, site):
    low, high, noise = HARD[kind]
    model = skin_model(site=site, specular="included")
    rng = np.random.default_rng(sorted(HARD).index(kind))
    clean = model.measured(rng.uniform(low, high, (12, 3)), NM)
    data = np.maximum(clean + rng.normal(0, noise, clean.shape), 0)
    fit = fit_skin(data, NM, model)
    fit.raise_for_status()
    best = [smallest_sse(spectrum, *table(model)) for spectrum in data]
    assert (fit.sse <= np.array(best) * (1 + SAME_OPTIMUM)).all()


# --- no skin at all ------------------------------------------------------------

WITHIN = np.isin(NM, (450, 550, 650))


@pytest.mark.parametrize(
    ("row", "n_bands"),
    [
        (np.where(NM == 500, 0.4, np.nan), 0),
        (np.where(WITHIN, 0.4, np.nan), 0),
        (np.full(31, np.nan), 0),
        (np.where(WITHIN | (NM == 600), 0.4, np.nan), 4),
    ],
)
def test_more_bands_than_parameters_are_needed(row, n_bands):
    batch = np.stack([MODEL.measured(TRUTH, NM), row])
    fit = fit_skin(batch, NM, MODEL)
    assert_allclose(fit.values[0], TRUTH, rtol=1e-6)
    assert fit.n_bands[1] == n_bands
    assert (fit.status[1] == "refused") == (n_bands == 0)
    assert np.isnan(fit.values[1]).all() == (n_bands == 0)


def test_what_follows_from_rows_of_nan_is_nan_without_a_warning(strict_floats):
    fit = fit_skin(np.full((3, 31), np.nan), NM, MODEL)
    for name in ("sse", "rmse", "bic", "delta_e", "blood_fraction", "fitted"):
        assert np.isnan(getattr(fit, name)).all()
    assert np.isnan(fit.oxygen_saturation).all()
    assert_array_equal(fit.n_bands, 0)


@pytest.mark.parametrize("specular", ["included", "excluded", 0.03])
def test_a_mirror_white_reading_above_1_is_fitted_up_to_the_limit(specular):
    model = skin_model(site="cheek", specular=specular)
    fit = fit_skin(np.array([np.full(31, 1.2), np.full(31, 1.5001)]), NM, model)
    assert_array_equal(fit.status, ["at_bound", "refused"])
    assert_array_equal(fit.values[0], 0)


@pytest.mark.parametrize("tiny", [5e-324, 1e-310, 1e-200])
def test_denormal_readings_are_as_good_as_0(tiny):
    black = fit_skin(np.zeros(31), NM, MODEL)
    fit = fit_skin(np.full(31, tiny), NM, MODEL)
    assert fit.status == black.status
    assert_array_equal(fit.values, black.values)
    assert_array_equal(fit.interval, black.interval)
    assert np.isfinite(fit.delta_e)


def test_one_band_of_denormals_leaves_the_rest_to_be_fitted():
    spectrum = MODEL.measured(TRUTH, NM)
    spectrum[4] = 5e-324
    fit = fit_skin(spectrum, NM, MODEL)
    assert fit.status == "converged"
    best = smallest_sse(spectrum, *table(MODEL))
    assert_allclose(fit.sse, best, rtol=SAME_OPTIMUM)


@pytest.mark.parametrize("last", [1000.0, 1200.0, 2500.0])
def test_bands_outside_the_tables_are_left_to_the_instrument(last):
    """Near-infrared bands that come along are not looked at, nor extrapolated to."""
    nm = np.concatenate([NM, np.linspace(720, last, 20)])
    spectrum = np.concatenate([MODEL.measured(TRUTH, NM), np.full(20, 0.5)])
    fit = fit_skin(spectrum, nm, MODEL)
    assert_array_equal(fit.wavelengths, NM)
    assert_allclose(fit.values, TRUTH, rtol=1e-6)


def test_wavelengths_outside_the_tables_are_told_with_what_is_covered():
    with pytest.raises(
        ArgumentError, match=r"covers 380 to 780 nm; 400 to 900.*extrapolated"
    ):
        MODEL.measured(TRUTH, [400.0, 900.0])


# --- uncertainty ---------------------------------------------------------------


@pytest.mark.parametrize("wrong", [0.0, -1e-3, np.nan, np.inf, 1e-200, 1e200])
@pytest.mark.parametrize("shape", [(31,), (2, 31)])
def test_uncertainty_that_is_none_is_refused(wrong, shape):
    sigma = np.full(shape, 1e-3)
    sigma[..., 7] = wrong
    data = np.stack([MODEL.measured(TRUTH, NM)] * 2)
    with pytest.raises(ArgumentError, match="uncertainty must be"):
        fit_skin(data, NM, MODEL, uncertainty=sigma)


@pytest.mark.parametrize(("good", "bad"), [(1e-8, 1e8), (1e-70, 1e70), (1e-3, 1e70)])
def test_bands_of_hardly_any_weight_are_as_if_not_measured(good, bad):
    rng = np.random.default_rng(5)
    data = MODEL.measured(TRUTH, NM) + rng.normal(0, 2e-3, (20, 31))
    seen = NM < 560
    spoilt = np.where(seen, data, 0.9)
    fit = fit_skin(spoilt, NM, MODEL, uncertainty=np.where(seen, good, bad))
    only = np.where(seen, data, np.nan)
    alone = fit_skin(only, NM, MODEL, uncertainty=np.full(31, good))
    assert_array_equal(fit.status, alone.status)
    assert_allclose(fit.values, alone.values, rtol=1e-5, atol=1e-9)
    assert_allclose(fit.interval, alone.interval, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("sigma", [1e-70, 1e-8, 1e8, 1e70])
def test_covariance_scales_with_the_variance_however_small_or_large(sigma):
    data = MODEL.measured(TRUTH, NM) + 1e-3 * np.sin(NM)
    unit = fit_skin(data, NM, MODEL, uncertainty=np.ones(31))
    fit = fit_skin(data, NM, MODEL, uncertainty=np.full(31, sigma))
    assert_allclose(fit.covariance / sigma**2, unit.covariance, rtol=1e-9)
    assert_allclose(fit.chi_square * sigma**2, unit.chi_square, rtol=1e-9)
