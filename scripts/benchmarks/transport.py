"""Is Kubelka–Munk good enough? Two layers against radiative transport.

The same tissue, twice: Kubelka–Munk with each rule for its coefficients, and
adding–doubling (tests/oracles/transport.py). Prints the tables of docs/transport.md;
with ``--docs docs`` also writes ``images/transport.png`` there, and the CSV that
``skinviz figure transport`` draws.
Run in the development environment, on one thread so that the times compare:
``OPENBLAS_NUM_THREADS=1 python scripts/benchmarks/transport.py --docs docs``.
"""

import argparse
import csv
import platform
import time
from dataclasses import dataclass, replace
from pathlib import Path

import _transport_figure
import numpy as np
from _transport_print import DIFFERENCES, best_of, cost, gaps, spread, table
from _transport_spectra import (
    DERMIS,
    FITTED_RULES,
    MELANIN,
    SKIN_INDEX,
    WAVELENGTHS,
    Tissue,
    by_kubelka_munk,
    by_transport,
    colour_difference,
    differences,
    diffuse_interface,
    fit,
    textbook_tissue,
)

from skinviz._files import whole_file
from skinviz.skin.coefficients import body_sites
from skinviz.skin.interface import interface
from skinviz.skin.models import skin_model
from skinviz.skin.scattering_rules import SCATTERING_RULES

TABLE = Path(__file__).parents[2] / "skinviz" / "skin" / "data" / "transport.csv"

CASES = {
    "body": "under no surface, diffuse light: R_b",
    "body, beam": "under no surface, a beam along the normal: R_b",
    "sphere": "n = 1.4, a beam (8°/diffuse): specular included",
    "diffuse": "n = 1.4, diffuse light outside and inside",
}


@dataclass(frozen=True, eq=False)
class Results:
    """Reflectance (site, M, B, n): transport by case, R_b by rule."""

    sites: tuple[str, ...]
    transport: dict[str, np.ndarray]
    body: dict[str, np.ndarray]

    def model(self, case: str, body: np.ndarray) -> np.ndarray:
        """Return what skinviz says for a case, from a body reflectance."""
        if case == "sphere":
            return interface("included").measured(body)
        return diffuse_interface().measured(body) if case == "diffuse" else body


def compute() -> Results:
    """Compute all spectra."""
    tissue, sites = textbook_tissue(), body_sites()
    matched, skin = (by_transport(tissue, sites, n) for n in (1.0, SKIN_INDEX))
    return Results(
        sites,
        {
            "body": matched.diffuse,
            "body, beam": matched.collimated,
            "sphere": skin.collimated,
            "diffuse": skin.diffuse,
        },
        {rule: by_kubelka_munk(tissue, sites, rule) for rule in SCATTERING_RULES},
    )


