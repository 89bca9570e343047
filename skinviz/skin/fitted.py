"""Fits of whole files by one model or several, as tables in memory.

What does not belong here: writing them, which :mod:`skinviz.skin.fit_files` does.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.report import blocks, derived, fit_to_dict
from skinviz.skin.skin_fit import SkinFit

if TYPE_CHECKING:
    import pandas as pd
    import xarray

FITS_FORMAT = "skinviz fits of several models 1"
"""Marks a JSON file with a fit for each of several models."""

GRID = ("line", "sample")
_CURVES = ("fitted", "reflectance", "diffuse")
_MOST_WITH_CURVES = 200_000  # spectra: beyond it the curves outweigh all else
_SIDES = ("_lower", "_upper")


@dataclass(frozen=True, eq=False)
class Fitted:
    """The spectra of one file and what each model made of them.

    Attributes
    ----------
    file : str
        Where the spectra are from.
    prefix : str
        Stands before the labels where there are several files.
    spectra : xarray.Dataset
        As ``read_spectra`` returns them.
    fits : tuple of SkinFit
        One a model.
    """

    file: str
    prefix: str
    spectra: xarray.Dataset
    fits: tuple[SkinFit, ...]

    @property
    def is_cube(self) -> bool:
        """Whether the spectra are a cube (line, sample), not a list."""
        return "sample" in self.spectra.sizes

    @property
    def labels(self) -> list[str]:
        """A name for each spectrum, in the order of the flattened batch."""
        if not self.is_cube:
            return [
                f"{self.prefix}{label}" for label in self.spectra["label"].to_numpy()
            ]
        lines, samples = self.fits[0].status.shape
        return [
            f"{self.prefix}line {line} sample {sample}"
            for line in range(lines)
            for sample in range(samples)
        ]

    @property
    def measured(self) -> NDArray[Any]:
        """The reflectance at the bands that were fitted (..., n). [1]"""
        dims = GRID if self.is_cube else ("record",)
        chosen = self.spectra["reflectance"].sel(wavelength=self.fits[0].wavelengths)
        return np.asarray(chosen.transpose(*dims, "wavelength").to_numpy())


def as_data(run: Sequence[Fitted]) -> dict[str, Any]:
    """Return a run as data for JSON: of one model as ``fit_to_dict`` does.

    Of several models, ``models`` has one such fit for each name, whose records have
    ``bic`` besides; the least BIC is the best.
    """
    fits = []
    for k in range(len(run[0].fits)):
        parts = [fit_to_dict(item.fits[k], item.labels) for item in run]
        records = [record for part in parts for record in part["fits"]]
        fits.append({**parts[0], "fits": records})
    if len(fits) == 1:
        return fits[0]
    for k, fit in enumerate(fits):
        bic = np.concatenate([derived(item.fits[k])["bic"].ravel() for item in run])
        for record, value in zip(fit["fits"], bic.tolist(), strict=True):
            record["bic"] = value if np.isfinite(value) else None
    return {"format": FITS_FORMAT, "models": {fit["model"]: fit for fit in fits}}


def as_rows(run: Sequence[Fitted]) -> pd.DataFrame:
    """Return a run as a tidy table: a row for each spectrum and model."""
    import pandas as pd

    tables = [
        pd.DataFrame(_columns(item, fit, several=(len(run) > 1, len(item.fits) > 1)))
        for k in range(len(run[0].fits))
        for item in run
        for fit in [item.fits[k]]
    ]
    table = pd.concat(tables, ignore_index=True)
    for axis in GRID:  # whole numbers also where the lists of the run have none
        if axis in table:
            table[axis] = table[axis].astype("Int64")
    return table


def as_dataset(run: Sequence[Fitted], facts: dict[str, str]) -> xarray.Dataset:
    """Return a run as a labelled table with units, dims record or line and sample.

    Parameters
    ----------
    run : sequence of Fitted
        Lists, or one cube.
    facts : dict of str to str
        Attributes, such as where the spectra are from.

    Returns
    -------
    table : xarray.Dataset
        That of ``SkinFit.to_xarray``, with what was measured and what follows. Of
        several models it has the dimension ``model``; of files of different bands,
        NaN at the others' bands. Of more than 200,000 spectra the model's curves are
        left out, which the attribute ``curves`` says.
    """
    import xarray

    size = sum(item.fits[0].status.size for item in run)
    curves = size <= _MOST_WITH_CURVES
    models = [
        _joined([_labelled(item, item.fits[k], curves=curves) for item in run])
        for k in range(len(run[0].fits))
    ]
    fits = run[0].fits
    table = models[0]
    if len(models) > 1:
        axes: Any = dict.fromkeys(("parameter", "other_parameter"), _parameters(fits))
        names = xarray.DataArray([fit.model.name for fit in fits], dims="model")
        table = xarray.concat(
            [model.reindex(axes) for model in models],
            names.rename("model"),
            data_vars="all",
            coords="minimal",
            compat="override",
            join="outer",
        )
        # What was measured is the same for every model.
        table["measured"] = models[0]["measured"]
    table = table.assign_coords(_meanings(fits))
    for name, variable in table.data_vars.items():
        if name != "status":
            variable.attrs["units"] = "1"
    table["wavelength"].attrs["units"] = "nm"
    table["value"].attrs["units"] = "of each parameter: the coordinate unit"
    described = [fit.model.description for fit in fits]
    kept = "all" if curves else f"left out of more than {_MOST_WITH_CURVES} spectra"
    table.attrs = {
        **facts,
        "model": ", ".join(fit.model.name for fit in fits),
        "specular": str(fits[0].model.specular),
        "coefficients": fits[0].model.coefficients.name,
        "description": json.dumps(described[0] if len(fits) == 1 else described),
        "curves": kept,
    }
    return table


def _columns(item: Fitted, fit: SkinFit, several: tuple[bool, bool]) -> dict[str, Any]:
    """Return one column a number, a row a spectrum."""
    files, models = several
    columns: dict[str, Any] = {"label": item.labels}
    if files:
        columns["file"] = item.file
    if item.is_cube:
        lines, samples = np.indices(fit.status.shape)
        columns |= {"line": lines.ravel(), "sample": samples.ravel()}
    if models:
        columns["model"] = fit.model.name
    columns["status"] = fit.status.ravel()
    for k, name in enumerate(fit.parameters):
        columns[name] = fit.values[..., k].ravel()  # noqa: PD011 - no table's
        for side, end in enumerate(_SIDES):
            columns[name + end] = fit.interval[..., k, side].ravel()
    numbers = derived(fit)
    shown = [name for name in numbers if name.startswith(("oxygen", "blood"))]
    columns |= {name: numbers[name].ravel() for name in shown}
    columns["n_bands"] = fit.n_bands.ravel()
    rest = [name for name in numbers if name not in shown]
    columns |= {name: numbers[name].ravel() for name in rest}
    return columns | {"chi_square": fit.chi_square.ravel()}


def _labelled(item: Fitted, fit: SkinFit, *, curves: bool) -> xarray.Dataset:
    """Return one file's fit by one model as a labelled table."""
    import xarray

    parts = []
    for part in blocks(fit):
        table = part.to_xarray()
        parts.append(table if curves else table.drop_vars(_CURVES))
    table = _joined(parts)
    numbers = derived(fit)
    for name in ("sse_61", "bic", "blood_fraction", "oxygen_saturation"):
        table[name] = ("record", numbers[name].ravel())
    ends = [numbers[f"oxygen_saturation{end}"].ravel() for end in _SIDES]
    table["oxygen_saturation_interval"] = (("record", "side"), np.stack(ends, -1))
    if curves:
        measured = item.measured.reshape(-1, fit.wavelengths.size)
        table["measured"] = (("record", "wavelength"), measured)
    if not item.is_cube:
        return table.assign_coords(label=("record", np.array(item.labels, np.str_)))
    grid = {
        str(name): (
            (*GRID, *variable.dims[1:]),
            variable.to_numpy().reshape(*fit.status.shape, *variable.shape[1:]),
        )
        for name, variable in table.data_vars.items()
    }
    return xarray.Dataset(grid, coords=table.coords, attrs=table.attrs)


def _joined(tables: Sequence[xarray.Dataset]) -> xarray.Dataset:
    """Return tables of records one after the other, NaN at bands of others."""
    import xarray

    if len(tables) == 1:
        return tables[0]
    return xarray.concat(
        tables,
        "record",
        data_vars="all",
        coords="different",
        compat="equals",
        join="outer",
    )


def _parameters(fits: Sequence[SkinFit]) -> list[str]:
    """Return the names of all models' parameters, in order, each once."""
    return list(dict.fromkeys(name for fit in fits for name in fit.parameters))


def _meanings(fits: Sequence[SkinFit]) -> dict[str, Any]:
    """Return unit and meaning along the parameters."""
    known = {p.name: p for fit in fits for p in fit.model.parameters}
    names = _parameters(fits)
    return {
        "unit": ("parameter", [known[name].unit for name in names]),
        "meaning": ("parameter", [known[name].meaning for name in names]),
    }
