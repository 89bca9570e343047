"""The pigment fit: known weights come back, real skin fits, odd data are told."""

from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracles.best_fit import smallest_sse
from tolerances import SAME_OPTIMUM

from skinviz import ArgumentError, FitError, fit_skin, skin_model
from skinviz.skin.coefficients import body_sites, load_coefficients
from skinviz.skin.skin_fit import STATUSES
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="back of hand", specular="included")
GRID = np.array(
    list(product([0.0, 0.02, 0.2, 1.0], [0.0, 0.003, 0.03], [0.0, 0.002, 0.02]))
)
"""Weights (36, 3) from no pigment to more than any skin has."""


def spectra(n=6):
    """Return measured spectra (n, 31) of unlike skins, noise-free."""
    weights = np.array([[0.03, 0.004, 0.002], [0.1, 0.01, 0.005], [0.3, 0.02, 0.01]])
    return MODEL.measured(np.resize(weights, (n, 3)), NM)


def assert_same_values(actual, expected):
    """Two fits' estimates, alike to a hundredth of how sure they are."""
    deviation = np.sqrt(np.einsum("...pp->...p", expected.covariance))
    assert (np.abs(actual.values - expected.values) <= 0.01 * deviation + 1e-9).all()


def assert_same_fit(actual, expected):
    """Two fits of the same data, alike to what the solver settles to."""
    assert_array_equal(actual.status, expected.status)
    assert_same_values(actual, expected)
    assert_allclose(actual.sse, expected.sse, rtol=SAME_OPTIMUM, atol=1e-20)


# --- the right answer ----------------------------------------------------------


@pytest.mark.parametrize("specular", ["included", "excluded", 0.03])
@pytest.mark.parametrize("site", body_sites())
def test_known_weights_come_back(site, specular):
    model = skin_model(site=site, specular=specular)
    fit = fit_skin(model.measured(GRID, NM), NM, model)
    assert_allclose(fit.values, GRID, rtol=1e-6, atol=1e-8)
    assert np.isin(fit.status, ("converged", "at_bound")).all()
    assert (fit.status[(GRID > 0).all(axis=1)] == "converged").all()
    assert fit.sse.max() < 1e-20
    assert fit.delta_e.max() < 1e-6


def test_known_weights_come_back_with_a_declared_uncertainty():
    fit = fit_skin(MODEL.measured(GRID, NM), NM, MODEL, uncertainty=np.full(31, 2e-3))
    assert_allclose(fit.values, GRID, rtol=1e-6, atol=1e-8)
    assert np.isin(fit.status, ("converged", "at_bound")).all()


def test_a_pigment_that_would_be_negative_is_at_its_bound():
    # Redder than any blood-free skin can be: less K_h than none would fit better.
    bloodless = MODEL.measured([0.1, 0.0, 0.0], NM)
    spectrum = bloodless + 0.02 * (load_coefficients().at(NM).oxyhaemoglobin > 60)
    fit = fit_skin(spectrum, NM, MODEL)
    assert fit.status == "at_bound"
    assert fit.values[1] == 0
    assert fit.interval[1, 0] == 0
    assert fit.interval[1, 1] > 0
    assert_array_equal(fit.covariance[1], 0)


def test_fit_finds_the_optimum_that_scipy_finds(issa, site_fits):
    worst = []
    for site, fit in site_fits.items():
        records = np.flatnonzero(issa.site.values == site)[::13][:50]
        every = np.flatnonzero(np.isin(np.flatnonzero(issa.site == site), records))
        at = load_coefficients().at(fit.wavelengths)
        pigments = (at.melanin, at.oxyhaemoglobin, at.deoxyhaemoglobin)
        table = np.stack([*pigments, at.epidermis, at.dermis])
        face = fit.model.interface
        surface = (face.offset, face.transmission, face.internal)
        data = issa.reflectance.sel(wavelength=fit.wavelengths).values[records]
        for spectrum, sse in zip(data, fit.sse[every], strict=True):
            best = smallest_sse(spectrum, table, fit.model.thickness, surface)
            worst.append(sse / best - 1)
    assert len(worst) == 200
    assert np.max(worst) < SAME_OPTIMUM


def test_real_skin_fits_as_well_as_declared(site_fits):
    # 31 bands at 10 nm, told as 61 like the paper's sums of squares.
    scaled = {site: fit.sse * 61 / 31 for site, fit in site_fits.items()}
    pooled = np.concatenate(list(scaled.values()))
    assert pooled.size == 3476
    assert pooled.mean() <= 0.0080
    for sse in scaled.values():
        assert sse.mean() <= 0.011


def test_real_skin_always_converges(site_fits):
    for fit in site_fits.values():
        fit.raise_for_status()
        assert (fit.n_bands == 31).all()
        assert (fit.values >= 0).all()


