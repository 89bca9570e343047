"""A comparison as tables and plain data: rows that CSV and JSON can hold."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from skinviz.spectra.archive_selection import set_means
from skinviz.study.comparison import Cell, Comparison, Stratum
from skinviz.study.quantities import measured_lab
from skinviz.study.study import Gap, Study

FORMAT = "skinviz comparison 1"
"""Marks a JSON file as a comparison."""

Row = dict[str, Any]

_PAIR = ("first", "second")
_GAP = ("what", "subject", "site", "condition", "repeat", "file", "why")


def mean_rows(comparison: Comparison) -> Iterator[Row]:
    """Yield a row for each level, stratum and quantity: its mean and 95 % interval."""
    for cell in comparison.cells:
        for quantity, mean in zip(comparison.quantities, cell.means, strict=True):
            yield {
                **_where(cell.stratum),
                comparison.by: cell.level,
                "quantity": quantity.name,
                "unit": quantity.unit,
                "n": mean.n,
                "of": comparison.unit,
                "mean": mean.mean,
                "lower": mean.low,
                "upper": mean.high,
                "standard_deviation": mean.deviation,
            }


def difference_rows(comparison: Comparison) -> Iterator[Row]:
    """Yield a row for each pair of levels, stratum and quantity."""
    for contrast in comparison.contrasts:
        found = contrast.difference
        yield {
            **_where(contrast.stratum),
            "first": contrast.first,
            "second": contrast.second,
            "quantity": contrast.quantity.name,
            "unit": contrast.quantity.unit,
            "n_first": found.n[0],
            "n_second": found.n[1],
            "of": comparison.unit,
            "second_less_first": found.difference,
            "lower": found.low,
            "upper": found.high,
            "effect": found.effect,
            "effect_name": found.effect_name,
            "test": found.test,
            "p": found.p,
            "p_holm": contrast.p_holm,
            "why_not": found.why,
        }


def colour_rows(comparison: Comparison) -> Iterator[Row]:
    """Yield a row for each pair of levels and stratum: ΔE00 of their mean spectra."""
    for own in comparison.colours:
        yield {
            **_where(own.stratum),
            "first": own.first,
            "second": own.second,
            "delta_e_measured": _finite(own.delta_e),
            "delta_e_fitted": _finite(own.fitted),
            "fitted_lower": _finite(own.low),
            "fitted_upper": _finite(own.high),
        }


def level_rows(comparison: Comparison) -> Iterator[Row]:
    """Yield a row for each level and stratum: its mean spectrum's fit and colour."""
    for cell in comparison.cells:
        fit = cell.fit
        row = {
            **_where(cell.stratum),
            comparison.by: cell.level,
            "n": len(cell.units),
            "of": comparison.unit,
            "status": str(fit.status),
            "rmse": _finite(float(fit.rmse)),
        }
        for i, name in enumerate(fit.parameters):
            row[name] = _finite(float(fit.values[i]))
            row[f"{name}_lower"] = _finite(float(fit.interval[i, 0]))
            row[f"{name}_upper"] = _finite(float(fit.interval[i, 1]))
        for kind, lab in (("measured", measured_lab(fit)), ("fitted", cell.colour.lab)):
            for axis, value in zip("Lab", lab, strict=True):
                row[f"{axis}_{kind}"] = _finite(float(value))
        row["delta_e_error"] = _finite(float(cell.colour.delta_e))
        yield row


def spectrum_rows(comparison: Comparison) -> Iterator[Row]:
    """Yield a row for each level, stratum and band: mean and spread of reflectance."""
    bands = comparison.study.spectra["wavelength"].values
    for cell in comparison.cells:
        known, spread = _spread(cell)
        for k, nm in enumerate(bands):
            if known[k]:
                yield {
                    **_where(cell.stratum),
                    comparison.by: cell.level,
                    "wavelength_nm": float(nm),
                    "n": int(known[k]),
                    "of": comparison.unit,
                    "mean": float(cell.mean_spectrum[k]),
                    "standard_deviation": _finite(float(spread[k])),
                }


def gap_rows(gaps: Sequence[Gap]) -> Iterator[Row]:
    """Yield a row for each gap."""
    for gap in gaps:
        yield {**asdict(gap), "repeat": gap.repeat or None}


def csv_tables(comparison: Comparison) -> dict[str, str]:
    """Return the tables of a comparison as CSV, by the names of files."""
    tables: dict[str, tuple[Iterator[Row], tuple[str, ...]]] = {
        "means.csv": (mean_rows(comparison), ()),
        "differences.csv": (difference_rows(comparison), _PAIR),
        "colours.csv": (colour_rows(comparison), _PAIR),
        "levels.csv": (level_rows(comparison), ()),
        "spectra.csv": (spectrum_rows(comparison), ()),
        "gaps.csv": (gap_rows(comparison.gaps), _GAP),
    }
    return {name: _as_csv(*rows) for name, rows in tables.items()}


def as_data(comparison: Comparison) -> Row:
    """Return what was compared and found as data that JSON can hold."""
    return {
        "format": FORMAT,
        "study": facts(comparison.study),
        "by": comparison.by,
        "levels": list(comparison.levels),
        "model": comparison.model,
        "coefficients": comparison.coefficients,
        "seed": comparison.seed,
        "quantities": [asdict(quantity) for quantity in comparison.quantities],
        "means": list(mean_rows(comparison)),
        "differences": list(difference_rows(comparison)),
        "colours": list(colour_rows(comparison)),
        "level_fits": list(level_rows(comparison)),
        "gaps": list(gap_rows(comparison.gaps)),
    }


def facts(study: Study) -> Row:
    """Return what a study is and holds."""
    spectra = study.spectra
    said = {key: str(spectra.attrs[key]) for key in ("source", "licence", "geometry")}
    return {
        "title": study.title,
        **said,
        "specular": study.specular,
        "spectra": int(spectra.sizes["record"]),
        "subjects": len(study.levels("subject")),
        "origins": sorted({str(o) for o in spectra["origin"].values if o}),
        "layers_mm": {
            site: list(study.layers[site])
            for site in study.levels("site")
            if site in study.layers
        },
    }


def _where(stratum: Stratum) -> Row:
    """Return the columns that say in which stratum a row is."""
    parts = {"site": stratum.site, "condition": stratum.condition}
    return {key: value for key, value in parts.items() if value}


def _spread(cell: Cell) -> tuple[Any, Any]:
    """Return how many units have each band, and their standard deviation there."""
    known = np.isfinite(cell.spectra).sum(axis=0)
    square = (cell.spectra - cell.mean_spectrum) ** 2
    one = np.zeros(len(square), dtype=np.int64)
    mean = set_means(square, one, 1)[0]
    freedom = np.maximum(known - 1, 1)
    return known, np.where(known > 1, np.sqrt(mean * known / freedom), np.nan)


def _finite(value: float) -> float | None:
    """Return a number, None for NaN and infinity."""
    return value if np.isfinite(value) else None


def _cell(value: Any) -> Any:
    """Return what a CSV cell says: of a float what means something."""
    return f"{value:.10g}" if isinstance(value, float) else value


def _as_csv(rows: Iterator[Row], names: tuple[str, ...]) -> str:
    """Return rows as CSV; ``names`` is the header where there is no row."""
    listed = list(rows)
    text = io.StringIO()
    header = list(listed[0]) if listed else list(names)
    writer = csv.DictWriter(text, header, lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: _cell(v) for key, v in row.items()} for row in listed)
    return text.getvalue()
