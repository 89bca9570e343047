"""Tables II and III of the paper on real people: ``python scripts/tables_2_and_3.py``.

Writes ``docs/tables.md`` and, in ``docs/tables``, what ``skinviz figure table-2
table-3`` makes. Each number on the page is computed here. Run it again when a model, a
coefficient set or the archive has changed; another folder than ``docs`` may be named.
"""

import sys
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from skinviz import figure, skin_models
from skinviz._files import whole_file
from skinviz.skin.skin_fit import AT_BOUND
from skinviz.study.paper_tables import (
    ANGLE_SITE,
    CLAIMS,
    PER_AREA,
    QUANTILES,
    in_papers_layout,
)
from skinviz.study.tables import (
    COEFFICIENTS,
    PAPER_ERRORS,
    PAPER_WEIGHTS,
    SITES,
    Method,
    compare,
)
from skinviz.view.gallery.people import everyone, method, subjects
from skinviz.view.gallery.text import as_markdown

DOCS = Path(__file__).parents[1] / "docs"
PAGE = Path(__file__).with_name("tables_2_and_3_page.md")
PROPOSED = "two-layer"


def who() -> pd.DataFrame:
    """Return who takes the place of the paper's subjects."""
    people = everyone()
    angles = people.typology_angle(ANGLE_SITE)
    return pd.DataFrame(
        {
            "subject": subject,
            "person": people.names[i],
            "recorded as": people.descriptions[i],
            "quantile": QUANTILES[subject],
            "ITA, °": f"{angles[i]:.1f}",
        }
        for subject, i in subjects().items()
    )


def status(methods: list[Method]) -> pd.DataFrame:
    """Return how many fits failed or ended at a bound, and which weights at 0."""
    return pd.DataFrame(
        {
            "coefficients": own.coefficients,
            "model": own.model,
            "not fitted": own.n_failed,
            "at a bound": f"{np.mean(own.status == AT_BOUND):.0%}",
            **{
                f"{name} = 0": f"{np.mean(own.parameter(name) == 0):.0%}"
                for name in PAPER_WEIGHTS
            },
        }
        for own in methods
    )


def duels(methods: list[Method]) -> str:
    """Say how the paper's model fares against each other one."""
    lines = []
    for coefficients in dict.fromkeys(own.coefficients for own in methods):
        named = {m.model: m for m in methods if m.coefficients == coefficients}
        first = named.pop(PROPOSED)
        for name, other in named.items():
            duel = compare(first, other)
            ratio = duel.second / duel.first
            verdict = "beats" if ratio > 1 else "does not beat"
            lines.append(
                f"- `{coefficients}`: `{PROPOSED}` {verdict} `{name}` on average: "
                f"{duel.first:.4f} against {duel.second:.4f}, a ratio of {ratio:.2f}; "
                f"it fits {duel.wins:.0%} of {duel.n} spectra better "
                f"({len(first.parameters)} against {len(other.parameters)} "
                "free parameters)."
            )
    return "\n".join(lines) or "There is no other model to compare it with."


def verdicts(claims: pd.DataFrame) -> pd.DataFrame:
    """Return what the tests make of each claim of the paper: a row a method."""
    per_area = [(PER_AREA, *rest) for name, *rest in CLAIMS if name == "w_m"]
    rows = []
    for (coefficients, model), own in claims.groupby(
        ["coefficients", "model"], sort=False
    ):
        row = {"coefficients": coefficients, "model": model}
        for claim in (*CLAIMS, *per_area):
            name, site, way = claim
            matching = own[["quantity", "site", "claim"]].eq(list(claim)).all(axis=1)
            row[f"{name}: {site} {way}"] = verdict_of(own[matching])
        rows.append(row)
    return pd.DataFrame(rows)


def verdict_of(contrasts: pd.DataFrame) -> str:
    """Return the verdict on a claim with the p that decides it."""
    told, p = contrasts["verdict"].iloc[0], contrasts["p_corrected"]
    if told == "contradicted":
        sign = 1 if contrasts["claim"].iloc[0] == "most" else -1
        p = p[sign * contrasts["effect"] < 0]
        return f"{told}, p = {p.min():.0e}"
    return f"{told}, p = {p.max():.0e}"


def page(
    methods: list[Method], second: dict[str, pd.DataFrame], third: pd.DataFrame
) -> str:
    """Return the page."""
    people = everyone()
    paper_2 = pd.DataFrame({"site": SITES, **PAPER_WEIGHTS})
    paper_3 = pd.DataFrame(
        {"method": name, **dict(zip(SITES, own, strict=True))}
        for name, own in PAPER_ERRORS.items()
    )
    factors = np.divide(PAPER_ERRORS["previous"], PAPER_ERRORS["proposed"])
    weights = "\n".join(
        f"**{title}**\n\n{as_markdown(rows)}"
        for title, rows in in_papers_layout(second[""]).items()
    )
    return PAGE.read_text("utf-8").format(
        n=len(people.names),
        source=people.source,
        specular=people.specular,
        who=as_markdown(who()),
        paper_2=as_markdown(paper_2),
        paper_3=as_markdown(paper_3),
        weights=weights,
        order=as_markdown(second["orders"]),
        verdicts=as_markdown(verdicts(second["claims"])),
        errors=as_markdown(third),
        duels=duels(methods),
        low=factors.min(),
        high=factors.max(),
        status=as_markdown(status(methods)),
        n_spectra=methods[0].sse_61.size,
        angle_site=ANGLE_SITE,
    )


def main(docs: Path = DOCS) -> None:
    """Write the tables and the page."""
    made = {name: figure(name) for name in ("table-2", "table-3")}
    for own in made.values():
        print(*own.save(docs / "tables"), sep="\n")
    methods = [method(m, c) for c, m in product(COEFFICIENTS, skin_models())]
    text = page(methods, dict(made["table-2"].tables), made["table-3"].tables[""])
    with whole_file(docs / "tables.md") as partial:
        partial.write_text(text, encoding="utf-8")
    print(docs / "tables.md")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit("usage: tables_2_and_3.py [FOLDER]")
    main(*(Path(word) for word in sys.argv[1:]))