def test_sse_rmse_and_delta_e_are_those_of_the_fitted_curve(issa, site_fits):
    fit = site_fits["cheek"]
    records = np.flatnonzero(issa.site.values == "cheek")
    data = issa.reflectance.sel(wavelength=fit.wavelengths).values[records]
    assert_allclose(fit.sse, ((data - fit.fitted) ** 2).sum(axis=1), rtol=1e-12)
    assert_allclose(fit.rmse, np.sqrt(fit.sse / 31), rtol=1e-12)
    white = spectrum_to_xyz(np.ones(31), fit.wavelengths)
    lab, fitted = (
        xyz_to_lab(spectrum_to_xyz(x, fit.wavelengths), white)
        for x in (data, fit.fitted)
    )
    assert_allclose(fit.delta_e, delta_e_2000(lab, fitted), rtol=1e-9)


def test_curves_are_the_models_at_the_values(site_fits):
    fit = site_fits["inner arm"]
    nm, values = fit.wavelengths, fit.values
    assert_allclose(fit.fitted, fit.model.measured(values, nm), rtol=1e-12)
    assert_allclose(fit.reflectance, fit.model.reflectance(values, nm), rtol=1e-12)
    assert_allclose(fit.diffuse, fit.model.diffuse(values, nm), rtol=1e-12)


def test_blood_and_saturation_are_sum_and_share(site_fits):
    fit = site_fits["outer arm"]
    w_h, w_dh = fit.values[:, 1], fit.values[:, 2]
    assert_array_equal(fit.blood_fraction, w_h + w_dh)
    some = w_h + w_dh > 0
    share = w_h[some] / (w_h + w_dh)[some]
    assert_array_equal(fit.oxygen_saturation[some], share)
    assert np.isnan(fit.oxygen_saturation[~some]).all()


def test_saturation_of_no_blood_is_not_known():
    fit = fit_skin(np.full(31, 0.9), NM, MODEL)
    assert fit.blood_fraction == 0
    assert np.isnan(fit.oxygen_saturation)


def test_saturation_interval_follows_from_the_ends_of_both_bloods(site_fits):
    fit = site_fits["inner arm"]
    low, high = np.moveaxis(fit.oxygen_saturation_interval, -1, 0)
    assert (low >= 0).all()
    assert (high <= 1).all()
    some = fit.blood_fraction > 0
    assert (low[some] <= fit.oxygen_saturation[some]).all()
    assert (fit.oxygen_saturation[some] <= high[some]).all()
    (w_h, w_dh) = fit.interval[some, 1], fit.interval[some, 2]
    assert_allclose(low[some], w_h[:, 0] / (w_h[:, 0] + w_dh[:, 1]), rtol=1e-12)
    assert_allclose(high[some], w_h[:, 1] / (w_h[:, 1] + w_dh[:, 0]), rtol=1e-12)


def test_saturation_of_no_blood_may_be_anything():
    fit = fit_skin(np.full(31, 0.9), NM, MODEL)
    assert_array_equal(fit.oxygen_saturation_interval, [0, 1])


# --- which bands ---------------------------------------------------------------


def test_bands_outside_400_to_700_are_not_used():
    nm = np.arange(380.0, 781.0, 10.0)
    wide = MODEL.measured([0.1, 0.01, 0.005], nm)
    wide[(nm < 400) | (nm > 700)] = 0.77
    fit = fit_skin(wide, nm, MODEL)
    assert_array_equal(fit.wavelengths, NM)
    assert_allclose(fit.values, [0.1, 0.01, 0.005], rtol=1e-6)


def test_missing_bands_are_left_out():
    data = spectra(3)
    holes = data.copy()
    holes[0, 3:7] = np.nan
    holes[2, ::2] = np.nan
    fit = fit_skin(holes, NM, MODEL)
    assert_array_equal(fit.n_bands, [27, 31, 15])
    assert_allclose(fit.values, fit_skin(data, NM, MODEL).values, rtol=1e-6)
    assert np.isfinite(fit.fitted).all()
    assert np.isfinite(fit.delta_e).all()


def test_a_missing_band_is_the_same_as_one_not_measured():
    noisy = spectra(3) + np.random.default_rng(1).normal(0, 2e-3, (3, 31))
    holes = noisy.copy()
    holes[:, 10] = np.nan
    left_out = fit_skin(np.delete(noisy, 10, axis=1), np.delete(NM, 10), MODEL)
    masked = fit_skin(holes, NM, MODEL)
    assert_same_fit(masked, left_out)
    width = np.ptp(left_out.interval, axis=-1, keepdims=True)
    assert (np.abs(masked.interval - left_out.interval) <= 0.01 * width).all()


