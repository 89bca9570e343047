"""A comparison as one page of Markdown that people read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

import numpy as np

from skinviz.study.comparing import MOST_LEVELS
from skinviz.study.comparison import Comparison, Contrast, Stratum
from skinviz.study.comparison_tables import facts
from skinviz.study.statistics import ALIKE, CONFOUNDED, TOO_FEW, Mean

_MOST_ROWS = 40  # levels of a table of means; means.csv has all
_MOST_GAPS = 10  # gaps of one kind that are listed; gaps.csv has all

_WHY = {
    TOO_FEW: "too few to tell",
    ALIKE: "no variance: all values alike",
    CONFOUNDED: "confounded: no origin has both",
}


def report(
    comparison: Comparison,
    figures: Mapping[str, str],
    notes: Sequence[str],
    version: str,
) -> str:
    """Return the report.

    Parameters
    ----------
    comparison : Comparison
        What is reported.
    figures : mapping of str to str
        Title and file of each picture, relative to the report.
    notes : sequence of str
        What else is to be said.
    version : str
        Of skinviz.
    """
    lines = [f"# {comparison.study.title}: by {comparison.by}", ""]
    lines += [*_head(comparison, version), "", *_gaps(comparison), *_notes(notes)]
    for title, file in figures.items():
        lines += [f"## {title}", "", f"![{title}]({file})", ""]
    for stratum in comparison.strata:
        lines += [f"## Means, {stratum}", "", *_means(comparison, stratum), ""]
    lines += [
        *_differences(comparison),
        "",
        "## How to read it",
        "",
        *_reading(comparison),
    ]
    return "\n".join([*lines, ""])


def attribution(comparison: Comparison) -> str:
    """Return where the data of a comparison come from and what allows their use."""
    attributes = comparison.study.spectra.attrs
    parts = [f"Spectra: {attributes['source']}"]
    if attributes.get("licence"):
        parts.append(str(attributes["licence"]))
    return ", ".join(parts) + "."


def places_of(width: float) -> int:
    """Return how many decimals the width of an interval bears, two of its digits."""
    return min(max(1 - int(np.floor(np.log10(width))), 0), 9) if width > 0 else 4


def _head(comparison: Comparison, version: str) -> Iterator[str]:
    """Yield what was compared."""
    told = facts(comparison.study)
    layers = "; ".join(
        f"{site} {epidermis:g} + {dermis:g}"
        for site, (epidermis, dermis) in told["layers_mm"].items()
    )
    rows = {
        "source": told["source"],
        "licence": told["licence"],
        "measured": ", ".join(
            filter(None, (f"specular {told['specular']}", told["geometry"]))
        ),
        "holds": f"{told['spectra']} spectra of {told['subjects']} subjects",
        "origins": ", ".join(told["origins"]),
        "model": f"{comparison.model}, coefficients {comparison.coefficients}",
        "layers": f"epidermis + dermis in mm: {layers}",
        "made with": f"skinviz {version}, seed {comparison.seed}",
    }
    yield "| | |"
    yield "|---|---|"
    for name, text in rows.items():
        if text:
            yield f"| {name} | {_escaped(text)} |"


def _gaps(comparison: Comparison) -> Iterator[str]:
    """Yield what is missing and why."""
    yield "## What is missing, and why"
    yield ""
    kinds = Counter((gap.what, gap.why) for gap in comparison.gaps)
    if not kinds:
        yield "Nothing."
        yield ""
        return
    yield "| what | how many | why | which |"
    yield "|---|---|---|---|"
    for (what, why), n in kinds.items():
        own = [g for g in comparison.gaps if (g.what, g.why) == (what, why)]
        named = [
            ", ".join(
                filter(
                    None,
                    (
                        g.subject,
                        g.site,
                        g.condition,
                        f"repeat {g.repeat}" if g.repeat else "",
                        g.file,
                    ),
                )
            )
            for g in own[:_MOST_GAPS]
        ]
        more = f" and {n - _MOST_GAPS} more, see gaps.csv" if n > _MOST_GAPS else ""
        yield f"| {what} | {n} | {_escaped(why)} | {_escaped('; '.join(named))}{more} |"
    yield ""


def _notes(notes: Sequence[str]) -> Iterator[str]:
    """Yield notes as a list."""
    for note in notes:
        yield f"- {note}"
    if notes:
        yield ""


def _means(comparison: Comparison, stratum: Stratum) -> Iterator[str]:
    """Yield a table of means with their intervals, a level a row."""
    names = [
        q.name if q.unit == "1" else f"{q.name} ({q.unit})"
        for q in comparison.quantities
    ]
    yield f"| {comparison.by} | n | {' | '.join(names)} |"
    yield "|---" * (len(names) + 2) + "|"
    cells = comparison.row(stratum)
    for cell in cells[:_MOST_ROWS]:
        values = [_mean(mean) for mean in cell.means]
        yield f"| {_escaped(cell.level)} | {len(cell.units)} | {' | '.join(values)} |"
    if len(cells) > _MOST_ROWS:
        yield ""
        yield f"{len(cells) - _MOST_ROWS} more are in means.csv."


def _differences(comparison: Comparison) -> Iterator[str]:
    """Yield tables of differences, stratum by stratum."""
    if not comparison.contrasts:
        yield "## Differences"
        yield ""
        yield (
            f"There are {len(comparison.levels)} levels, and pairs are compared of at "
            f"most {MOST_LEVELS}: choose with --level."
        )
        return
    for stratum in comparison.strata:
        own = [c for c in comparison.contrasts if c.stratum == stratum]
        if not own:
            continue
        yield f"## Differences, {stratum}"
        yield ""
        yield "| pair | quantity | second − first | effect | p | p (Holm) | test, n |"
        yield "|---|---|---|---|---|---|---|"
        for _, pair in groupby(own, key=lambda c: (c.first, c.second)):
            yield from _pair(list(pair))
        yield ""


def _pair(contrasts: Sequence[Contrast]) -> Iterator[str]:
    """Yield the rows of a pair of levels: one if nothing of it can be tested."""
    first = contrasts[0]
    whys = {c.difference.why for c in contrasts}
    if whys == {CONFOUNDED}:
        pair = _escaped(f"{first.first} → {first.second}")
        n = ", ".join(map(str, first.difference.n))
        yield f"| {pair} | all | – | {_WHY[CONFOUNDED]} | – | – | none, {n} |"
        return
    yield from map(_difference, contrasts)


def _difference(contrast: Contrast) -> str:
    """Return the row of one difference."""
    own = contrast.difference
    pair = f"{contrast.first} → {contrast.second}"
    apart = (
        "–" if own.difference is None else _interval(own.difference, own.low, own.high)
    )
    if own.p is None or own.effect is None or contrast.p_holm is None:
        told = f"{_WHY.get(own.why, own.why)} | – | –"
    else:
        told = (
            f"{own.effect_name} {own.effect:.2f} | {_p(own.p)} | {_p(contrast.p_holm)}"
        )
    n = f"{own.n[0]}" if own.n[0] == own.n[1] else f"{own.n[0]}, {own.n[1]}"
    return (
        f"| {_escaped(pair)} | {contrast.quantity.name} | {apart} | {told} | "
        f"{own.test}, {n} |"
    )


def _reading(comparison: Comparison) -> Iterator[str]:
    """Yield what the numbers mean."""
    unit = comparison.unit
    yield (
        f"- Means are over {unit}s"
        + (", each the mean of its repeats" if unit == "subject" else "")
        + "; in brackets the 95 % interval of Student's t."
    )
    yield (
        "- Cohen's d_z is the mean difference of pairs over the differences' own "
        "deviation; Hedges's g the difference over the pooled deviation, corrected for "
        "few. p (Holm) is corrected for all differences of this report."
    )
    yield (
        '- "t within origins" takes the laboratory as a factor: only laboratories that '
        "measured both levels count. Where there is none, the difference may as well "
        "be that of laboratories, and is not tested."
    )
    yield (
        "- Weights take the layers' thickness as given; between sites compare w_m·D_e "
        "(w_m_depth). L*, a*, b* and ITA are the measured colour's under D65."
    )
    yield (
        "- Intervals of ΔE00 and of swatches are what the covariance of the fit to the "
        f"mean spectrum allows; the spread between {unit}s is not in them. levels.csv "
        "has these fits, with intervals of their own."
    )


def _mean(mean: Mean) -> str:
    """Return a mean with its interval."""
    return "–" if mean.mean is None else _interval(mean.mean, mean.low, mean.high)


def _interval(value: float, low: float | None, high: float | None) -> str:
    """Return a number and its interval to the digits that the interval bears."""
    if low is None or high is None:
        return f"{value:.3g} [too few]"
    places = places_of(high - low)
    return f"{value:.{places}f} [{low:.{places}f}, {high:.{places}f}]"


def _p(p: float) -> str:
    """Return a p-value."""
    return "< 0.0001" if p < 1e-4 else f"{p:.2g}"


def _escaped(text: str) -> str:
    """Return text that does not break a table."""
    return text.replace("|", "\\|").replace("\n", " ")
