"""Tables II and III of the paper on real people: ``python scripts/tables_2_and_3.py``.

Writes ``docs/tables.md`` and, in ``docs/tables``, both tables as CSV and text, for
every skin model and coefficient set. Each number on the page is computed here. Run
it again when a model, a coefficient set or the archive has changed; another folder
than ``docs`` may be named.
"""

import csv
import io
import sys
from pathlib import Path

import numpy as np

from skinviz import load_archive, skin_models
from skinviz._files import whole_file
from skinviz.skin.skin_fit import AT_BOUND
from skinviz.study.people import People, at_quantiles, people_at
from skinviz.study.tables import (
    COEFFICIENTS,
    PAPER_ERRORS,
    PAPER_WEIGHTS,
    SITES,
    Method,
    compare,
    fit_people,
    order_agreement,
)

DOCS = Path(__file__).parents[1] / "docs"
PAGE = Path(__file__).with_name("tables_2_and_3_page.md")
PROPOSED = "two-layer"
QUANTILES = {"A": 0.9, "B": 0.5, "C": 0.1}
ANGLE_SITE = "inner arm"
Rows = list[list[str]]


def choose(people: People) -> dict[str, int]:
    """Return subjects A, B and C: by skin colour alone, never by a fit."""
    angles = people.typology_angle(ANGLE_SITE)
    return dict(
        zip(QUANTILES, at_quantiles(angles, [*QUANTILES.values()]), strict=True)
    )


def table_2(people: People, subjects: dict[str, int], methods: list[Method]) -> Rows:
    """Return Table II, one line a weight, with the means over everyone beneath."""
    head = (
        "coefficients model subject person site parameter unit value lower upper status"
    )
    rows = [head.split()]
    for method in methods:
        names = list(zip(method.parameters, method.units, strict=True))
        for subject, i in subjects.items():
            for s, site in enumerate(people.sites):
                for k, (name, unit) in enumerate(names):
                    numbers = (method.values[i, s, k], *method.interval[i, s, k])
                    rows.append(
                        [
                            *(method.coefficients, method.model, subject),
                            *(people.names[i], site, name, unit),
                            *(f"{number:.6g}" for number in numbers),
                            str(method.status[i, s]),
                        ]
                    )
        mean = np.nanmean(method.values, axis=0)
        everyone = f"{len(people.names)} people"
        rows += [
            [
                *(method.coefficients, method.model, "mean", everyone, site),
                *(name, unit, f"{mean[s, k]:.6g}", "", "", ""),
            ]
            for s, site in enumerate(people.sites)
            for k, (name, unit) in enumerate(names)
        ]
    return rows


def table_3(people: People, subjects: dict[str, int], methods: list[Method]) -> Rows:
    """Return Table III, one line a subject and method, means beneath."""
    rows = [["coefficients", "subject", "person", "model", *people.sites]]
    chosen = list(subjects.values())
    for coefficients in COEFFICIENTS:
        own = [m for m in methods if m.coefficients == coefficients]
        for subject, i in subjects.items():
            rows += [
                [coefficients, subject, people.names[i], m.model, *errors(m.sse_61[i])]
                for m in own
            ]
        for subject, person, which in (
            ("average", "A, B, C", chosen),
            ("mean", f"{len(people.names)} people", range(len(people.names))),
        ):
            rows += [
                [
                    *(coefficients, subject, person, m.model),
                    *errors(np.nanmean(m.sse_61[list(which)], axis=0)),
                ]
                for m in own
            ]
    return rows


def errors(values: np.ndarray) -> list[str]:
    """Return errors as text."""
    return [f"{value:.4f}" for value in values]


def weights_blocks(
    people: People, subjects: dict[str, int], methods: list[Method]
) -> list[tuple[str, Rows]]:
    """Return Table II in the paper's layout: sites down, weights across."""
    blocks = []
    for method in methods:
        rows = [["subject", "site", *method.parameters, "status"]]
        for subject, i in subjects.items():
            for s, site in enumerate(people.sites):
                weights = [f"{value:.3g}" for value in method.values[i, s]]
                status = str(method.status[i, s]).replace("_", " ")
                rows.append([subject, site, *weights, status])
        mean = np.nanmean(method.values, axis=0)
        for s, site in enumerate(people.sites):
            rows.append(["mean", site, *(f"{value:.3g}" for value in mean[s]), ""])
        blocks.append((f"{method.model}, {method.coefficients}", rows))
    return blocks


def as_text(rows: Rows) -> str:
    """Return rows as an aligned table."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = (
        "  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)) for r in rows
    )
    return "\n".join(line.rstrip() for line in lines) + "\n"


def as_markdown(rows: Rows) -> str:
    """Return rows as a Markdown table."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([lines[0], "|---" * len(rows[0]) + "|", *lines[1:]]) + "\n"