def main() -> None:
    """Print every table; write the CSV and the figure where asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--docs", type=Path, help="folder for the figure")
    folder = parser.parse_args().docs
    start = time.perf_counter()
    print(
        f"{platform.machine()}, Python {platform.python_version()}, NumPy "
        f"{np.__version__}; {len(MELANIN)} melanin × {len(DERMIS)} blood × 4 sites, "
        f"{len(WAVELENGTHS)} bands"
    )
    results = compute()
    rules(results)
    interface_alone(results)
    along_melanin(results)
    by_site(results)
    fitted = fits(results)
    anisotropy()
    speed()
    if folder is not None:
        write_csv(TABLE, results)
        _transport_figure.draw(results, fitted, folder / "images" / "transport.png")
    print(f"\n{time.perf_counter() - start:.0f} s")


def rules(results: Results) -> None:
    """Print each case and rule over all skins, and the interface alone."""
    for case, meaning in CASES.items():
        truth = results.transport[case]
        rows = [
            (name, *differences(results.model(case, body), truth))
            for name, body in results.body.items()
        ]
        # Star's rule answers for lighter skins only: the others' value on those.
        lighter = np.isfinite(results.body["star"]).all(axis=-1)
        body = np.where(lighter[..., None], results.body["gate"], np.nan)
        rows.append(
            ("gate, star's skins", *differences(results.model(case, body), truth))
        )
        if case in ("sphere", "diffuse"):
            exact = results.transport["body"]
            rows.append(
                ("transport R_b", *differences(results.model(case, exact), truth))
            )
        table(f"{case}: {meaning}", DIFFERENCES, rows)


def interface_alone(results: Results) -> None:
    """Print where the interface form errs when R_b itself is exact."""
    bands = (430.0, 560.0, 700.0)
    at = np.searchsorted(WAVELENGTHS, bands)
    exact, truth = results.transport["body"], results.transport["sphere"]
    delta = (results.model("sphere", exact) - truth)[..., at]
    light, bloody = MELANIN.argmin(), DERMIS[:, 0] == DERMIS[:, 0].max()
    rows = [
        (f"melanin {m:.0%}, no blood to 7 %", *(f"{x:+.3f}" for x in mean))
        for m, mean in zip(MELANIN, delta.mean(axis=(0, 2)), strict=True)
    ]
    mean = delta[:, light][:, bloody].mean(axis=(0, 1))
    rows.append(("melanin 1%, 7 % blood", *(f"{x:+.3f}" for x in mean)))
    head = ("skins", *(f"{band:.0f} nm" for band in bands))
    table("sphere, transport R_b in the interface form: mean ΔR", head, rows)


def along_melanin(results: Results) -> None:
    """Print the mean ΔE00 of each rule by melanin fraction."""
    for case in ("body", "sphere"):
        rows = []
        for name, body in results.body.items():
            delta_e = colour_difference(
                results.model(case, body), results.transport[case]
            )
            known = np.isfinite(delta_e)
            sums = np.where(known, delta_e, 0).sum(axis=(0, 2))
            counts = known.sum(axis=(0, 2))
            rows.append((name, *np.where(counts, sums / np.maximum(counts, 1), np.nan)))
        head = ("rule", *(f"{m:.0%}" for m in MELANIN))
        table(f"{case}: mean ΔE00 by melanin fraction", head, rows)


def by_site(results: Results) -> None:
    """Print each case of two rules by body site."""
    for case in ("body", "sphere"):
        rows = [
            (
                f"{rule}, {site}",
                *differences(
                    results.model(case, results.body[rule][i]),
                    results.transport[case][i],
                ),
            )
            for rule in ("gate", "meador_weaver")
            for i, site in enumerate(results.sites)
        ]
        table(f"{case}: by body site", ("rule, site", *DIFFERENCES[1:]), rows)


def fits(results: Results) -> dict[str, np.ndarray]:
    """Print what a fit makes of transport's data; return ΔE00 (site, M, B)."""
    left, rows, by_melanin = {}, [], []
    for case, specular in (("body", "excluded"), ("sphere", "included")):
        for rule in FITTED_RULES:
            name = f"{case}, {rule}"
            found = fit(results.transport[case], results.sites, rule, specular)
            ratios = _against_truth(found)
            oxygen = f"{ratios[2].mean():+.2f}", f"{spread(ratios[2])[1]}"
            rmse = np.array([f.rmse for f in found])
            left[name] = np.array([f.delta_e for f in found])
            told = [text for ratio in ratios[:2] for text in spread(ratio)]
            of_residual = rmse.mean(), left[name].mean(), left[name].max()
            rows.append((name, *told, *oxygen, *of_residual))
            if rule == "gate":
                for what, ratio in zip(
                    ("w_m / true", "blood / true", "saturation − true"), ratios,
                    strict=True,
                ):  # fmt: skip
                    by_melanin.append((f"{name}, {what}", *ratio.mean(axis=(0, 2))))
    head = ("case, rule", "w_m / true", "range", "blood / true", "range",
            "saturation − true", "range", "RMSE", "ΔE00 mean", "ΔE00 max")  # fmt: skip
    table("fits of transport's spectra: mean (smallest … largest)", head, rows)
    head = ("case, rule, weight", *(f"{m:.0%}" for m in MELANIN))
    table("fits of transport's spectra: mean by melanin fraction", head, by_melanin)
    return left


