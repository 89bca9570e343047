"""netCDF-4, which holds everything that spectra carry."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from skinviz._files import whole_file
from skinviz.errors import ArgumentError, DataError, SkinvizError
from skinviz.spectra.formats.raw import (
    CUBE,
    LIST,
    SCALES,
    RawSpectra,
    in_nanometres,
)

if TYPE_CHECKING:
    import xarray

KINDS, MISSING = (LIST, CUBE), True

_UNITS = {"1": "fraction", "": "fraction", "%": "percent", "percent": "percent"}
# Deflate shrinks at most 1032 times: more is not in the file, only declared.
_LARGEST_RATIO, _ALWAYS = 1100, 2**26


def read(file: Path) -> RawSpectra:
    """Return the variable ``reflectance``; all else is handed on as it is."""
    found = _loaded(file)
    reflectance = found["reflectance"]
    dims = next((d for d in KINDS if {*d, "wavelength"} == set(reflectance.dims)), None)
    if dims is None:
        names = ", ".join(map(str, reflectance.dims)) or "none"
        raise DataError(
            f"{file}: reflectance has the dimensions {names[:60]}; expected record, "
            "wavelength or line, sample, wavelength"
        )
    if "wavelength" not in found.coords or found["wavelength"].dtype.kind not in "fiu":
        raise DataError(f"{file}: no coordinate wavelength of numbers")
    if reflectance.dtype.kind not in "fiu":
        raise DataError(f"{file}: reflectance is {reflectance.dtype}, not real numbers")
    values = reflectance.transpose(*dims, "wavelength").values
    wavelengths = found["wavelength"].values.astype(np.float64)
    unit = str(found["wavelength"].attrs.get("units", "nm"))
    return RawSpectra(
        values=np.ascontiguousarray(values, np.result_type(values, np.float32)),
        wavelengths=in_nanometres(wavelengths, unit, file),
        labels=_labels(found, file) if dims == LIST else None,
        written_as=_written_as(reflectance.attrs, file),
        attributes=dict(found.attrs),
        rest=found,
    )


def write(file: Path, spectra: xarray.Dataset) -> None:
    """Write the whole dataset; NaN stays NaN."""
    plain = spectra.drop_encoding()
    if "label" in plain.coords:
        labels = np.array([str(label) for label in plain["label"].values])
        plain = plain.assign_coords(label=("record", labels, plain["label"].attrs))
    with whole_file(file) as partial:
        try:
            plain.to_netcdf(partial, engine="h5netcdf")
        except (TypeError, ValueError, NotImplementedError, AttributeError) as error:
            raise ArgumentError(f"{file}: cannot be written: {error}") from error


def _loaded(file: Path) -> xarray.Dataset:
    """Return the file's content in memory, or say what it is instead."""
    import h5py
    import xarray

    _require_not_classic(file)
    try:
        # Asked here first: a file that cannot answer breaks h5netcdf's clean-up.
        with h5py.File(file, "r") as container:
            container.attrs.get("_nc3_strict")
        # Warnings are of encodings that a broken file declares.
        with (
            warnings.catch_warnings(action="ignore"),
            xarray.open_dataset(file, engine="h5netcdf") as opened,
        ):
            _require_spectra(opened, file)
            return opened.load()
    except SkinvizError:
        raise
    except Exception as error:  # a broken file raises anything from below
        what = " ".join(str(error).split())[:120]
        raise DataError(f"{file}: not a whole netCDF-4 file: {what}") from error


def _require_not_classic(file: Path) -> None:
    """Refuse the older netCDF, which is another format, by its first bytes."""
    with file.open("rb") as start:
        if start.read(3) == b"CDF":
            raise DataError(
                f"{file}: is of netCDF's classic form; netCDF-4 is read, so convert it "
                "(nccopy -k nc4 OLD NEW)"
            )


def _require_spectra(opened: xarray.Dataset, file: Path) -> None:
    """Refuse, before values are loaded, what has no spectra or cannot be so large."""
    if {"parameter", "fitted"} & set(opened.variables):
        raise DataError(
            f"{file}: holds a fit, whose reflectance is the model's and was not "
            "measured; give the file of spectra that was fitted"
        )
    if "reflectance" not in opened.data_vars:
        names = ", ".join(map(str, opened.data_vars))[:60] or "none"
        raise DataError(f"{file}: no variable reflectance; its variables are {names}")
    declared = sum(variable.nbytes for variable in opened.variables.values())
    size = file.stat().st_size
    if declared > _ALWAYS + _LARGEST_RATIO * size:
        raise DataError(
            f"{file}: declares {declared / 2**20:.0f} MiB of values and has "
            f"{size / 2**20:.1f} MiB; the file is cut off or broken"
        )


def _labels(found: xarray.Dataset, file: Path) -> list[str]:
    """Return the records' labels, or their numbers where they have none."""
    if "label" not in found.coords:
        records = found["reflectance"]["record"].values
        return [f"record {record}" for record in records]
    if found["label"].dims != LIST:
        raise DataError(f"{file}: the coordinate label is not along record")
    return [str(label) for label in found["label"].values]


def _written_as(attributes: dict[str, object], file: Path) -> float | None:
    """Return what 1 is written as by the variable's units, if it has them."""
    if "units" not in attributes:
        return None
    unit = str(attributes["units"]).strip().lower()
    if unit not in _UNITS:
        raise DataError(
            f"{file}: reflectance has the units {unit[:20]!r}; expected '1' or '%'"
        )
    return SCALES[_UNITS[unit]]
