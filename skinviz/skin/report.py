"""A fit as plain data, for files that people and programs read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinviz.errors import ArgumentError
from skinviz.skin.skin_fit import SkinFit

FIT_FORMAT = "skinviz fit 1"
"""Marks a JSON file as a fit, so that a scene can name it."""


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
    if len(labels) != fit.status.size:
        raise ArgumentError(f"{len(labels)} labels for {fit.status.size} spectra")
    table = fit.to_xarray()
    saturation, blood = fit.oxygen_saturation.ravel(), fit.blood_fraction.ravel()
    scaled = fit.sse_61.ravel()
    low, high = fit.oxygen_saturation_interval.reshape(-1, 2).T
    records = []
    for i, label in enumerate(labels):
        row = table.isel(record=i)
        weights = {
            name: {
                "value": _plain(row.value.values[k]),
                "lower": _plain(row.interval.values[k, 0]),
                "upper": _plain(row.interval.values[k, 1]),
            }
            for k, name in enumerate(fit.parameters)
        }
        records.append(
            {
                "label": str(label),
                "status": str(row.status.item()),
                "parameters": weights,
                "oxygen_saturation": {
                    "value": _plain(saturation[i]),
                    "lower": _plain(low[i]),
                    "upper": _plain(high[i]),
                },
                "blood_fraction": _plain(blood[i]),
                "n_bands": int(row.n_bands),
                "sse": _plain(row.sse),
                "sse_61": _plain(scaled[i]),
                "rmse": _plain(row.rmse),
                "delta_e_2000": _plain(row.delta_e),
            }
        )
    return {"format": FIT_FORMAT, **fit.model.description, "fits": records}


def _plain(value: Any) -> float | None:
    """Return a number as float, None for NaN."""
    number = float(value)
    return number if np.isfinite(number) else None