def _against_truth(found: list) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return w_m and blood over the true ones, and the error of the saturation."""
    blood, saturation = DERMIS.T
    melanin = np.array([f.values[..., 0] for f in found]) / MELANIN[:, None]
    amount = np.array([f.blood_fraction for f in found])[..., 1:] / blood[1:]
    oxygen = np.array([f.oxygen_saturation for f in found]) - saturation
    # Under 1 % blood the saturation is hardly seen by any model.
    return melanin, amount, oxygen[..., blood >= 0.01]


def anisotropy() -> None:
    """Print how much g matters at the same μ_s′."""
    tissue, sites = textbook_tissue(), ("back of hand",)
    rows = []
    for n, name in ((1.0, "body"), (SKIN_INDEX, "sphere")):
        own = by_transport(tissue, sites, n)
        for g in (0.0, 0.5, 0.9):
            other = by_transport(replace(tissue, g=np.full_like(tissue.g, g)), sites, n)
            pick = "diffuse" if name == "body" else "collimated"
            pair = getattr(other, pick), getattr(own, pick)
            rows.append((f"{name}, g = {g}", *differences(*pair)))
    head = ("case", *DIFFERENCES[1:])
    table("another g, the same μ_s′, against van Gemert's g (back of hand)", head, rows)


def speed() -> None:
    """Print accuracy and time of quadratures, and of Kubelka–Munk, in one run."""
    whole, sites = textbook_tissue(), ("cheek",)
    corners = replace(whole, mu_a=(whole.mu_a[0][[0, -1]], whole.mu_a[1][[0, -1]]))
    one = replace(whole, mu_a=(whole.mu_a[0][3:4], whole.mu_a[1][5:6]))
    model = skin_model(site="cheek", specular="included", coefficients="textbook")
    weights = np.broadcast_to([0.12, 0.006, 0.004], (1000, 3))
    single = best_of(lambda: model.measured(weights[0], WAVELENGTHS), 200)
    batch = best_of(lambda: model.measured(weights, WAVELENGTHS), 20) / len(weights)
    exact = _both(corners, sites, 64)
    body = by_kubelka_munk(corners, sites, "gate")
    own = body, model.interface.measured(body)
    rows = [("Kubelka–Munk, a batch", *gaps(own, exact), *cost(batch, single))]
    rows.append(("Kubelka–Munk, one by one", *gaps(own, exact), *cost(single, single)))
    for points in (4, 8, 16, 32):
        found = _both(corners, sites, points)
        seconds = best_of(lambda p=points: by_transport(one, sites, SKIN_INDEX, p), 20)
        rows.append(
            (f"transport, {points} points", *gaps(found, exact), *cost(seconds, single))
        )
    head = ("method", "max ΔR, body", "max ΔR, sphere", "ms a spectrum", "times")
    table("accuracy against 64 points, and time", head, rows)


def _both(
    tissue: Tissue, sites: tuple[str, ...], points: int
) -> tuple[np.ndarray, ...]:
    """Return transport's reflectance of the body and in a sphere."""
    body, sphere = (by_transport(tissue, sites, n, points) for n in (1.0, SKIN_INDEX))
    return body.diffuse, sphere.collimated


def write_csv(path: Path, results: Results) -> None:
    """Write every case, rule, site and melanin fraction as one row."""
    header = "case rule site melanin skins mean_dR rms_dR max_dR mean_dE00 max_dE00"
    rows = [
        (
            case,
            rule,
            site,
            melanin,
            *(
                f"{x:.4g}"
                for x in differences(
                    results.model(case, body[i, m]), results.transport[case][i, m]
                )
            ),
        )
        for case in CASES
        for rule, body in results.body.items()
        for i, site in enumerate(results.sites)
        for m, melanin in enumerate(MELANIN)
    ]
    with (
        whole_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        csv.writer(file, lineterminator="\n").writerows([header.split(), *rows])


if __name__ == "__main__":
    main()
