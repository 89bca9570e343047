"""What ``skinviz compare`` writes and says."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from skinviz.cli.output import say

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from skinviz.study.comparison import Comparison
    from skinviz.study.statistics import Mean

TITLES = {
    "hands": "Hands",
    "colours": "Colours",
    "weights": "Weights",
    "spectra": "Spectra",
}
"""What the report calls each figure."""

_DOTS = 200  # per inch of a PNG


def write_comparison(
    folder: Path,
    found: Comparison,
    figures: dict[str, Figure],
    notes: tuple[str, ...],
) -> list[Path]:
    """Write tables, figures and the report into a folder: all of them or none."""
    import json

    from skinviz import __version__
    from skinviz._files import whole_files
    from skinviz.study.comparison_report import report
    from skinviz.study.comparison_tables import as_data, csv_tables
    from skinviz.view.figures import save_figure

    pictures = {TITLES[name]: f"{name}.png" for name in TITLES if name in figures}
    texts = {
        "report.md": report(found, pictures, notes, __version__),
        **csv_tables(found),
        "comparison.json": json.dumps(
            {**as_data(found), "notes": list(notes)}, indent=2, allow_nan=False
        )
        + "\n",
    }
    drawn = {
        f"{name}.{suffix}": figure
        for name, figure in figures.items()
        for suffix in ("png", "svg")
    }
    files = [folder / name for name in (*texts, *drawn)]
    with whole_files(*files) as partials:
        for partial, text in zip(partials, texts.values(), strict=False):
            partial.write_text(text, "utf-8")
        for partial, figure in zip(partials[len(texts) :], drawn.values(), strict=True):
            save_figure(figure, partial, dots=_DOTS)
    return files


def say_comparison(found: Comparison, notes: tuple[str, ...]) -> None:
    """Say what was compared, the weights, and how much differs and is missing."""
    from skinviz.cli.text_table import Column, table

    say(f"{found.study.title}: {found.study.spectra.sizes['record']} spectra")
    say(f"means over {found.unit}s ± half of their 95 % intervals")
    n_weights = len(found.cells[0].fit.parameters)
    for stratum in found.strata:
        cells = found.row(stratum)[:40]
        columns = [Column("n", [str(len(cell.units)) for cell in cells])]
        columns += [
            Column(quantity.name, [_mean(cell.means[k]) for cell in cells])
            for k, quantity in enumerate(found.quantities[:n_weights])
        ]
        for line in table(str(stratum), [cell.level for cell in cells], columns):
            say(line)
    tested = [c.p_holm for c in found.contrasts if c.p_holm is not None]
    sure = sum(p < 0.05 for p in tested)
    say(
        f"{sure} of {len(tested)} differences tested have p < 0.05 after Holm's "
        f"correction; {len(found.contrasts) - len(tested)} cannot be tested"
    )
    if found.gaps:
        say(f"gaps: {len(found.gaps)}, the first {found.gaps[0]}; gaps.csv has all")
    for note in notes:
        say(f"note: {note}")


def _mean(mean: Mean) -> str:
    """Return a mean and half of its interval."""
    from skinviz.study.comparison_report import places_of

    if mean.mean is None:
        return "-"
    if mean.low is None or mean.high is None:
        return f"{mean.mean:.3g} (too few)"
    places = places_of(mean.high - mean.low)
    return f"{mean.mean:.{places}f} ± {(mean.high - mean.low) / 2:.{places}f}"
