"""A fit as plain data, for files that people and programs read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.skin.skin_fit import SkinFit

Array = NDArray[np.float64]

FIT_FORMAT = "skinviz fit 1"
"""Marks a JSON file as a fit, so that a scene can name it."""

_BLOCK = 2**16  # spectra treated at once, which bounds the memory


def fit_to_dict(fit: SkinFit, labels: Sequence[str]) -> dict[str, Any]:
    """Return a fit as data that JSON can hold; None stands for "not known".

    Parameters
    ----------
    fit : SkinFit
        Of one spectrum or a batch.
    labels : sequence of str
        A name for each spectrum.

    Returns
    -------
    data : dict
        The model and, for each spectrum, weights with 95 % intervals and errors.
        ``sse_61`` is the sum of squares scaled to 61 bands, as the paper's.
    """
    n = fit.status.size
    if len(labels) != n:
        raise ArgumentError(f"{len(labels)} labels for {n} spectra")
    known = {name: _plain(values) for name, values in derived(fit).items()}
    shares = [
        {"value": value, "lower": low, "upper": high}
        for value, low, high in zip(
            known["oxygen_saturation"],
            known["oxygen_saturation_lower"],
            known["oxygen_saturation_upper"],
            strict=True,
        )
    ]
    status, bands = fit.status.ravel().tolist(), fit.n_bands.ravel().tolist()
    weights = _weights(fit)
    records = [
        {
            "label": str(labels[i]),
            "status": status[i],
            "parameters": {name: own[i] for name, own in weights.items()},
            "oxygen_saturation": shares[i],
            "blood_fraction": known["blood_fraction"][i],
            "n_bands": bands[i],
            "sse": known["sse"][i],
            "sse_61": known["sse_61"][i],
            "rmse": known["rmse"][i],
            "delta_e_2000": known["delta_e_2000"][i],
        }
        for i in range(n)
    ]
    return {"format": FIT_FORMAT, **fit.model.description, "fits": records}


def derived(fit: SkinFit) -> dict[str, Array]:
    """Return what follows from a fit, each of the batch's shape.

    Returns
    -------
    derived : dict of str to ndarray
        ``oxygen_saturation`` with ``_lower`` and ``_upper``, ``blood_fraction``,
        ``sse``, ``sse_61``, ``rmse``, ``delta_e_2000`` and ``bic``; NaN where it is
        not known, as where the model has no blood of two kinds. [1]
    """
    parts = [_derived(part) for part in blocks(fit)]
    if len(parts) == 1:
        return parts[0]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def blocks(fit: SkinFit) -> Iterator[SkinFit]:
    """Yield the fit in parts along its first axis, small enough for temporaries."""
    n = len(fit.status) if fit.status.ndim else 0
    if fit.status.size <= _BLOCK:
        yield fit
        return
    step = max(1, _BLOCK * n // fit.status.size)
    for start in range(0, n, step):
        yield fit[start : start + step]


def indistinct_counts(fit: SkinFit) -> dict[tuple[str, ...], tuple[int, bool]]:
    """Return what the data cannot tell apart: in how many spectra, and how.

    Returns
    -------
    counts : dict of tuple of str to (int, bool)
        As the keys of ``SkinFit.indistinct``; true where a pair trades the one for
        the other, so that their sum is known better than each.
    """
    found: dict[tuple[str, ...], list[float]] = {}
    for part in blocks(fit):
        correlation = part.correlation
        for key, where in part.indistinct().items():
            i, j = part.parameters.index(key[0]), part.parameters.index(key[-1])
            count, signs = found.setdefault(key, [0, 0.0])
            found[key] = [
                count + int(where.sum()),
                signs + float(correlation[where, i, j].sum()),
            ]
    return {key: (int(count), signs < 0) for key, (count, signs) in found.items()}


def _derived(fit: SkinFit) -> dict[str, Array]:
    """Return what follows from a fit that is small enough for temporaries."""
    unknown = np.full(fit.status.shape, np.nan)
    blood = share = low = high = unknown
    if {"w_h", "w_dh"} <= set(fit.parameters):
        blood, share = fit.blood_fraction, fit.oxygen_saturation
        low, high = np.moveaxis(fit.oxygen_saturation_interval, -1, 0)
    numbers = {
        "oxygen_saturation": share,
        "oxygen_saturation_lower": low,
        "oxygen_saturation_upper": high,
        "blood_fraction": blood,
        "sse": fit.sse,
        "sse_61": fit.sse_61,
        "rmse": fit.rmse,
        "delta_e_2000": fit.delta_e,
        "bic": fit.bic,
    }
    return {name: np.asarray(values, np.float64) for name, values in numbers.items()}


def _weights(fit: SkinFit) -> dict[str, list[dict[str, float | None]]]:
    """Return each parameter's value and interval, one a spectrum."""
    p = len(fit.parameters)
    values, intervals = fit.values.reshape(-1, p), fit.interval.reshape(-1, p, 2)
    return {
        name: [
            {"value": value, "lower": low, "upper": high}
            for value, low, high in zip(
                _plain(values[:, k]),
                _plain(intervals[:, k, 0]),
                _plain(intervals[:, k, 1]),
                strict=True,
            )
        ]
        for k, name in enumerate(fit.parameters)
    }


def _plain(values: Array) -> list[float | None]:
    """Return numbers as floats, None for what is not finite."""
    flat = np.ravel(values)
    return np.where(np.isfinite(flat), flat, np.array(None)).tolist()
