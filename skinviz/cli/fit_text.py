"""What ``skinviz fit`` prints: tables of fits, comparisons of models, summaries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.cli.text_table import Column, table
from skinviz.skin.fitted import Fitted
from skinviz.skin.report import derived, indistinct_counts
from skinviz.skin.skin_fit import ALIKE, REFUSED, STATUSES, WHY_REFUSED, SkinFit

Array = NDArray[np.float64]

MOST_ROWS = 40
"""Spectra beyond which a summary stands for the rows, unless they are asked for."""

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Of weights and errors, in a summary."""

_ERRORS = {"sse_61": "SSE61", "delta_e_2000": "dE00"}
_NAMES = {
    "blood_fraction": "blood",
    "oxygen_saturation": "SO2",
    "rmse": "RMSE",
    **_ERRORS,
}
_DECIMALS = {"SO2": 2, "dE00": 2, "BIC": 1}
_BLOOD = {"w_h", "w_dh"}
_MOST_PAIRS = 3  # said of what cannot be told apart
_SCALED = "SSE61: sum of squares scaled to 61 bands"


def fit_lines(run: Sequence[Fitted], *, every: bool) -> Iterator[str]:
    """Yield the lines that say what a run found; of every spectrum, if asked."""
    size = sum(item.fits[0].status.size for item in run)
    several = len(run[0].fits) > 1
    if size > MOST_ROWS and not every:
        yield from _summaries(run)
        yield f"{_SCALED}; --all prints every spectrum"
    elif several:
        for item in run:
            yield from _comparisons(item)
        yield f"*: the least BIC of a spectrum's models; {_SCALED}"
    else:
        labels = [label for item in run for label in item.labels]
        columns = _columns([item.fits[0] for item in run])
        yield from table("spectrum", labels, columns)
        yield f"second line: 95 % interval; {_SCALED}"
    for k, fit in enumerate(run[0].fits):
        if said := _indistinct([item.fits[k] for item in run]):
            yield (f"{fit.model.name}: " if several else "") + said
    if any((fit.status == REFUSED).any() for item in run for fit in item.fits):
        yield f"{REFUSED}: {WHY_REFUSED}"


def summary(run: Sequence[Fitted]) -> dict[str, Any]:
    """Return counts and quantiles of each model, as data for JSON."""
    least = _least_bic(run)
    found: dict[str, dict[str, Any]] = {}
    for k, fit in enumerate(run[0].fits):
        fits = [item.fits[k] for item in run]
        quantiles = {
            name: np.nanquantile(values, QUANTILES).tolist()
            for name, values in _quantities(fits).items()
            if np.isfinite(values).any()
        }
        found[fit.model.name] = {
            "spectra": sum(fit.status.size for fit in fits),
            "status": _counts(fits),
            "quantiles": {"of": list(QUANTILES), **quantiles},
        }
        if len(run[0].fits) > 1:
            found[fit.model.name]["least_bic"] = int((least == k).sum())
    return found


def _summaries(run: Sequence[Fitted]) -> Iterator[str]:
    """Yield counts and quantiles, model by model."""
    for name, facts in summary(run).items():
        counts = ", ".join(f"{n} {status}" for status, n in facts["status"].items())
        best = f"; least BIC in {facts['least_bic']}" if "least_bic" in facts else ""
        yield f"{name}, {facts['spectra']} spectra: {counts}{best}"
        known = {
            _NAMES.get(key, key): values
            for key, values in facts["quantiles"].items()
            if key != "of"
        }
        columns = [
            Column(f"{100 * share:g} %", [_number(v[i], n) for n, v in known.items()])
            for i, share in enumerate(QUANTILES)
        ]
        if known:
            yield from table("quantile", list(known), columns)
        yield ""


def _comparisons(item: Fitted) -> Iterator[str]:
    """Yield tables for each spectrum of a file, a row a model."""
    fits = item.fits
    names = [fit.model.name for fit in fits]
    numbers = [
        {key: values.ravel() for key, values in derived(fit).items()} for fit in fits
    ]
    best = _least(np.stack([own["bic"] for own in numbers]))
    shared, further = _parameters(fits)
    for i, label in enumerate(item.labels):
        columns = [
            Column(name, [_number(own[key][i], name) for own in numbers])
            for key, name in _ERRORS.items()
        ]
        bic = [
            _number(own["bic"][i], "BIC") + ("*" if best[i] == k else " ")
            for k, own in enumerate(numbers)
        ]
        status = [str(fit.status.ravel()[i]) for fit in fits]
        columns += [Column("BIC ", bic), Column("status", status)]
        yield label
        yield from table("model", names, columns + _values(fits, shared, i))
        having = [fit for fit in fits if set(further) & set(fit.parameters)]
        if having:
            own_names = [fit.model.name for fit in having]
            yield from table("", own_names, _values(having, further, i))
        yield ""


def _parameters(fits: Sequence[SkinFit]) -> tuple[list[str], list[str]]:
    """Return the parameters that all models share, and those that some have."""
    every = dict.fromkeys(name for fit in fits for name in fit.parameters)
    shared = [name for name in every if all(name in fit.parameters for fit in fits)]
    return shared, [name for name in every if name not in shared]


