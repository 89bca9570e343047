"""What every skin model owes: its equations, its slopes, its fit."""

import numpy as np
import pytest
from compiled_optics import measured_and_jacobian
from mpmath import mp
from numpy.testing import assert_allclose, assert_array_equal
from oracles import kubelka_munk as km
from oracles import skin_models as oracle
from oracles.agreement import assert_oracle
from scipy.optimize import least_squares
from tolerances import EPS, ORACLE, SAME_OPTIMUM

from skinviz import ArgumentError, fit_skin, skin_model, skin_models
from skinviz.skin.extended import EXTRAS
from skinviz.skin.problem import HIGHEST

NM = np.array([400.0, 415.0, 545.0, 620.0, 700.0])
BANDS = np.arange(400.0, 701.0, 10.0)
ALL_EXTRAS = tuple(parameter.name for parameter in EXTRAS)
MODELS = [(name, None) for name in skin_models()]
MODELS += [("extended", ALL_EXTRAS), ("extended", ()), ("extended", ("epidermis",))]


def model(name, free=None, **options):
    """Return a model of one site's thickness, surface included."""
    options = {"thickness": (0.035, 1.19), "specular": "included", **options}
    return skin_model(name, **options, **({} if free is None else {"free": free}))


def typical(skin, n, seed=0):
    """Return values (n, p) as skin has them; every fourth lacks a pigment."""
    rng = np.random.default_rng(seed)
    usual = {"w_m": (0.02, 0.4), "w_h": (1e-3, 0.03), "w_dh": (1e-3, 0.02)}
    usual |= {"offset": (0.1, 0.8), "scattering": (0.6, 1.6), "epidermis": (0.7, 1.4)}
    usual |= {"melanin_slope": (-0.5, 1.0), "surface": (-0.01, 0.02)}
    values = np.array([rng.uniform(*usual[p.name], n) for p in skin.parameters]).T
    values[::4, rng.integers(0, 3)] = 0
    return values


def tables(skin, nm):
    """Return the coefficients band by band, as the oracle takes them."""
    at = skin.coefficients.at(nm)
    columns = (at.melanin, at.oxyhaemoglobin, at.deoxyhaemoglobin)
    rows = zip(*columns, at.epidermis, at.dermis, nm, strict=True)
    names = ("K_m", "K_h", "K_dh", "S_e", "S_d", "nm")
    return [dict(zip(names, row, strict=True)) for row in rows]


def named(skin, values):
    """Return one set of values under their names."""
    names = [p.name for p in skin.parameters]
    return dict(zip(names, (float(v) for v in values), strict=True))


@pytest.mark.parametrize("hypodermis", [1.0, 0.4])
@pytest.mark.parametrize(("name", "free"), MODELS)
def test_body_equals_the_oracle(name, free, hypodermis):
    skin = model(name, free, hypodermis=hypodermis)
    values = typical(skin, 12)
    with mp.workdps(60):
        expected = [
            [
                float(oracle.body(name, named(skin, v), at, skin.thickness, hypodermis))
                for at in tables(skin, NM)
            ]
            for v in values
        ]
    assert_oracle(skin.reflectance(values, NM), expected)


@pytest.mark.parametrize("specular", ["included", "excluded", 0.03])
@pytest.mark.parametrize(("name", "free"), MODELS)
def test_what_is_measured_is_the_body_under_the_surface(name, free, specular):
    skin = model(name, free, specular=specular)
    values = typical(skin, 12)
    body = skin.reflectance(values, NM)
    names = [p.name for p in skin.parameters]
    added = values[:, names.index("surface"), None] if "surface" in names else 0.0
    expected = skin.interface.measured(body) + added
    assert_allclose(skin.measured(values, NM), expected, rtol=8 * EPS)
    assert_allclose(skin.diffuse(values, NM), skin.interface.diffuse(body))
    # The same holds for the slopes, but that of what is added is 1.
    _, seen = measured_and_jacobian(skin, values, NM)
    _, inner = measured_and_jacobian(model(name, free, specular="excluded"), values, NM)
    for k, parameter in enumerate(names):
        chain = skin.interface.slope(body) if parameter != "surface" else 1.0
        assert_allclose(seen[..., k], inner[..., k] * chain, rtol=8 * EPS)