def refused_rows():
    """Spectra that are no skin's: nothing measured, dark error, scale error."""
    rows = spectra(4)
    rows[0] = np.nan
    rows[1, 4] = -0.01
    rows[2, 20] = 1.6
    rows[3, 3:] = np.nan
    return rows


def test_refused_spectra_leave_the_others_unharmed():
    good = spectra(6)
    batch = np.concatenate([good[:3], refused_rows(), good[3:]])
    fit, alone = fit_skin(batch, NM, MODEL), fit_skin(good, NM, MODEL)
    refused = np.arange(3, 7)
    assert (fit.status[refused] == "refused").all()
    for name in ("values", "covariance", "interval", "sse", "delta_e", "fitted"):
        assert np.isnan(getattr(fit, name)[refused]).all()
    kept = np.delete(np.arange(10), refused)
    assert_array_equal(fit.status[kept], alone.status)
    assert_allclose(fit.values[kept], alone.values, rtol=1e-9)
    assert_array_equal(fit.n_bands, np.where(np.isin(np.arange(10), refused), 0, 31))


def test_a_batch_of_refused_spectra_alone_is_told_so():
    fit = fit_skin(refused_rows(), NM, MODEL)
    assert (fit.status == "refused").all()
    with pytest.raises(FitError, match=r"4 of 4 .* index \(0,\), is 'refused'"):
        fit.raise_for_status()


# --- shapes and kinds of arrays ------------------------------------------------


@pytest.mark.parametrize("shape", [(), (1,), (6,), (2, 3), (0,), (2, 0)])
def test_batches_keep_their_shape(shape):
    data = spectra(int(np.prod(shape))).reshape(*shape, 31)
    fit = fit_skin(data, NM, MODEL)
    assert fit.values.shape == (*shape, 3)
    assert fit.covariance.shape == (*shape, 3, 3)
    assert fit.interval.shape == (*shape, 3, 2)
    assert fit.fitted.shape == fit.reflectance.shape == (*shape, 31)
    for name in ("sse", "rmse", "delta_e", "status", "n_bands", "oxygen_saturation"):
        assert getattr(fit, name).shape == shape
    flat = fit_skin(data.reshape(-1, 31), NM, MODEL)
    assert_array_equal(fit.values.reshape(-1, 3), flat.values)


def test_order_of_memory_does_not_matter():
    data = spectra(6)
    expected = fit_skin(data, NM, MODEL)
    assert_same_fit(fit_skin(np.asfortranarray(data), NM, MODEL), expected)
    assert_same_fit(fit_skin(np.repeat(data, 2, axis=1)[:, ::2], NM, MODEL), expected)


def test_single_precision_is_fitted_in_double():
    data = spectra(6).astype(np.float32)
    fit = fit_skin(data, NM.astype(np.float32), MODEL)
    assert fit.values.dtype == np.float64
    assert_same_fit(fit, fit_skin(data.astype(np.float64), NM, MODEL))


def test_data_are_not_changed():
    data, sigma = refused_rows(), np.full(31, 0.01)
    before = data.copy()
    fit_skin(data, NM, MODEL, uncertainty=sigma)
    assert_array_equal(data, before)


def test_many_spectra_fit_as_few_do():
    # More than are solved at once.
    few = spectra(3) + np.random.default_rng(2).normal(0, 3e-3, (3, 31))
    many = fit_skin(np.tile(few, (1500, 1)), NM, MODEL)
    expected = fit_skin(few, NM, MODEL)
    assert_allclose(many.values[-3:], expected.values, rtol=1e-9)
    assert_allclose(np.ptp(many.values[::3], axis=0), 0, atol=1e-12)


# --- extremes ------------------------------------------------------------------


@pytest.mark.parametrize(
    "thickness",
    [(0.035, np.inf), (np.inf, 1.2), (np.inf, np.inf), (0.035, 1e16), (1e16, 1.2)],
)
def test_very_thick_skin_is_fitted_or_told(thickness):
    model = skin_model(thickness=thickness, specular="included")
    weights = np.array([[0.1, 0.01, 0.005], [0, 0.02, 0.01], [0.05, 0, 0], [0, 0, 0]])
    fit = fit_skin(model.measured(weights, NM), NM, model)
    assert np.isin(fit.status, STATUSES).all()
    assert not np.isin("refused", fit.status)
    # A perfectly white endless layer falls vertically: that row may only be told.
    assert ((fit.sse < 1e-6) | (fit.status == "not_converged")).all()
    assert (fit.sse[:3] < 1e-6).all()


