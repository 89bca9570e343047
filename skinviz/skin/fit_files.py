"""Files that hold fits: CSV, netCDF, and ENVI maps of a cube.

What does not belong here: JSON, which is :mod:`skinviz.skin.report`'s data as it is.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz.errors import ArgumentError
from skinviz.skin.fitted import Fitted, as_dataset, as_rows
from skinviz.skin.report import derived
from skinviz.skin.skin_fit import STATUSES, SkinFit
from skinviz.spectra.formats import envi_raw
from skinviz.spectra.formats.envi_header import header_text

FIT_SUFFIXES = (".json", ".csv", ".nc", ".hdr")
"""What a fit can be written as; .hdr holds the maps of one cube."""

MAPS_RAW = ".bsq"
"""How the raw file beside an .hdr of maps ends."""

_MAPPED = ("oxygen_saturation", "blood_fraction", "rmse", "delta_e_2000")


def write_fit_rows(path: str | os.PathLike[str], run: Sequence[Fitted]) -> Path:
    """Write fits as CSV, a row for each spectrum and model, every digit kept."""
    file = Path(path)
    table = as_rows(run)
    with whole_file(file) as partial:
        table.to_csv(partial, index=False, lineterminator="\n", encoding="utf-8")
    return file


def write_fit_dataset(
    path: str | os.PathLike[str], run: Sequence[Fitted], facts: dict[str, str]
) -> Path:
    """Write fits as netCDF-4, as :func:`skinviz.skin.fitted.as_dataset` has them."""
    file = Path(path)
    table = as_dataset(run, facts)
    # As characters, which shrink to nothing: one string object each would not.
    words = {"dtype": "S1", "zlib": True, "complevel": 1}
    with whole_file(file) as partial:
        table.to_netcdf(partial, engine="h5netcdf", encoding={"status": words})
    return file


def write_fit_maps(path: str | os.PathLike[str], item: Fitted) -> Path:
    """Write a cube's fits as an ENVI file of float32 maps, NaN where refused.

    Parameters
    ----------
    path : str or path-like
        The header, ``.hdr``; the raw file beside it ends in ``.bsq``.
    item : Fitted
        A cube.

    Raises
    ------
    ArgumentError
        If it is no cube, or a file lies beside it that would be taken for its raw
        file or would be lost.
    """
    file = Path(path)
    if not item.is_cube:
        raise ArgumentError(
            f"{file}: an ENVI header holds the maps of a cube, and {item.file} is a "
            "list of spectra; write .csv, .json or .nc"
        )
    bands = [band for fit in item.fits for band in _bands(fit, len(item.fits) > 1)]
    lines, samples = item.fits[0].status.shape
    text = header_text(
        (lines, samples, len(bands)),
        "bsq",
        {
            "description": _description(item),
            "data ignore value": "nan",
            "band names": [name for name, _ in bands],
        },
        file,
    )
    envi_raw.write_pair(file, MAPS_RAW, text, (values for _, values in bands))
    return file


def require_free(file: Path) -> None:
    """Refuse a header beside whose name some other raw file lies."""
    envi_raw.require_free(file, MAPS_RAW)


def _bands(fit: SkinFit, several: bool) -> list[tuple[str, NDArray[np.float64]]]:
    """Return the maps (line, sample) of one model with their names."""
    numbers = derived(fit)
    maps = {name: fit.values[..., k] for k, name in enumerate(fit.parameters)}
    maps |= {name: numbers[name] for name in _MAPPED}
    codes = [fit.status == status for status in STATUSES]
    maps["status"] = np.argmax(codes, axis=0).astype(np.float64)
    start = f"{fit.model.name} " if several else ""
    return [(start + name, values) for name, values in maps.items()]


def _description(item: Fitted) -> str:
    """Return what the maps are, on one line without braces."""
    model = item.fits[0].model
    codes = ", ".join(f"{i} {status}" for i, status in enumerate(STATUSES))
    told = (
        f"pigments fitted by skinviz to {Path(item.file).name}; specular "
        f"{model.specular}, coefficients {model.coefficients.name}; status: {codes}"
    )
    return " ".join(told.translate(str.maketrans("{}", "()")).split())
