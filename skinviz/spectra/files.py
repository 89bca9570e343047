"""Files of measured spectra and reflectance cubes: the two public doors.

What is the same for all formats is here; :mod:`skinviz.spectra.formats` has them.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file
from skinviz._validate import one_of
from skinviz.errors import ArgumentError, DataError, SkinvizError
from skinviz.spectra.formats import FORMATS
from skinviz.spectra.formats.envi_raw import RAW_SUFFIXES
from skinviz.spectra.formats.raw import CUBE, LIST, SCALES, Format, RawSpectra
from skinviz.spectra.measurement import as_specular
from skinviz.spectra.plausible import (
    Judged,
    require_cube,
    require_list,
    require_wavelengths,
)

if TYPE_CHECKING:
    import xarray


def read_spectra(
    path: str | os.PathLike[str],
    *,
    scale: str | None = None,
    specular: str | float | None = None,
) -> xarray.Dataset:
    """Read measured reflectance spectra, or a cube of them, from a file.

    Parameters
    ----------
    path : str or path-like
        ``.csv`` or ``.tsv`` (wavelengths down or across), ``.spdx`` (IES TM-27-14),
        ``.cgats`` or ``.txt`` (CGATS.17), ``.nc`` (netCDF-4), or ``.hdr`` (an ENVI
        cube, its raw file beside it).
    scale : {"fraction", "percent"}, optional
        Whether the file has 0–1 or 0–100, if the file does not say it; a
        contradiction is refused. If neither says it: 0–1, except that CGATS must
        be told. Never guessed.
    specular : {"excluded", "included"} or float, optional
        How the surface reflection was measured, if the file does not say it; a
        contradiction is refused.

    Returns
    -------
    spectra : xarray.Dataset
        ``reflectance`` [1]: of a list (record, wavelength) with the coordinate
        ``label``, of a cube (line, sample, wavelength). NaN where the file marks a
        value as missing (netCDF and ENVI can). ``wavelength`` is in nm. Attributes:
        ``source``, and where known ``specular``, ``geometry``, ``instrument``,
        ``date`` and ``comment``. netCDF gives back all that it holds.

    Raises
    ------
    DataError
        If the file is missing, empty, of another layout, cut off or no reflectance;
        if a list has a value in 400–700 nm that is not finite, negative or above 1.5;
        if most of a cube is above 1.5; or if wavelengths do not ascend. The message
        names the line, spectrum or field.
    """
    file = existing_file(path, DataError)
    form = _format_of(file, DataError)
    asked = None if scale is None else SCALES[one_of(scale, SCALES, "scale")]
    raw = form.read(file)
    full = _full_scale(raw, asked, file)
    by = Judged(str(file), full, raw.written_as is not None, form.MISSING)
    if raw.values.size == 0:
        raise DataError(f"{file}: no spectra in it")
    require_wavelengths(raw.wavelengths, by)
    if raw.labels is None:
        require_cube(raw.values, raw.wavelengths, by)
    else:
        require_list(raw.values, raw.wavelengths, raw.labels, by)
    if full != 1:
        np.divide(raw.values, full, out=raw.values)
    attributes = {"source": str(file)} | raw.attributes
    attributes |= _specular(specular, raw.attributes.get("specular"), file)
    return _dataset(raw, attributes)


def write_spectra(path: str | os.PathLike[str], spectra: xarray.Dataset) -> Path:
    """Write reflectance spectra in the format that the suffix names, as 0–1.

    Parameters
    ----------
    path : str or path-like
        The file to write; suffixes as for :func:`read_spectra`. An ENVI cube is
        written as float32 to ``.hdr`` and ``.bip``; the others keep every digit.
    spectra : xarray.Dataset
        As :func:`read_spectra` returns.

    Returns
    -------
    path : Path
        The file written.

    Raises
    ------
    ArgumentError
        If the suffix is unknown, or the spectra are such that the format cannot
        hold them or :func:`read_spectra` would refuse them. Nothing is written.
    """
    file = Path(path)
    form = _format_of(file, ArgumentError)
    dims = _dims(spectra, file)
    if dims not in form.KINDS:
        what, better = (
            ("a list of spectra", ".csv or .nc")
            if dims == LIST
            else ("a cube", ".hdr or .nc")
        )
        raise ArgumentError(f"{file}: {file.suffix} cannot hold {what}; write {better}")
    values = _values(spectra, dims, file)
    if not form.MISSING and not np.isfinite(values).all():
        raise ArgumentError(
            f"{file}: spectra with missing bands cannot be written as {file.suffix}; "
            "drop the bands or write .nc"
        )
    wavelengths = spectra["wavelength"].values.astype(np.float64)
    by = Judged(str(file), missing=form.MISSING, error=ArgumentError)
    require_wavelengths(wavelengths, by)
    if dims == CUBE:
        require_cube(values, wavelengths, by)
    else:
        require_list(values, wavelengths, _names(len(values)), by)
    attributes = spectra["reflectance"].attrs | {"units": "1"}
    form.write(
        file, spectra.assign(reflectance=((*dims, "wavelength"), values, attributes))
    )
    return file


def _format_of(file: Path, error: type[SkinvizError]) -> Format:
    """Return the format of a suffix, or list the known ones."""
    suffix = file.suffix.lower()
    if suffix in FORMATS:
        return FORMATS[suffix]
    known = ", ".join(FORMATS)
    if suffix in RAW_SUFFIXES:
        raise error(
            f"{file}: a raw cube is known by its ENVI header beside it; give "
            f"{file.with_suffix('.hdr').name}, and write the header if there is none"
        )
    raise error(
        f"{file}: spectra are read and written as {known}; "
        f"{suffix or 'no suffix'!r} is none of them"
    )


def _full_scale(raw: RawSpectra, asked: float | None, file: Path) -> float:
    """Return what reflectance 1 is written as, as the file and the caller say."""
    told = raw.written_as
    if told is not None and not (np.isfinite(told) and told > 0):
        raise DataError(
            f"{file}: says that reflectance 1 is written as {told:g}; expected a "
            "number above 0"
        )
    if told is not None and asked is not None and told != asked:
        raise DataError(
            f"{file} says that reflectance 1 is written as {told:g}, and a scale on "
            f"which it is {asked:g} was given; correct the one that is wrong"
        )
    for full in (told, asked, raw.unless_said):
        if full is not None:
            return full
    raise DataError(
        f"{file}: does not say whether it has 0-1 or 0-100, and both are usual in such "
        "files; say --scale fraction or --scale percent"
    )


def _specular(given: Any, noted: Any, file: Path) -> dict[str, str | float]:
    """Return how the surface was measured, as the file and the caller say."""
    told = [_as_specular(how, file) for how in (given, noted) if how is not None]
    if len(set(told)) > 1:
        raise DataError(
            f"{file} says that its surface reflection is {told[1]}, and {told[0]} was "
            "given; correct the one that is wrong"
        )
    return {"specular": told[0]} if told else {}


def _as_specular(value: Any, file: Path) -> str | float:
    """Return how the surface was measured, or say in which file it is misspelt."""
    try:
        return as_specular(value if np.ndim(value) == 0 else str(value))
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error


def _dataset(raw: RawSpectra, attributes: dict[str, Any]) -> xarray.Dataset:
    """Return what was read as a labelled table."""
    import xarray

    rest = xarray.Dataset() if raw.rest is None else raw.rest
    kept = {name: rest[name].attrs for name in rest.variables}
    coordinates: dict[str, Any] = {
        "wavelength": (
            "wavelength",
            raw.wavelengths,
            kept.get("wavelength", {}) | {"units": "nm"},
        )
    }
    if raw.labels is not None:
        labels = np.array(raw.labels, dtype=np.str_)
        coordinates["label"] = ("record", labels, kept.get("label", {}))
        if "record" not in rest.coords:
            coordinates["record"] = np.arange(len(labels))
    dims = CUBE if raw.labels is None else LIST
    units = kept.get("reflectance", {}) | {"units": "1"}
    found = rest.assign_coords(coordinates).assign(
        reflectance=((*dims, "wavelength"), raw.values, units)
    )
    found.attrs = attributes
    return found


def _dims(spectra: xarray.Dataset, file: Path) -> tuple[str, ...]:
    """Return the dimensions before the wavelength, or say what is expected."""
    found = getattr(spectra, "data_vars", {})
    if "reflectance" in found and "wavelength" in spectra.coords:
        for dims in (LIST, CUBE):
            if {*dims, "wavelength"} == set(spectra["reflectance"].dims) and (
                dims == CUBE or "label" in spectra.coords
            ):
                return dims
    raise ArgumentError(
        f"{file}: spectra need reflectance (record, wavelength) and the coordinates "
        "wavelength and label, or reflectance (line, sample, wavelength)"
    )


def _values(spectra: xarray.Dataset, dims: tuple[str, ...], file: Path) -> NDArray[Any]:
    """Return the reflectance with the wavelength last, as float32 or float64."""
    reflectance = spectra["reflectance"].transpose(*dims, "wavelength")
    unit = str(reflectance.attrs.get("units", "1"))
    if unit not in ("1", "") or reflectance.dtype.kind not in "fiu":
        raise ArgumentError(
            f"{file}: reflectance is {reflectance.dtype} in {unit!r}; expected real "
            "numbers in '1', that is 0 to 1"
        )
    if reflectance.size == 0:
        raise ArgumentError(f"{file}: there are no spectra to write")
    values = reflectance.values
    return values.astype(np.result_type(values, np.float32), copy=False)


def _names(count: int) -> list[str]:
    """Return names for messages: a label may not be text before it is written."""
    return [f"number {i + 1}" for i in range(count)]
