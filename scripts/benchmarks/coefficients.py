"""Compare coefficient tables and say how weights depend on them.

``python scripts/benchmarks/coefficients.py --docs docs`` prints the tables of
``docs/coefficients.md``, puts them into that page and draws its figure. Tables are
tuned and cross-validated on NIST's people alone; ISSA served only to judge.
"""

import argparse
import sys
from dataclasses import astuple
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from coefficients_figure import draw
from coefficients_weights import (
    markdown,
    ranks_table,
    sensitivity_table,
    thickness_table,
    weights_table,
)
from tune_coefficients import NIST_SITE, issa_sse, nist, nist_sse

from skinviz.skin.coefficients import body_sites, layer_thickness
from skinviz.skin.formulas import (
    EffectiveNumbers,
    effective_coefficients,
    effective_data,
    effective_numbers,
)
from skinviz.skin.priors import NAMES, literature
from skinviz.skin.tuning import RESIDUAL_SCALE, Tuning, misfits, tune

FOLDS = 5
DEPTH = layer_thickness(NIST_SITE)
SHIPPED = "shipped"
VARIANTS = {
    "priors, included": ("included", 1.0),
    "priors, 0.03": (0.03, 1.0),
    "no priors, included": ("included", np.inf),
    "no priors, 0.03": (0.03, np.inf),
}
"""What is tuned on the odd people: specular and the factor on the priors."""

FOLDED = (("included", 1.0), ("included", np.inf), (0.03, 1.0))
"""What is cross-validated."""


def main() -> None:
    """Print every table; with ``--docs``, put them into the page, with its figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--docs", type=Path, help="folder of coefficients.md")
    docs = parser.parse_args().docs
    tuned = {
        name: tune(*nist("odd"), DEPTH, specular=how, prior_scale=scale)
        for name, (how, scale) in VARIANTS.items()
    }
    numbers = {SHIPPED: effective_numbers()}
    numbers |= {name: tuning.numbers for name, tuning in tuned.items()}
    retuned = tuned["priors, included"]
    tables = {
        "numbers": numbers_table(numbers, tuned),
        "quality": quality_table(numbers),
        "folds": folds_table(),
        "determined": determined_table(retuned),
        "scale": scale_table(retuned),
        "weights": weights_table(numbers[SHIPPED]),
        "sensitivity": sensitivity_table(numbers[SHIPPED]),
        "thickness": thickness_table(numbers[SHIPPED]),
        "ranks": ranks_table(numbers[SHIPPED], retuned.numbers),
    }
    for name, text in tables.items():
        print(f"\n{name}\n\n{text}", flush=True)
    if docs is not None:
        page = docs / "coefficients.md"
        page.write_text(filled(page.read_text("utf-8"), tables), encoding="utf-8")
        draw(docs / "images" / "coefficients.png", retuned.numbers)


def filled(page: str, tables: dict[str, str]) -> str:
    """Return a page with each table between its two marks, replaced."""
    for name, text in tables.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end {name} -->"
        before, _, rest = page.partition(begin)
        _, mark, after = rest.partition(end)
        if not mark:
            sys.exit(f"the page has no marks '{begin.strip()}' ... '{end}'")
        page = f"{before}{begin}{text}\n{end}{after}"
    return page


def numbers_table(
    numbers: dict[str, EffectiveNumbers], tuned: dict[str, Tuning]
) -> str:
    """Return the numbers of each variant, with their pull."""
    rows = []
    for name, values in numbers.items():
        tuning = tuned.get(name)
        pull = _pull(values)
        stuck = np.zeros(len(NAMES), bool) if tuning is None else tuning.at_bound
        rows.append(
            [name]
            + [
                f"{value:.2f} ({p:+.1f}){'*' if at else ''}"
                for value, p, at in zip(astuple(values), pull, stuck, strict=True)
            ]
        )
    return markdown(["table", *(name.replace("_", " ") for name in NAMES)], rows)


def quality_table(numbers: dict[str, EffectiveNumbers]) -> str:
    """Return how well each variant fits NIST and, once, ISSA."""
    rows = []
    for name, values in numbers.items():
        own = VARIANTS.get(name, ("included", 1.0))[0]
        for how in dict.fromkeys(("included", own, *((0.03,) * (name == SHIPPED)))):
            table = effective_coefficients(values, name)
            issa = issa_sse(table, how)
            pooled = np.concatenate(list(issa.values()))
            means = [nist_sse(table, how, group).mean() for group in ("odd", "even")]
            means += [sse.mean() for sse in (*issa.values(), pooled)]
            rows.append([name, str(how), *(f"{mean:.4f}" for mean in means)])
    sites = [f"ISSA {site}" for site in body_sites()]
    header = ["table", "specular", "NIST odd", "NIST even", *sites, "ISSA pooled"]
    return markdown(header, rows)


def folds_table() -> str:
    """Return the cross-validation on all of NIST's people."""
    spectra, bands = nist("all")
    fold = np.random.default_rng(0).permutation(len(spectra)) % FOLDS
    rows = []
    for how, scale in FOLDED:
        shipped = nist_sse(effective_coefficients(effective_numbers()), how, "all")
        held, found = np.zeros(len(spectra)), []
        for k in range(FOLDS):
            out = fold == k
            tuning = tune(
                *(spectra[~out], bands, DEPTH), specular=how, prior_scale=scale
            )
            table = effective_coefficients(tuning.numbers, "tuned")
            apart = misfits(
                *(spectra[out], bands, DEPTH), coefficients=table, specular=how
            )
            held[out] = (apart**2).sum(axis=1)
            found.append(astuple(tuning.numbers))
        gap = held - shipped
        ends = (np.min(found, axis=0), np.max(found, axis=0))
        rows.append(
            [
                *("priors" if np.isfinite(scale) else "no priors", str(how)),
                *(f"{shipped.mean():.4f}", f"{held.mean():.4f}"),
                f"{gap.mean():+.4f} ± {gap.std(ddof=1) / np.sqrt(gap.size):.4f}",
                f"{(gap < 0).mean():.0%}",
                *(f"{low:.2f} … {high:.2f}" for low, high in zip(*ends, strict=True)),
            ]
        )
    header = ["tuned with", "specular", "shipped", "tuned, held out", "difference"]
    names = [name.replace("_", " ") for name in NAMES]
    return markdown([*header, "people better", *names], rows)