@pytest.mark.parametrize(("name", "free"), MODELS)
def test_jacobian_equals_the_oracle(name, free):
    skin = model(name, free, specular="excluded")
    values = typical(skin, 4)
    _, jacobian = measured_and_jacobian(skin, values, NM)
    for i, v in enumerate(values):
        for j, at in enumerate(tables(skin, NM)):
            for k, parameter in enumerate(skin.parameters):
                if parameter.name == "surface":
                    assert jacobian[i, j, k] == 1
                    continue

                def changed(x, at=at, v=v, name_=parameter.name):
                    own = {**named(skin, v), name_: x}
                    return oracle.body(name, own, at, skin.thickness)

                expected = float(km.slope(changed, float(v[k])))
                assert_allclose(jacobian[i, j, k], expected, rtol=ORACLE)


@pytest.mark.parametrize(("name", "free"), MODELS)
def test_known_parameters_come_back(name, free):
    skin = model(name, free)
    values = typical(skin, 40, seed=1)
    fit = fit_skin(skin.measured(values, BANDS), BANDS, skin)
    assert np.isin(fit.status, ("converged", "at_bound")).all()
    if any(np.isfinite(p.spread) for p in skin.parameters):
        # The priors pull, by no more than what they weigh: σ² of one band.
        pull = [
            (p.expected - values[:, k]) / p.spread
            for k, p in enumerate(skin.parameters)
        ]
        assert (fit.sse <= skin.prior_unit * np.sum(np.square(pull), axis=0)).all()
    else:
        assert_allclose(fit.values, values, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(("name", "free"), MODELS)
def test_the_fit_finds_the_optimum_that_scipy_finds(name, free, issa):
    skin = model(name, free)
    data = issa.reflectance.sel(wavelength=BANDS).values
    data = data[np.isfinite(data).all(axis=1)][::277]
    fit = fit_skin(data, BANDS, skin)
    centre = np.array([p.expected for p in skin.parameters])
    spread = np.array([p.spread for p in skin.parameters]) / np.sqrt(skin.prior_unit)
    bounds = np.array([(p.lower, p.upper) for p in skin.parameters]).T
    table, constants = skin.arrays(BANDS, skin.interface)

    def residual(values, spectrum):
        curve, _ = skin.curves_and_slopes(values[None], table, constants)
        return np.concatenate(
            [curve[0, : BANDS.size] - spectrum, (values - centre) / spread]
        )

    options = {"ftol": 1e-14, "xtol": 1e-12, "gtol": 1e-14, "method": "dogbox"}
    options["x_scale"] = np.maximum(np.abs(centre), 0.01)
    starts = skin.starts[:: len(skin.starts) // 3]
    starts = np.where(starts == 0, 1e-3, np.clip(starts, *(bounds * 0.99)))
    worst = []
    for i, spectrum in enumerate(data):
        found = [
            least_squares(residual, x, "2-point", bounds, args=(spectrum,), **options)
            for x in starts
        ]
        own = (residual(fit.values[i], spectrum) ** 2).sum()
        worst.append(own / min(2 * result.cost for result in found) - 1)
    assert len(worst) >= 25
    assert np.max(worst) < SAME_OPTIMUM


@pytest.mark.parametrize(("name", "free"), MODELS)
def test_extremes_are_right_or_refused(name, free):
    for thickness in ((0.0, 0.0), (1e-16, 1e16), (0.035, np.inf), (np.inf, 1.0)):
        if name == "lambert-beer" and np.inf in thickness:
            with pytest.raises(ArgumentError, match="needs finite thicknesses"):
                model(name, free, thickness=thickness)
            continue
        skin = model(name, free, thickness=thickness)
        low, high = np.array([(p.lower, p.upper) for p in skin.parameters]).T
        usual = [p.expected for p in skin.parameters]
        tiny = np.where(np.arange(len(low)) < 3, 1e-12, usual)
        values = np.stack([low, high, tiny, usual])
        spectra = skin.reflectance(values, NM)
        assert (spectra >= 0).all()
        assert (spectra <= 1 + 4 * EPS).all()
        measured, jacobian = measured_and_jacobian(skin, values, NM)
        assert np.isfinite(measured).all()
        assert np.isfinite(jacobian).all()
        assert (measured < HIGHEST).all()


@pytest.mark.parametrize(("name", "free"), MODELS)
def test_a_model_is_made_anew_from_its_description(name, free):
    skin = model(name, free, coefficients="textbook", hypodermis=0.8)
    said = skin.description
    again = skin_model(
        said.pop("model"), thickness=tuple(said.pop("thickness_mm")), **said
    )
    assert again == skin
    assert_array_equal(again.starts, skin.starts)


@pytest.mark.parametrize(("name", "free"), MODELS)
def test_starts_lie_within_the_bounds(name, free):
    for site in ("cheek", "inner arm"):
        skin = skin_model(
            name,
            site=site,
            specular=0.03,
            **({} if free is None else {"free": free}),
        )
        assert (skin.checked(skin.starts) == skin.starts).all()
