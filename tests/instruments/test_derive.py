"""From the bench to numbers: known skin, known weights, a known lobe."""

import numpy as np
import pytest
from benches import LOBE, MODEL, NM, NOISY, WEIGHTS, bench, human, run_session
from numpy.testing import assert_allclose

from skinviz.errors import SkinvizError
from skinviz.instruments.derive import derive, read_session
from skinviz.instruments.lobe import lobe_of
from skinviz.instruments.plan import Plan
from skinviz.instruments.simulate.scene import Lamp, halogen
from skinviz.instruments.skinlog import read_log
from skinviz.skin.fit import fit_skin
from skinviz.surface.lobe_curve import in_plane
from skinviz.surface.lobe_fit import fit_lobe

CROSSED = Plan(states=("parallel", "crossed"), leakage=0.001)
GONIO = Plan(
    illumination=(-75.0, *np.arange(0.0, 86.0, 10.0)),
    viewing=60.0,
    states=("s", "p"),
    repeats=3,
    leakage=0.001,
)


@pytest.fixture(scope="module")
def crossed(tmp_path_factory):
    path = tmp_path_factory.mktemp("crossed") / "a.skinlog"
    run_session(path, CROSSED, bench(subject=human(), **NOISY))
    return read_session(path)


@pytest.fixture(scope="module")
def gonio(tmp_path_factory):
    path = tmp_path_factory.mktemp("gonio") / "a.skinlog"
    run_session(path, GONIO, bench(subject=human(), **NOISY, seed=1))
    return derive(read_log(path))


def test_without_gloss_or_noise_the_reflectance_is_found(tmp_path):
    on = bench()
    plan = Plan(sites=("cheek", "arm"), repeats=2, warm_up=False)
    run_session(tmp_path / "a.skinlog", plan, on)
    spectra = read_session(tmp_path / "a.skinlog")
    truth = np.interp(spectra.wavelength, NM, on.subject.reflectance)
    for row in spectra.reflectance.values:
        # The detector's grating sees what leaves the skin as it sees the white: alike.
        assert_allclose(row, truth, rtol=1.5e-3)
    assert spectra.label.values.tolist() == ["cheek", "arm"]
    assert spectra.attrs["specular"] == "excluded"
    assert spectra.attrs["geometry"] == "45x:0"


def test_crossed_polarisers_leave_the_body(crossed):
    nm = crossed.wavelength.values
    off = crossed.reflectance.values[0] - MODEL.measured(WEIGHTS, nm)
    assert (np.abs(off) < 3 * crossed.uncertainty.values[0]).mean() >= 0.99
    assert np.std(off / crossed.uncertainty.values[0]) == pytest.approx(1, abs=0.25)


def test_the_weights_are_within_their_intervals(crossed):
    fit = fit_skin(
        crossed.reflectance.values[0],
        crossed.wavelength.values,
        MODEL,
        uncertainty=crossed.uncertainty.values[0],
    )
    assert (fit.interval[:, 0] <= WEIGHTS).all()
    assert (fit.interval[:, 1] >= WEIGHTS).all()
    assert 0.5 < fit.chi_square / 73 < 1.6


def test_the_lobe_is_found_with_its_uncertainty(gonio):
    lobe = lobe_of(gonio, "skin")
    angles = np.deg2rad(lobe.illumination)
    off = (lobe.specular - in_plane(LOBE, angles)) / lobe.uncertainty
    assert np.abs(off).max() < 4
    fit = fit_lobe(
        angles,
        lobe.specular,
        viewing=np.deg2rad(lobe.viewing),
        uncertainty=lobe.uncertainty,
    )
    assert fit.gamma == pytest.approx(LOBE.gamma, rel=0.05)
    assert fit.beta == pytest.approx(LOBE.beta, rel=0.05)


def test_the_asymmetry_is_measured_where_there_is_no_gloss(gonio):
    k, u = gonio.asymmetry["skin"]
    assert k == pytest.approx(0.862, abs=4 * u + 5e-4)
    assert 0 < u < 0.005


def test_drift_is_corrected_and_noted(tmp_path):
    path = tmp_path / "a.skinlog"
    steady = halogen()
    lamp = Lamp(steady.wavelengths, steady.radiance, drift=-0.8, warm_up=0.0)
    on = bench(lamp=lamp, exposure=5.0)
    run_session(path, Plan(repeats=2, warm_up=False), on)
    assert any("changed by up to -1." in note for note in derive(read_log(path)).notes)
    spectra = read_session(path)
    truth = np.interp(spectra.wavelength, NM, on.subject.reflectance)
    assert_allclose(spectra.reflectance.values[0], truth, rtol=2e-3)


def test_one_state_has_no_lobe(tmp_path):
    path = tmp_path / "a.skinlog"
    run_session(path, Plan(repeats=2, warm_up=False), bench())
    with pytest.raises(SkinvizError, match='states = \\["s", "p"\\]'):
        lobe_of(derive(read_log(path)), "skin")


def test_bands_beyond_the_certificate_are_left_out(tmp_path):
    on = bench()
    on.tile = (NM[(NM >= 400) & (NM <= 700)], np.full(301, 0.98))
    run_session(tmp_path / "a.skinlog", Plan(repeats=2, warm_up=False), on)
    derived = derive(read_log(tmp_path / "a.skinlog"))
    assert any("certificate" in note for note in derived.notes)
    spectra = read_session(tmp_path / "a.skinlog")
    inside = (spectra.wavelength >= 400) & (spectra.wavelength <= 700)
    assert np.isfinite(spectra.reflectance.values[:, inside]).all()
    assert np.isnan(spectra.reflectance.values[:, ~inside]).all()


def test_no_asymmetry_is_taken_from_an_angle_that_has_gloss(tmp_path):
    # At 0 degrees of viewing, a lamp at -45 is as near to the mirror as one at 45.
    path = tmp_path / "a.skinlog"
    on = bench(subject=human(), leakage=0.0)
    plan = Plan(illumination=(-45.0, 45.0), states=("s", "p"), repeats=2, warm_up=False)
    run_session(path, plan, on)
    derived = derive(read_log(path))
    assert derived.asymmetry == {}
    truth = MODEL.measured(WEIGHTS, derived.frames.wavelengths)
    assert_allclose(derived.parts["skin", 45.0].diffuse, truth, rtol=5e-3)