def determined_table(tuning: Tuning) -> str:
    """Return how far the people determine each number, and what goes with what."""
    data = effective_data()
    errors = tuning.standard_errors()
    people = tuning.standard_errors(between_people=True)
    rows = [
        [
            f"{name.replace('_', ' ')} [{data[name]['unit']}]",
            *(f"{v:.2f}" for v in (value, error, between)),
            *(f"{tuning.pull[i]:+.2f}", f"{tuning.learned[i]:.0%}"),
            *(f"{r:+.2f}" for r in tuning.correlation[i]),
        ]
        for i, (name, value, error, between) in enumerate(
            zip(NAMES, astuple(tuning.numbers), errors, people, strict=True)
        )
    ]
    header = ["number", "value", "s.e.", "s.e. between people", "pull", "learned"]
    short = ["with melanin", "S_e", "S_d", "Rayleigh", "Mie"]
    note = f"The residuals ask for a scale of {tuning.implied_scale:.2f}."
    return f"{markdown([*header, *short], rows)}\n\n{note}"


def scale_table(retuned: Tuning) -> str:
    """Return what other weights of the priors would have given."""
    rows = []
    for factor in (0.25, 0.5, 1.0, 2.0):
        scale = factor * RESIDUAL_SCALE
        tuning = (
            retuned
            if factor == 1
            else tune(*nist("odd"), DEPTH, specular="included", residual_scale=scale)
        )
        table = effective_coefficients(tuning.numbers, "tuned")
        even = nist_sse(table, "included", "even").mean()
        rows.append(
            [
                f"{scale:.3f}",
                f"{tuning.implied_scale:.2f}",
                *(
                    f"{value:.2f} ({pull:+.1f})"
                    for value, pull in zip(
                        astuple(tuning.numbers), tuning.pull, strict=True
                    )
                ),
                *(f"{tuning.sse.mean():.4f}", f"{even:.4f}"),
            ]
        )
    names = [name.replace("_", " ") for name in NAMES]
    return markdown(["scale", "implied", *names, "NIST odd", "NIST even"], rows)


def _pull(numbers: EffectiveNumbers) -> np.ndarray:
    """Return how far numbers lie from the priors' means, in deviations."""
    priors = literature()
    return (priors.coordinates(numbers) - priors.mean) / priors.deviation


if __name__ == "__main__":
    main()
