"""Refit the numbers of the ``effective`` coefficient table to the NIST archive.

``python scripts/tune_coefficients.py`` prints the numbers with their errors, how well
they fit the people they were fitted to, the other half of them, and, to judge and
never to choose by, another archive. It changes no file: to adopt the numbers, write
them into ``skinviz/skin/data/effective.toml`` and run ``make_coefficients.py``.
"""

import argparse
from dataclasses import astuple

import numpy as np

from skinviz.skin.coefficients import Coefficients, body_sites, layer_thickness
from skinviz.skin.formulas import effective_coefficients, effective_data
from skinviz.skin.priors import NAMES
from skinviz.skin.tuning import RESIDUAL_SCALE, Tuning, misfits, tune
from skinviz.spectra.archives import load_archive

NIST_SITE = "inner arm"
GROUPS = {"odd": (1,), "even": (0,), "all": (0, 1)}


def specular(text: str) -> str | float:
    """Return how spectra were measured, as the models take it."""
    return text if text in ("included", "excluded") else float(text)


def arguments() -> argparse.Namespace:
    """Return what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        *("--specular",),
        type=specular,
        default="included",
        help="included, excluded, or a constant as 0.03",
    )
    parser.add_argument("--subjects", choices=GROUPS, default="odd")
    parser.add_argument("--residual-scale", type=float, default=RESIDUAL_SCALE)
    parser.add_argument(
        *("--prior-scale",),
        type=float,
        default=1.0,
        help="factor on the priors' deviations; inf leaves them out",
    )
    return parser.parse_args()


def nist(subjects: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectra (m, n) of a group of NIST's people, and the wavelengths."""
    archive = load_archive("nist")
    number = archive.subject.values.astype(int)
    chosen = np.isin(number % 2, GROUPS[subjects])
    return archive.reflectance.values[chosen], archive.wavelength.values


def nist_sse(table: Coefficients, how: str | float, subjects: str) -> np.ndarray:
    """Return the sum of squares (m,) of each of NIST's people with a table."""
    spectra, bands = nist(subjects)
    apart = misfits(
        *(spectra, bands, layer_thickness(NIST_SITE)), coefficients=table, specular=how
    )
    return (apart**2).sum(axis=1)


def issa_sse(table: Coefficients, how: str | float) -> dict[str, np.ndarray]:
    """Return the sums of squares × 61/31 of ISSA's whole spectra, by body site."""
    archive = load_archive("issa")
    bands = archive.wavelength.values
    visible = (bands >= 400) & (bands <= 700)
    whole = np.isfinite(archive.reflectance.values[:, visible]).all(axis=1)
    found = {}
    for site in body_sites():
        spectra = archive.reflectance.values[whole & (archive.site.values == site)]
        apart = misfits(
            *(spectra, bands, layer_thickness(site)), coefficients=table, specular=how
        )
        found[site] = (apart**2).sum(axis=1) * 61 / 31
    return found


def report(tuning: Tuning, how: str | float, subjects: str) -> None:
    """Print the numbers and how well they fit whom."""
    data = effective_data()
    people = tuning.standard_errors(between_people=True)
    print(
        f"{'number':22}{'value':>8}{'s.e.':>8}{'people':>8}{'pull':>7}{'learned':>9}"
        "  unit"
    )
    rows = zip(
        *(NAMES, astuple(tuning.numbers), tuning.standard_errors(), people),
        *(tuning.pull, tuning.learned, tuning.at_bound),
        strict=True,
    )
    for name, value, error, between, pull, learned, stuck in rows:
        note = "  at the bound of the search: not determined" if stuck else ""
        print(
            f"{name:22}{value:8.3f}{error:8.3f}{between:8.3f}{pull:+7.2f}"
            f"{learned:9.2f}  {data[name]['unit']}{note}"
        )
    print("correlations, in this order:")
    for row in tuning.correlation:
        print("  " + " ".join(f"{value:+.2f}" for value in row))
    print(f"the residuals ask for a residual scale of {tuning.implied_scale:.3f}")
    table = effective_coefficients(tuning.numbers, "tuned")
    for group in ("odd", "even"):
        seen = "fitted" if subjects in (group, "all") else "held out"
        print(f"NIST {group} ({seen}): {nist_sse(table, how, group).mean():.5f}")
    judged = issa_sse(table, how)
    for site, sse in judged.items():
        print(f"ISSA {site}: mean SSE x 61/31 {sse.mean():.4f} on {sse.size}")
    print(f"ISSA pooled: {np.concatenate(list(judged.values())).mean():.4f}")


def main() -> None:
    """Tune as the command line says and print what came of it."""
    given = arguments()
    tuning = tune(
        *(*nist(given.subjects), layer_thickness(NIST_SITE)),
        specular=given.specular,
        residual_scale=given.residual_scale,
        prior_scale=given.prior_scale,
    )
    print(
        f"specular {given.specular}, {given.subjects} people of NIST, residual scale "
        f"{given.residual_scale:g}, priors x {given.prior_scale:g}, "
        f"{'converged' if tuning.converged else 'NOT CONVERGED'}"
    )
    report(tuning, given.specular, given.subjects)


if __name__ == "__main__":
    main()