@pytest.mark.parametrize("level", [0.0, 1e-6, 0.03, 0.5, 1.0, 1.5])
@pytest.mark.parametrize("specular", ["included", "excluded", 0.03])
def test_flat_spectra_get_a_status_and_ordered_intervals(level, specular):
    model = skin_model(site="cheek", specular=specular)
    fit = fit_skin(np.full(31, level), NM, model)
    # At the surface's own 0.028 any black skin will do, and none is the best.
    assert fit.status in ("converged", "at_bound", "not_converged")
    assert (fit.status != "not_converged") | (level < 0.05)
    assert (fit.interval[:, 0] <= fit.values).all()
    assert (fit.values <= fit.interval[:, 1]).all()
    assert np.isfinite(fit.interval).all()


# --- what comes out ------------------------------------------------------------


def test_to_xarray_holds_the_fit_under_labels():
    fit = fit_skin(np.concatenate([spectra(3), refused_rows()]), NM, MODEL)
    table = fit.to_xarray()
    assert dict(table.sizes) == {
        "record": 7,
        "parameter": 3,
        "other_parameter": 3,
        "side": 2,
        "wavelength": 31,
    }
    assert table.attrs == {"model": "two-layer", "specular": "included"}
    assert_array_equal(table.value.sel(parameter="w_h"), fit.values[:, 1])
    assert_array_equal(table.interval.sel(side="upper"), fit.interval[..., 1])
    assert_array_equal(table.status, fit.status)
    for name in ("covariance", "sse", "rmse", "n_bands", "delta_e", "fitted"):
        assert_array_equal(table[name], getattr(fit, name))


@pytest.mark.parametrize("shape", [(), (2, 3)])
def test_to_xarray_flattens_the_batch(shape):
    fit = fit_skin(spectra(int(np.prod(shape))).reshape(*shape, 31), NM, MODEL)
    table = fit.to_xarray()
    assert table.sizes["record"] == int(np.prod(shape))
    assert_array_equal(table.value.values, fit.values.reshape(-1, 3))


@pytest.mark.parametrize("index", [(1, 2), 0, (slice(None), 1), ..., (0, [2, 0])])
def test_a_fit_is_indexed_like_its_batch(index):
    grid = fit_skin(spectra(6).reshape(2, 3, 31), NM, MODEL)
    part = grid[index]
    assert_array_equal(part.sse, grid.sse[index])
    assert_array_equal(part.values, grid.values[index])
    assert_array_equal(part.interval, grid.interval[index])
    assert_array_equal(part.fitted, grid.fitted[index])
    assert_array_equal(part.status, grid.status[index])
    assert part.model is grid.model
    part.raise_for_status()


def test_raise_for_status_is_silent_on_good_fits():
    fit_skin(spectra(3), NM, MODEL).raise_for_status()


def test_raise_for_status_tells_which_of_a_grid():
    data = spectra(6).reshape(2, 3, 31)
    data[1, 2] = np.nan
    with pytest.raises(FitError, match=r"1 of 6 .* index \(1, 2\), is 'refused'"):
        fit_skin(data, NM, MODEL).raise_for_status()


# --- refusals ------------------------------------------------------------------


@pytest.mark.parametrize("nm", [NM + 5, NM - 5, np.linspace(450, 650, 31)])
def test_spectra_must_span_400_to_700(nm):
    with pytest.raises(ArgumentError, match="span 400 to 700 nm; these cover"):
        fit_skin(spectra(1), nm, MODEL)


def test_descending_wavelengths_are_refused():
    with pytest.raises(ArgumentError, match="ascending; index 1 is 690 after 700 nm"):
        fit_skin(spectra(1), NM[::-1], MODEL)


@pytest.mark.parametrize("data", [0.4, np.full(30, 0.4), np.full((31, 2), 0.4)])
def test_wavelengths_must_be_on_the_last_axis(data):
    with pytest.raises(ArgumentError, match="31 wavelengths on its last axis"):
        fit_skin(data, NM, MODEL)


def test_infinite_reflectance_is_refused_by_place():
    data = spectra(2)
    data[1, 5] = np.inf
    with pytest.raises(ArgumentError, match=r"index \(1, 5\) is inf"):
        fit_skin(data, NM, MODEL)


@pytest.mark.parametrize("wrong", [0.0, -1e-3])
def test_uncertainty_must_be_positive(wrong):
    sigma = np.full(31, 1e-3)
    sigma[7] = wrong
    with pytest.raises(ArgumentError, match="uncertainty must be greater than 0"):
        fit_skin(spectra(2), NM, MODEL, uncertainty=sigma)


@pytest.mark.parametrize("sigma", [np.full(30, 1.0), 1e-3, np.full(31, np.nan)])
def test_uncertainty_must_match_the_bands(sigma):
    with pytest.raises(ArgumentError, match="uncertainty must"):
        fit_skin(spectra(2), NM, MODEL, uncertainty=sigma)


def test_uncertainty_must_broadcast_to_the_batch():
    with pytest.raises(ArgumentError, match="does not broadcast"):
        fit_skin(spectra(2), NM, MODEL, uncertainty=np.ones((3, 31)))
