"""The rows of the paper's Tables I to III, for people of an archive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.coefficients import layer_thickness
from skinviz.study.orders import Contrast, paired_contrast, verdict
from skinviz.study.people import People, at_quantiles
from skinviz.study.statistics import holm
from skinviz.study.tables import (
    PAPER_WEIGHTS,
    SITES,
    Method,
    order_agreement,
)

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

QUANTILES = {"A": 0.9, "B": 0.5, "C": 0.1}
"""Of skin colour: who takes the place of the paper's subjects."""

ANGLE_SITE = "inner arm"
"""Where that colour is read: the sun hardly reaches it."""

CLAIMS = (
    ("w_m", "cheek", "most"),
    ("w_m", "inner arm", "least"),
    ("w_h", "cheek", "most"),
)
"""What the paper's Table II shows of sites: weight, site, most or least."""

PER_AREA = "w_m × D_e"
"""Melanin under an area of skin, which is all that a spectrum tells. [mm]"""


def choose_subjects(people: People) -> dict[str, int]:
    """Return the index of subjects A, B and C: by skin colour, never by a fit."""
    angles = people.typology_angle(ANGLE_SITE)
    chosen = at_quantiles(angles, [*QUANTILES.values()])
    return dict(zip(QUANTILES, chosen, strict=True))


def table_1() -> pd.DataFrame:
    """Return Table I: thickness of the layers, one row a site."""
    import pandas as pd

    depths = [layer_thickness(site) for site in SITES]
    epidermis, dermis = zip(*depths, strict=True)
    return pd.DataFrame({"site": SITES, "epidermis_mm": epidermis, "dermis_mm": dermis})


def table_2(
    people: People, subjects: Mapping[str, int], methods: Sequence[Method]
) -> pd.DataFrame:
    """Return Table II: one row a weight, after each method its means over everyone."""
    import pandas as pd

    rows: list[dict[str, Any]] = []
    for method in methods:
        mean = np.nanmean(method.values, axis=0)
        names = list(zip(method.parameters, method.units, strict=True))
        for subject, i in subjects.items():
            rows += [
                {
                    **_head(method, subject, people.names[i], site),
                    "parameter": name,
                    "unit": unit,
                    "value": method.parameter(name)[i, s],
                    "lower": method.interval[i, s, k, 0],
                    "upper": method.interval[i, s, k, 1],
                    "status": str(method.status[i, s]),
                }
                for s, site in enumerate(people.sites)
                for k, (name, unit) in enumerate(names)
            ]
        rows += [
            {
                **_head(method, "mean", _everyone(people), site),
                "parameter": name,
                "unit": unit,
                "value": mean[s, k],
            }
            for s, site in enumerate(people.sites)
            for k, (name, unit) in enumerate(names)
        ]
    return pd.DataFrame(rows)