def as_csv(rows: Rows) -> str:
    """Return rows as CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def order_rows(subjects: dict[str, int], methods: list[Method]) -> Rows:
    """Return how far each weight's order between sites is the paper's."""
    head = ["coefficients", "model", "weight", *subjects, "means", "everyone"]
    rows = [[*head, "order of the means"]]
    for method in methods:
        for name in [n for n in PAPER_WEIGHTS if n in method.parameters]:
            own, paper = method.parameter(name), PAPER_WEIGHTS[name]
            mean = np.nanmean(own, axis=0)
            shares = [
                *(float(order_agreement(own[i], paper)) for i in subjects.values()),
                float(order_agreement(mean, paper)),
                float(np.nanmean(order_agreement(own, paper))),
            ]
            order = " > ".join(SITES[s] for s in np.argsort(-mean))
            labels = [method.coefficients, method.model, name]
            rows.append([*labels, *(f"{share:.2f}" for share in shares), order])
    return rows


def status_rows(methods: list[Method]) -> Rows:
    """Return how many fits failed or ended at a bound, and which weights at 0."""
    heads = [f"{name} = 0" for name in PAPER_WEIGHTS]
    rows = [["coefficients", "model", "not fitted", "at a bound", *heads]]
    for method in methods:
        shares = [
            f"{np.mean(method.parameter(name) == 0):.0%}"
            if name in method.parameters
            else "-"
            for name in PAPER_WEIGHTS
        ]
        bound = f"{np.mean(method.status == AT_BOUND):.0%}"
        labels = [method.coefficients, method.model, str(method.n_failed)]
        rows.append([*labels, bound, *shares])
    return rows


def duel_lines(methods: list[Method]) -> str:
    """Say how the paper's model fares against each other one."""
    lines = []
    for coefficients in COEFFICIENTS:
        own = {m.model: m for m in methods if m.coefficients == coefficients}
        for name in [n for n in own if n != PROPOSED]:
            duel = compare(own[PROPOSED], own[name])
            ratio = duel.second / duel.first
            verdict = "beats" if ratio > 1 else "does not beat"
            lines.append(
                f"- `{coefficients}`: `{PROPOSED}` {verdict} `{name}` on average: "
                f"{duel.first:.4f} against {duel.second:.4f}, a ratio of {ratio:.2f}; "
                f"it fits {duel.wins:.0%} of {duel.n} spectra better "
                f"({len(own[PROPOSED].parameters)} against {len(own[name].parameters)} "
                "free parameters)."
            )
    return "\n".join(lines) or "There is no other model to compare it with."


def page(people: People, subjects: dict[str, int], methods: list[Method]) -> str:
    """Return the page."""
    angles = people.typology_angle(ANGLE_SITE)
    who = [["subject", "person", "recorded as", "quantile", "ITA, °"]]
    for subject, i in subjects.items():
        about = (people.names[i], people.descriptions[i], f"{QUANTILES[subject]:g}")
        who.append([subject, *about, f"{angles[i]:.1f}"])
    paper_2 = [["site", *PAPER_WEIGHTS]]
    paper_2 += [
        [site, *(f"{w[s]}" for w in PAPER_WEIGHTS.values())]
        for s, site in enumerate(SITES)
    ]
    paper_3 = [["method", *SITES]]
    paper_3 += [
        [name, *(f"{e:.3f}" for e in own)] for name, own in PAPER_ERRORS.items()
    ]
    factors = np.divide(PAPER_ERRORS["previous"], PAPER_ERRORS["proposed"])
    weights = "\n".join(
        f"**{title}**\n\n{as_markdown(rows)}"
        for title, rows in weights_blocks(people, subjects, methods)
    )
    return PAGE.read_text("utf-8").format(
        n=len(people.names),
        source=people.source,
        specular=people.specular,
        who=as_markdown(who),
        paper_2=as_markdown(paper_2),
        paper_3=as_markdown(paper_3),
        weights=weights,
        order=as_markdown(order_rows(subjects, methods)),
        errors=as_markdown(table_3(people, subjects, methods)),
        duels=duel_lines(methods),
        low=factors.min(),
        high=factors.max(),
        status=as_markdown(status_rows(methods)),
        n_spectra=methods[0].sse_61.size,
        angle_site=ANGLE_SITE,
    )


def write(path: Path, text: str) -> None:
    """Write a text file, whole or not at all, and say so."""
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")
    print(path)


def main(docs: Path = DOCS) -> None:
    """Fit everyone with every method and write the tables and the page."""
    people = people_at(load_archive("issa"), SITES)
    subjects = choose(people)
    methods = [
        fit_people(people, model, coefficients)
        for coefficients in COEFFICIENTS
        for model in skin_models()
    ]
    second, third = (make(people, subjects, methods) for make in (table_2, table_3))
    blocks = weights_blocks(people, subjects, methods)
    tables = docs / "tables"
    write(tables / "table_2.csv", as_csv(second))
    write(
        tables / "table_2.txt",
        "\n".join(f"{title}\n\n{as_text(rows)}" for title, rows in blocks),
    )
    write(tables / "table_3.csv", as_csv(third))
    write(tables / "table_3.txt", as_text(third))
    write(docs / "tables.md", page(people, subjects, methods))


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit("usage: tables_2_and_3.py [FOLDER]")
    main(*(Path(word) for word in sys.argv[1:]))
