"""The lobe's fit: truth comes back, its errors are as said, bad data are refused."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from numpy.testing import assert_allclose, assert_array_equal
from oracles import torrance_sparrow as oracle
from scipy.optimize import least_squares
from scipy.stats import chi2, kstest, norm
from scipy.stats import t as student
from strategies import log_uniform

from skinviz import ArgumentError, FitError, TorranceSparrow
from skinviz.surface.fitted_lobe import STATUSES
from skinviz.surface.lobe_curve import BOUNDS, LobeCurve, in_plane, masked_spread
from skinviz.surface.lobe_fit import alpha_from_diffuse, fit_lobe

ANGLES = np.deg2rad(np.arange(0, 86, 5))  # the paper's
VIEW = np.pi / 3
ALL = ("beta", "gamma", "n")
SKIN = TorranceSparrow.from_beta(1.2, 0.3)
CURVE = in_plane(SKIN, ANGLES)

maskings = st.sampled_from(["v-cavity", "none"])


def noisy(rng, sigma=0.02, truth=CURVE):
    """Return readings with noise."""
    return truth + rng.normal(0, sigma, truth.size)


# --- recovery ------------------------------------------------------------------


@given(
    beta=log_uniform(1e-3, 1e3),
    gamma=st.floats(0.05, 1.2),
    n=st.floats(1.1, 2.9),
    view=st.floats(0.2, 1.3),
    masking=maskings,
)
@settings(max_examples=15, deadline=None)
@pytest.mark.parametrize("free", [("beta",), ("beta", "gamma"), ("gamma", "n"), ALL])
def test_truth_comes_back(free, beta, gamma, n, view, masking):
    surface = TorranceSparrow.from_beta(beta, gamma, n, masking)
    known = {"beta": beta, "gamma": gamma, "n": n}
    fit = fit_lobe(
        ANGLES,
        in_plane(surface, ANGLES, view),
        viewing=view,
        free=free,
        masking=masking,
        **{name: value for name, value in known.items() if name not in free},
    )
    assert fit.status == "converged"
    # What the readings hardly tell apart, rounding moves further.
    expected = [known[name] for name in free]
    assert_allclose(fit.values, expected, rtol=1e-7 if "n" not in free else 1e-4)
    assert_allclose(fit.fitted, fit.specular, rtol=0, atol=1e-9 * fit.specular.max())


def test_the_surface_is_what_was_fitted():
    fit = fit_lobe(ANGLES, noisy(np.random.default_rng(1)), free=ALL, masking="none")
    assert fit.surface.masking == "none"
    assert (fit.beta, fit.gamma, fit.n) == tuple(fit.values)
    assert_allclose(in_plane(fit.surface, ANGLES), fit.fitted, rtol=1e-12)
    expected = np.sqrt(np.mean((fit.fitted - fit.specular) ** 2))
    assert_allclose(fit.rmse, expected, rtol=1e-14)


def test_readings_in_the_plane_of_incidence_are_eq_10():
    for light in (0.0, 0.4, 1.3):
        L, V = ([s * np.sin(a), 0, np.cos(a)] for s, a in ((-1, light), (1, VIEW)))
        kwargs = {"gamma": 0.3, "n": 1.4, "beta": 1.2, "masked": True}
        expected = oracle.evaluate([0, 0, 1], L, V, **kwargs)
        assert_allclose(in_plane(SKIN, light), expected, rtol=1e-10)


@pytest.mark.parametrize("scale", [1e-30, 1e-6, 1e4])
def test_beta_is_proportional_to_the_readings(scale):
    data = noisy(np.random.default_rng(2))
    one, other = fit_lobe(ANGLES, data), fit_lobe(ANGLES, scale * data)
    assert_allclose(other.beta, scale * one.beta, rtol=1e-7)
    assert_allclose(other.gamma, one.gamma, rtol=1e-7)
    unit = np.array([scale, 1])
    expected = one.covariance * np.outer(unit, unit)
    assert_allclose(other.covariance, expected, rtol=1e-6)


def test_a_radiance_factor_is_the_same_light_in_another_unit():
    # The perfect diffuser that is lit as the skin was is darker by cos θ.
    data, sigma = noisy(np.random.default_rng(3)), 0.02
    facing = fit_lobe(ANGLES, data, uncertainty=sigma)
    alike = fit_lobe(
        ANGLES,
        data / np.cos(ANGLES),
        uncertainty=sigma / np.cos(ANGLES),
        diffuser="alike",
    )
    assert_allclose(alike.values, facing.values, rtol=1e-7)
    assert_allclose(alike.covariance, facing.covariance, rtol=1e-6)


def test_the_order_of_names_does_not_matter():
    data = noisy(np.random.default_rng(4))
    one, other = (fit_lobe(ANGLES, data, free=f) for f in (ALL, ALL[::-1]))
    assert one.parameters == other.parameters == ALL
    assert_array_equal(one.values, other.values)


def test_several_viewing_angles_fit_together():
    views = np.repeat([0.5, 1.0], ANGLES.size)
    lights = np.tile(ANGLES, 2)
    fit = fit_lobe(lights, in_plane(SKIN, lights, views), viewing=views, free=ALL)
    assert_allclose(fit.values, [1.2, 0.3, 1.4], rtol=1e-6)


# --- the minimum ---------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_no_other_descent_ends_lower(seed):
    # SciPy's other method, without the elimination of β, from a dozen starts.
    rng = np.random.default_rng(seed)
    truth = TorranceSparrow.from_beta(1.0, rng.uniform(0.05, 1.2), rng.uniform(1.1, 3))
    clean = in_plane(truth, ANGLES)
    data = noisy(rng, rng.choice([1e-3, 0.03, 0.3]) * clean.max(), clean)
    fit = fit_lobe(ANGLES, data, free=ALL)
    curve = LobeCurve(
        ALL,
        {},
        np.abs(ANGLES - VIEW) / 2,
        np.cos((ANGLES + VIEW) / 2),
        masked_spread(ANGLES, np.full(ANGLES.size, VIEW), "v-cavity"),
    )
    low, high = curve.bounds
    costs = []
    for _ in range(12):
        start = [10 ** rng.uniform(-2, 3), rng.uniform(0.02, 1.5), rng.uniform(1.02, 3)]
        other = least_squares(
            lambda x: (curve(x) - data) / data.max(),
            start,
            jac=lambda x: curve.slopes(x) / data.max(),
            bounds=(low, high),
            x_scale="jac",
            xtol=1e-13,
            ftol=1e-13,
        )
        costs.append(2 * other.cost)
    mine = np.square((fit.fitted - data) / data.max()).sum()
    fit.raise_for_status()
    assert mine <= min(costs) * (1 + 1e-6)


@pytest.mark.parametrize("values", [(1.2, 0.3, 1.4), (40.0, 1.5, 1.01), (0.1, 0.1, 3)])
def test_slopes_equal_the_oracles(values):
    lights = ANGLES[3:15:4]
    curve = LobeCurve(
        ALL,
        {},
        np.abs(lights - VIEW) / 2,
        np.cos((lights + VIEW) / 2),
        masked_spread(lights, np.full(lights.size, VIEW), "v-cavity"),
    )

    def exact(k, beta, gamma, n):
        mu, turn = (mpf(float(x[k])) for x in (curve.cosine, curve.turn))
        D = mp.exp(-mp.log(2) * (turn / gamma) ** 2)
        F = oracle.fresnel.reflectance(mu, n)
        return beta * mpf(float(curve.spread[k])) * D * F

    with mp.workdps(50):
        point = tuple(mpf(v) for v in values)
        orders = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
        expected = [
            [float(mp.diff(lambda *x, k=k: exact(k, *x), point, o)) for o in orders]
            for k in range(lights.size)
        ]
    assert_allclose(curve.slopes(np.array(values)), expected, rtol=1e-10)


# --- uncertainty ---------------------------------------------------------------


@pytest.fixture(scope="module", params=[True, False], ids=["sigma given", "not given"])
def many(request):
    """Return fits of one truth under many draws of noise, and whether σ was given."""
    rng, sigma = np.random.default_rng(5), 0.005
    given = sigma if request.param else None
    return [fit_lobe(ANGLES, noisy(rng, sigma), uncertainty=given) for _ in range(200)]


def test_pulls_are_normal_or_students(many):
    pulls = [(f.values - [1.2, 0.3]) / np.sqrt(np.diag(f.covariance)) for f in many]
    expected = norm if many[0].uncertainty is not None else student(16)
    for column in np.transpose(pulls):
        assert kstest(column, expected.cdf).pvalue > 0.005
        assert_allclose(column.std(), expected.std(), rtol=0, atol=0.15)


def test_intervals_hold_the_truth_95_times_in_100(many):
    inside = []
    for fit in many:
        low, high = fit.interval.T
        inside.append((low <= [1.2, 0.3]) & (high >= [1.2, 0.3]))
    share = np.mean(inside, axis=0)
    assert ((share > 0.9) & (share < 0.99)).all()


def test_chi_square_is_that_of_its_freedom(many):
    drawn = [fit.chi_square for fit in many]
    if many[0].uncertainty is None:
        assert np.isnan(drawn).all()
    else:
        assert kstest(drawn, chi2(16).cdf).pvalue > 0.005


def test_beta_and_n_are_nearly_the_same_to_the_data():
    # PHYSICS.md section 7: correlation −0.94; freeing n triples σ_β.
    truth = TorranceSparrow.from_beta(1.0, 0.27)
    data = in_plane(truth, ANGLES)
    two, three = (
        fit_lobe(ANGLES, data, free=free, uncertainty=0.01) for free in (ALL[:2], ALL)
    )
    assert_allclose(three.correlation[0, 2], -0.94, rtol=0, atol=0.005)
    ratio = np.sqrt(three.covariance[0, 0] / two.covariance[0, 0])
    assert_allclose(ratio, 3.0, rtol=0, atol=0.05)


def test_covariance_grows_with_the_square_of_the_noise():
    data = noisy(np.random.default_rng(8))
    one, three = (fit_lobe(ANGLES, data, uncertainty=s) for s in (0.02, 0.06))
    assert_allclose(three.covariance, 9 * one.covariance, rtol=1e-6)
    assert_allclose(three.values, one.values, rtol=1e-8)


def test_exact_readings_leave_no_doubt():
    data = np.zeros(ANGLES.size)
    data[12] = in_plane(TorranceSparrow.from_beta(2.0, 1e-4), ANGLES[12])
    fit = fit_lobe(ANGLES, data, free=("beta",), gamma=1e-4)
    assert_allclose(fit.beta, 2.0, rtol=1e-12)
    assert_allclose(fit.interval, 2.0, rtol=1e-12)


# --- bounds and what is not determined -----------------------------------------


def test_flat_readings_widen_the_lobe_to_its_bound():
    fit = fit_lobe(ANGLES, np.full(ANGLES.size, 4.0))
    assert fit.status == "at_bound"
    assert fit.gamma == BOUNDS["gamma"][1]
    low, high = fit.interval[1]
    assert low < high == fit.gamma
    assert_array_equal(fit.covariance[1], 0)
    assert_array_equal(fit.correlation, [[1, 0], [0, 0]])


def test_a_spike_narrows_it_to_one_reading():
    data = np.zeros(ANGLES.size)
    data[12] = 1.0  # at 60°, the mirror's angle
    fit = fit_lobe(ANGLES, data, uncertainty=0.01)
    # D at the neighbours, 2.5° off, is all that is known of γ.
    assert fit.gamma < np.deg2rad(2.5) / 2
    assert_allclose(in_plane(fit.surface, ANGLES[12]), 1, rtol=1e-9)
    # So narrow a lobe does not show its width; all widths are in the interval.
    assert fit.interval[1, 1] == BOUNDS["gamma"][1]


def test_darkness_but_for_noise_puts_beta_at_0():
    data = -in_plane(SKIN, ANGLES)
    data[:2] = 1e-3
    fit = fit_lobe(ANGLES, data, free=("beta",), gamma=0.3, uncertainty=0.01)
    assert (fit.status, fit.beta) == ("at_bound", 0)
    assert fit.interval[0, 0] == 0
    assert 0 < fit.interval[0, 1] < 0.01
    assert_array_equal(in_plane(fit.surface, ANGLES), 0)


def test_reach_from_a_bound_holds_95_percent():
    # Of a normal density cut at 0, whose centre is at −1 σ.
    unit = in_plane(TorranceSparrow.from_beta(1.0, 0.3), ANGLES)
    deviation = 0.1 / np.sqrt(unit @ unit)
    data = -deviation * unit
    data[0] += 1e-2  # so that a reading is above 0
    data[-1] -= 1e-2 * unit[0] / unit[-1]
    fit = fit_lobe(ANGLES, data, free=("beta",), gamma=0.3, uncertainty=0.1)
    expected = norm.isf(0.05 * norm.sf(1)) - 1
    assert_allclose(fit.interval[0, 1] / deviation, expected, rtol=1e-9)


def test_one_angle_does_not_tell_beta_from_gamma():
    data = np.array([0.1, 0.11, 0.12])
    fit = fit_lobe(np.full(3, 0.9), data, uncertainty=0.01)
    assert_allclose(fit.fitted, 0.11, rtol=1e-6)
    assert np.isinf(np.diag(fit.covariance)[fit.values < BOUNDS["beta"][1]]).any()
    assert_array_equal(fit.interval, [BOUNDS["beta"], BOUNDS["gamma"]])


def test_a_beta_beyond_its_bound_stays_there():
    bright = 1e7 * CURVE
    fit = fit_lobe(ANGLES, bright)
    assert fit.status == "at_bound"
    assert fit.beta == BOUNDS["beta"][1]
    assert fit.interval[0, 1] == fit.beta
    alone = fit_lobe(ANGLES, bright, free="beta", gamma=0.3)
    assert (alone.status, alone.beta) == ("at_bound", BOUNDS["beta"][1])


@given(
    seed=st.integers(0, 10_000),
    free=st.sampled_from([ALL, ALL[:2], ALL[1:], ("n",)]),
    masking=maskings,
    view=st.sampled_from([0.0, 0.3, VIEW, 1.5, np.pi / 2 - 1e-9]),
    noise=st.sampled_from([0.0, 0.1, 10.0]),
)
@example(seed=1005, free=ALL, masking="none", view=1.5, noise=10.0)  # slow to end
@settings(max_examples=50, deadline=None)
def test_every_result_is_a_number_within_bounds(seed, free, masking, view, noise):
    rng = np.random.default_rng(seed)
    data = rng.normal(0, noise, ANGLES.size) + np.abs(rng.normal(size=ANGLES.size))
    known = {"beta": 0.7, "gamma": 0.2}
    rest = {name: known[name] for name in known if name not in free}
    fit = fit_lobe(ANGLES, data, viewing=view, free=free, masking=masking, **rest)
    bounds = np.array([BOUNDS[name] for name in fit.parameters])
    assert ((fit.values >= bounds[:, 0]) & (fit.values <= bounds[:, 1])).all()
    assert not np.isnan(fit.covariance).any()
    low, high = fit.interval.T
    assert ((bounds[:, 0] <= low) & (low <= fit.values)).all()
    assert ((fit.values <= high) & (high <= bounds[:, 1])).all()
    assert np.isfinite(fit.fitted).all()
    assert np.isfinite(in_plane(fit.surface, ANGLES, view)).all()
    assert fit.status in STATUSES


def test_a_fit_that_did_not_converge_says_where_it_stopped(monkeypatch):
    from skinviz.surface import lobe_solver

    monkeypatch.setattr(lobe_solver, "_STEPS", 1)
    fit = fit_lobe(ANGLES, noisy(np.random.default_rng(9)), free=ALL)
    assert fit.status == "not_converged"
    with pytest.raises(FitError, match=r"stopped at beta .*, gamma .*, n "):
        fit.raise_for_status()


# --- α -------------------------------------------------------------------------


def test_alpha_is_the_share_of_lamberts_law():
    body = 0.35
    lambert = 0.8 * np.cos(ANGLES) * body
    assert_allclose(alpha_from_diffuse(ANGLES, lambert, body), 0.8, rtol=1e-14)
    factor = np.full(ANGLES.size, 0.8 * body)
    found = alpha_from_diffuse(ANGLES, factor, body, diffuser="alike")
    assert_allclose(found, 0.8, rtol=1e-14)


def test_alpha_is_least_squares():
    rng = np.random.default_rng(10)
    body = rng.uniform(0.2, 0.6, ANGLES.size)
    shape = np.cos(ANGLES) * body
    data = shape + rng.normal(0, 0.05, ANGLES.size)
    expected = np.linalg.lstsq(shape[:, None], data)[0][0]
    assert_allclose(alpha_from_diffuse(ANGLES, data, body), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("body", "told"),
    [(-0.1, "at least 0"), (0.0, "says nothing of alpha"), ([0.1, 0.2], "or 18")],
)
def test_bodies_that_are_none_are_refused(body, told):
    with pytest.raises(ArgumentError, match=told):
        alpha_from_diffuse(ANGLES, CURVE, body)


# --- refusals ------------------------------------------------------------------

HOLE = np.where(np.arange(ANGLES.size) == 3, np.nan, CURVE)


@pytest.mark.parametrize(
    ("angles", "data", "more", "told"),
    [
        ([], [], {}, "at least one; got shape"),
        (ANGLES, CURVE[:, None], {}, "must be a list"),
        (ANGLES, HOLE, {}, "readings must be finite; index 3"),
        (ANGLES, np.full(18, np.inf), {}, "readings must be finite; index 0"),
        (ANGLES, ["bright"] * 18, {}, "must be numbers"),
        (ANGLES, 0 * CURVE, {}, "no reading is above 0"),
        (ANGLES, -CURVE, {}, "no reading is above 0"),
        (ANGLES, 1e12 * CURVE, {}, "units of the perfect diffuser"),
        (ANGLES[:5], CURVE, {}, "illumination must be one number or 18"),
        (-ANGLES, CURVE, {}, r"illumination must be angles .* index 1 is -0.087"),
        (np.rad2deg(ANGLES), CURVE, {}, "turn degrees into radians"),
        (ANGLES, CURVE, {"viewing": 60}, "viewing must be angles"),
        (ANGLES, CURVE, {"viewing": np.nan}, "viewing must be finite"),
        (ANGLES[:2], CURVE[:2], {}, "2 readings are too few for beta, gamma"),
        (ANGLES[:1], CURVE[:1], {"uncertainty": 0.1}, "at least 2 are needed$"),
        (ANGLES, CURVE, {"free": ()}, "nothing is free"),
        (ANGLES, CURVE, {"free": ("alpha",)}, "unknown free parameter"),
        (ANGLES, CURVE, {"free": ("beta",)}, "gamma is neither free nor given"),
        (ANGLES, CURVE, {"gamma": 0.3}, "gamma is free; give no value"),
        (ANGLES, CURVE, {"free": "beta", "gamma": 2.0}, "gamma must be in"),
        (ANGLES, CURVE, {"n": 0.9}, "n must be in"),
        (ANGLES, CURVE, {"uncertainty": 0.0}, "uncertainty must be greater than 0"),
        (ANGLES, CURVE, {"uncertainty": [0.1, 0.2]}, "uncertainty must be one number"),
        (ANGLES, CURVE, {"uncertainty": -1.0}, "uncertainty must be greater than 0"),
        (ANGLES, CURVE, {"masking": "smith"}, "unknown masking"),
        (ANGLES, CURVE, {"diffuser": "white"}, "unknown diffuser"),
    ],
)
def test_what_cannot_be_fitted_is_refused(angles, data, more, told):
    with pytest.raises(ArgumentError, match=told):
        fit_lobe(angles, data, **more)