def in_papers_layout(table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return Table II by method, sites down and weights across: "cotton, textbook"."""
    blocks = {}
    for (coefficients, model), own in table.groupby(
        ["coefficients", "model"], sort=False
    ):
        rows = own.groupby(["subject", "site"], sort=False)
        status = rows["status"].first().fillna("").str.replace("_", " ")
        wide = own.pivot_table(
            index=["subject", "site"], columns="parameter", values="value", sort=False
        )
        wide["status"] = status
        blocks[f"{model}, {coefficients}"] = wide.reset_index()
    return blocks


def table_3(
    people: People, subjects: Mapping[str, int], methods: Sequence[Method]
) -> pd.DataFrame:
    """Return Table III: one row a subject and method, the averages beneath."""
    import pandas as pd

    n = len(people.names)
    sets = {
        **{subject: (people.names[i], [i]) for subject, i in subjects.items()},
        "average": (", ".join(subjects), list(subjects.values())),
        "mean": (_everyone(people), list(range(n))),
    }
    rows = []
    for coefficients in dict.fromkeys(m.coefficients for m in methods):
        for subject, (person, which) in sets.items():
            for method in methods:
                if method.coefficients == coefficients:
                    errors = np.nanmean(method.sse_61[which], axis=0)
                    rows.append(
                        {
                            "coefficients": coefficients,
                            "subject": subject,
                            "person": person,
                            "model": method.model,
                            **dict(zip(people.sites, errors, strict=True)),
                        }
                    )
    return pd.DataFrame(rows)


def orders(subjects: Mapping[str, int], methods: Sequence[Method]) -> pd.DataFrame:
    """Return how far each weight's order between sites is the paper's, a row each."""
    import pandas as pd

    rows = []
    for method in methods:
        for name in [n for n in PAPER_WEIGHTS if n in method.parameters]:
            own, paper = method.parameter(name), PAPER_WEIGHTS[name]
            mean = np.nanmean(own, axis=0)
            share = order_agreement(own, paper)
            rows.append(
                {
                    "coefficients": method.coefficients,
                    "model": method.model,
                    "weight": name,
                    **{subject: float(share[i]) for subject, i in subjects.items()},
                    "means": float(order_agreement(mean, paper)),
                    "everyone": float(np.nanmean(share)),
                    "order of the means": " > ".join(
                        SITES[s] for s in np.argsort(-mean)
                    ),
                }
            )
    return pd.DataFrame(rows)


def claims(people: People, methods: Sequence[Method]) -> pd.DataFrame:
    """Return what paired tests make of the orders that the paper shows.

    Each claim is a site against each other one, within people; p is corrected (Holm)
    for all of a method's contrasts. Melanin is also compared as w_m × D_e.
    """
    import pandas as pd

    frames = [
        pd.DataFrame(_claims_of(people, method))
        for method in methods
        if {name for name, *_ in CLAIMS} <= set(method.parameters)
    ]
    return pd.concat(frames, ignore_index=True)


def _claims_of(people: People, method: Method) -> list[dict[str, Any]]:
    """Return one row a contrast of one method."""
    made = []
    for name, site, _ in _claims_and_per_area():
        own = dict(zip(people.sites, _quantity(people, method, name).T, strict=True))
        others = [other for other in people.sites if other != site]
        made.append([paired_contrast(own[site], own[other]) for other in others])
    corrected = iter(holm([contrast.p for each in made for contrast in each]))
    rows = []
    for claim, contrasts in zip(_claims_and_per_area(), made, strict=True):
        p = [float(next(corrected)) for _ in contrasts]
        rows += _claim_rows(people, method, claim, contrasts, p)
    return rows


def _claim_rows(
    people: People,
    method: Method,
    claim: tuple[str, str, str],
    contrasts: Sequence[Contrast],
    corrected: Sequence[float],
) -> list[dict[str, Any]]:
    """Return the rows of one claim: its site against each other one."""
    name, site, extreme = claim
    others = [other for other in people.sites if other != site]
    told = verdict(contrasts, corrected, extreme)
    return [
        {
            "coefficients": method.coefficients,
            "model": method.model,
            "quantity": name,
            "site": site,
            "claim": extreme,
            "against": other,
            "people": contrast.n,
            "difference": contrast.difference,
            "lower": contrast.interval[0],
            "upper": contrast.interval[1],
            "effect": contrast.effect,
            "share": contrast.share,
            "p": contrast.p,
            "p_corrected": p,
            "verdict": told,
        }
        for other, contrast, p in zip(others, contrasts, corrected, strict=True)
    ]


def _claims_and_per_area() -> list[tuple[str, str, str]]:
    """Return the claims, those of melanin also per area."""
    more = [(PER_AREA, site, way) for name, site, way in CLAIMS if name == "w_m"]
    return [*CLAIMS, *more]


def _quantity(people: People, method: Method, name: str) -> Array:
    """Return a weight, or melanin per area [mm], of everyone (people, sites)."""
    if name != PER_AREA:
        return method.parameter(name)
    depths = [layer_thickness(site)[0] for site in people.sites]
    return np.asarray(method.parameter("w_m") * np.array(depths))


def _head(method: Method, subject: str, person: str, site: str) -> dict[str, Any]:
    """Return what tells a row of Table II from others."""
    return {
        "coefficients": method.coefficients,
        "model": method.model,
        "subject": subject,
        "person": person,
        "site": site,
    }


def _everyone(people: People) -> str:
    """Return how many people there are, as a name for all of them."""
    return f"{len(people.names)} people"