def _values(fits: Sequence[SkinFit], names: Sequence[str], i: int) -> list[Column]:
    """Return a column for each parameter of one spectrum, a row a model."""
    return [
        Column(name, [_number(_value(fit, name, i), name) for fit in fits])
        for name in names
    ]


def _columns(fits: Sequence[SkinFit]) -> list[Column]:
    """Return weights with intervals, errors and status, one row a spectrum."""
    numbers = _joined(fits)
    status = [str(s) for fit in fits for s in fit.status.ravel()]
    columns = []
    for k, name in enumerate(fits[0].parameters):
        values = np.concatenate([fit.values[..., k].ravel() for fit in fits])
        ends = np.concatenate([fit.interval[..., k, :].reshape(-1, 2) for fit in fits])
        columns.append(_with_interval(name, values, ends))
    share = numbers["oxygen_saturation"]
    if np.isfinite(share).any():
        low, high = (numbers[f"oxygen_saturation_{end}"] for end in ("lower", "upper"))
        columns.append(_with_interval("SO2", share, np.stack([low, high], axis=-1)))
    errors = [
        Column(name, [_number(value, name) for value in numbers[key]])
        for key, name in _ERRORS.items()
    ]
    return [*columns, *errors, Column("status", status)]


def _with_interval(name: str, values: Array, ends: Array) -> Column:
    """Return a column of values (n,) with their intervals (n, 2) below them."""
    below = [
        "" if np.isnan(low) else f"{_number(low, name)}..{_number(high, name)}"
        for low, high in ends
    ]
    return Column(name, [_number(value, name) for value in values], below)


def _indistinct(fits: Sequence[SkinFit]) -> str:
    """Return a line that says what cannot be told apart; empty if everything can."""
    size = sum(int((fit.status != REFUSED).sum()) for fit in fits)
    found = sorted(_pairs(fits).items(), key=lambda pair: -pair[1][0])
    said = []
    for key, (number, trades) in found[:_MOST_PAIRS]:
        share = f"in {number} of {size} spectra"
        if len(key) == 1:
            said.append(f"{key[0]} does not show at all {share}")
            continue
        do = ", quote their sum" if set(key) == _BLOOD and trades > 0 else ""
        said.append(f"{key[0]} and {key[1]} {share}{do}")
    if len(found) > _MOST_PAIRS:
        said.append(f"{len(found) - _MOST_PAIRS} more in fewer")
    told = f"cannot be told apart (correlation beyond {ALIKE:g}): "
    return told + "; ".join(said) if said else ""


def _pairs(fits: Sequence[SkinFit]) -> dict[tuple[str, ...], list[int]]:
    """Return how many spectra have each pair, and how many more trade than not."""
    counts: dict[tuple[str, ...], list[int]] = {}
    for fit in fits:
        for key, (number, traded) in indistinct_counts(fit).items():
            known = counts.setdefault(key, [0, 0])
            known[0] += number
            known[1] += number if traded else -number
    return counts


def _counts(fits: Sequence[SkinFit]) -> dict[str, int]:
    """Return how many spectra have each status, of those that occur."""
    counts = {s: sum(int((fit.status == s).sum()) for fit in fits) for s in STATUSES}
    return {status: n for status, n in counts.items() if n}


def _joined(fits: Sequence[SkinFit]) -> dict[str, Array]:
    """Return what follows from fits of several files, flat, one after the other."""
    numbers = [derived(fit) for fit in fits]
    return {
        name: np.concatenate([own[name].ravel() for own in numbers])
        for name in numbers[0]
    }


def _quantities(fits: Sequence[SkinFit]) -> dict[str, Array]:
    """Return what a summary tells of, flat, over all files."""
    numbers = _joined(fits)
    weights = {
        name: np.concatenate([fit.values[..., k].ravel() for fit in fits])
        for k, name in enumerate(fits[0].parameters)
    }
    return weights | {name: numbers[name] for name in _NAMES}


def _least_bic(run: Sequence[Fitted]) -> NDArray[np.int64]:
    """Return which model has the least BIC in each spectrum of a run."""
    models = range(len(run[0].fits))
    return _least(
        np.stack([_joined([item.fits[k] for item in run])["bic"] for k in models])
    )


def _least(bic: Array) -> NDArray[np.int64]:
    """Return the index of the least BIC (model, n), -1 where none is known."""
    known = np.where(np.isnan(bic), np.inf, bic)
    return np.where(np.isnan(bic).all(axis=0), -1, np.argmin(known, axis=0))


def _value(fit: SkinFit, name: str, i: int) -> float:
    """Return a parameter of one spectrum, NaN if the model does not have it."""
    if name not in fit.parameters:
        return np.nan
    own = fit.values[..., fit.parameters.index(name)]
    return float(own.ravel()[i])


def _number(value: float, name: str) -> str:
    """Return a number as text, a dash where it is not known."""
    if np.isnan(value):
        return "-"
    if abs(value) >= 1e4:
        return f"{value:.4g}"
    return f"{value:.{_DECIMALS.get(name, 4)}f}"
