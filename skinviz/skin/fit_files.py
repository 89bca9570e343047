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
from skinviz.spectra.formats.envi import RAW_SUFFIXES

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
    raw = file.with_suffix(MAPS_RAW)
    require_free(file)
    bands = [band for fit in item.fits for band in _bands(fit, len(item.fits) > 1)]
    lines, samples = item.fits[0].status.shape
    text = _header([name for name, _ in bands], lines, samples, item)
    # The inner file takes its name first: no header without its raw file.
    with whole_file(file) as head, whole_file(raw) as body:
        head.write_text(text, encoding="utf-8")
        with body.open("wb") as stream:
            for _, values in bands:
                values.astype("<f4").tofile(stream)
    return file


def require_free(file: Path) -> None:
    """Refuse a header beside whose name some other raw file lies."""
    own = file.with_suffix(MAPS_RAW)
    stem = file.with_suffix("")
    others = [stem, *(file.with_suffix(suffix) for suffix in RAW_SUFFIXES)]
    if file.exists():
        others.remove(own)
    for other in others:
        if other.is_file():
            raise ArgumentError(
                f"{file}: {other.name} lies beside it and would be lost or taken for "
                "its raw file; choose another name"
            )


def _bands(fit: SkinFit, several: bool) -> list[tuple[str, NDArray[np.float64]]]:
    """Return the maps (line, sample) of one model with their names."""
    numbers = derived(fit)
    maps = {name: fit.values[..., k] for k, name in enumerate(fit.parameters)}
    maps |= {name: numbers[name] for name in _MAPPED}
    codes = [fit.status == status for status in STATUSES]
    maps["status"] = np.argmax(codes, axis=0).astype(np.float64)
    start = f"{fit.model.name} " if several else ""
    return [(start + name, values) for name, values in maps.items()]


def _header(names: list[str], lines: int, samples: int, item: Fitted) -> str:
    """Return the text of the header."""
    model = item.fits[0].model
    codes = ", ".join(f"{i} {status}" for i, status in enumerate(STATUSES))
    told = (
        f"pigments fitted by skinviz to {Path(item.file).name}; specular "
        f"{model.specular}, coefficients {model.coefficients.name}; status: {codes}"
    )
    plain = " ".join(told.translate(str.maketrans("{}", "()")).split())
    header = {
        "description": f"{{{plain}}}",
        "samples": samples,
        "lines": lines,
        "bands": len(names),
        "header offset": 0,
        "file type": "ENVI Standard",
        "data type": 4,
        "interleave": "bsq",
        "byte order": 0,
        "data ignore value": "nan",
        "band names": f"{{{', '.join(names)}}}",
    }
    return "ENVI\n" + "".join(f"{key} = {value}\n" for key, value in header.items())
