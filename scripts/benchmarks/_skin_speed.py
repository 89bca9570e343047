"""How fast spectra are computed and fitted, for ``skin_fit.py``."""

import os
import time

import numpy as np
from _print import Row, on_one_core, race, rate
from _skin_data import NM, Batch, real, repeated, simulated
from _skin_scipy import SCALE, compiled_curve, fit, numpy_curve
from _skin_solver import evaluations, shares

from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model

FLOOR = 1e-3  # how much worse a mean SSE may be for a setting to count


def forward(m: int, times: int) -> list[Row]:
    """Return spectra computed per second beside the filling of their array."""
    model = skin_model(site="back of hand", specular="included")
    rng = np.random.default_rng(5)
    weights = rng.uniform((0.02, 0, 0), (0.4, 0.03, 0.02), (m, 3))

    def reflectance() -> None:
        model.reflectance(weights, NM)

    def measured() -> None:
        model.measured(weights, NM)

    def fill() -> None:
        np.full((m, NM.size), 0.5)

    seconds = race(
        {
            "fill": fill,
            "reflectance": reflectance,
            "measured": measured,
            "reflectance, one core": on_one_core(reflectance),
            "measured, one core": on_one_core(measured),
        },
        times,
    )
    bare = seconds.pop("fill")
    told = [
        f"{name} {rate(m / taken)} ({taken / bare:.1f} × the fill)"
        for name, taken in seconds.items()
    ]
    figure = (
        f"two-layer spectra, {m:,} × 61 bands into a new array; a bare fill of it is "
        f"{rate(m / bare)}"
    )
    return [Row(figure, "4 M/s", "; ".join(told))]


def fits(m: int, times: int) -> list[Row]:
    """Return spectra fitted per second: real ones of each site, simulated ones."""
    batches = [repeated(batch, m) for batch in real()] + [simulated(m)]
    runners = {}
    for batch in batches:
        runners[batch.name] = _runner(batch)
        runners[f"{batch.name}, one core"] = on_one_core(_runner(batch))
    seconds = race(runners, times)
    rows = []
    for batch in batches:
        both, one = seconds[batch.name], seconds[f"{batch.name}, one core"]
        small = Batch(batch.name, batch.model, batch.spectra[:20_000])
        part = shares(small, times)
        rows.append(
            Row(
                f"fit of {m:,} spectra, 61 bands, {_told(batch)}, on "
                f"{len(os.sched_getaffinity(0))} cores (one)",
                "460 k/s",
                f"{rate(m / both)} ({rate(m / one)}); solver "
                f"{part.solver / part.total:.0%}, conclusions "
                f"{part.conclusions / part.total:.0%}, copies "
                f"{part.copies / part.total:.0%} of a thread; "
                f"{evaluations(small):.2f} model calls a spectrum; mean SSE "
                f"{fit_skin(small.spectra, NM, batch.model).sse.mean():.4f}",
            )
        )
    return rows


def against_scipy(m: int, few: int, times: int) -> list[Row]:
    """Return how many times faster a batch is fitted than in a loop over SciPy.

    SciPy gets its own tolerances, the analytic Jacobian, and of its bounded methods
    whichever is the fastest here.
    """
    rows = []
    for batch in (repeated(real()[1], m), simulated(m)):
        seconds, sse = _scipy_race(batch, few, times)
        own = m / seconds.pop("own")
        told = []
        for kind in ("NumPy", "compiled"):
            best = min(sse[name] for name in seconds)
            fair = [
                name
                for name in seconds
                if kind in name and sse[name] <= best * (1 + FLOOR)
            ]
            first = min(fair, key=seconds.__getitem__)
            told.append(
                f"{own * seconds[first] / few:.0f} × ({first}: "
                f"{seconds[first] / few * 1e3:.2f} ms a spectrum)"
            )
        found = fit_skin(batch.spectra[:few], NM, batch.model).sse.mean()
        rows.append(
            Row(
                f"– against a scipy.optimize.least_squares loop, {_told(batch)}",
                "500 ×",
                f"{told[0]}; with the package's own model in it {told[1]}; mean SSE "
                f"{found:.7f}, SciPy {min(sse.values()):.7f}",
            )
        )
    return rows


def _scipy_race(
    batch: Batch, few: int, times: int
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the times of all settings and of the package, and SciPy's mean SSE."""
    curves = {"NumPy": numpy_curve(batch), "compiled": compiled_curve(batch)}
    runners, sse = {"own": _runner(batch)}, {}

    def loop(curve, method, scale):
        return lambda: [
            fit(curve, spectrum, method=method, x_scale=scale).cost
            for spectrum in batch.spectra[:few]
        ]

    for kind, curve in curves.items():
        for method in ("trf", "dogbox"):
            for scale, called in ((1.0, "1"), (SCALE, "sizes"), ("jac", "jac")):
                name = f"{kind} model, {method}, x_scale {called}"
                runners[name] = loop(curve, method, scale)
                sse[name] = 2 * float(np.mean(runners[name]()))
    return race(runners, times), sse


def image(side: int, name: str) -> list[Row]:
    """Return the time for a square image, float32, as it comes from a camera."""
    batch = repeated(next(b for b in real() if b.name == name), side * side)
    pixels = batch.spectra.astype(np.float32).reshape(side, side, NM.size)
    start = time.perf_counter()
    fit_skin(pixels, NM, batch.model)
    seconds = time.perf_counter() - start
    return [
        Row(
            f"an image of {side} × {side}, 61 bands, float32, {_told(batch)}, fitted",
            "–",
            f"{seconds:.1f} s, measured once; {rate(side * side / seconds)}",
        )
    ]


def _runner(batch: Batch):
    """Return a call that fits a batch."""
    return lambda: fit_skin(batch.spectra, NM, batch.model)


def _told(batch: Batch) -> str:
    """Return where spectra come from."""
    if batch.name == "simulated":
        return "simulated with noise"
    return f"real skin ({batch.name})"
