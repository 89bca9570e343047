"""ENVI cubes of reflectance: a text header ``.hdr`` and a raw file beside it.

A bad band (0 in ``bbl``) and a value equal to ``data ignore value`` become NaN: the
grid of wavelengths stays, and a fit leaves such bands out.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.formats.envi_header import (
    PICTURE_FIELD,
    choice,
    count,
    header_text,
    numbers,
    read_header,
)
from skinviz.spectra.formats.envi_raw import blocks_of_lines, raw_file, write_pair
from skinviz.spectra.formats.raw import (
    CUBE,
    RawSpectra,
    in_nanometres,
    joined,
    notes_to_write,
    number,
    stated,
)

if TYPE_CHECKING:
    import xarray

KINDS, MISSING = (CUBE,), True

# ENVI's codes of data types, except the complex ones 6 and 9.
_TYPES = dict(
    zip(
        ("1", "2", "3", "4", "5", "12", "13", "14", "15"),
        ("u1", "i2", "i4", "f4", "f8", "u2", "u4", "i8", "u8"),
        strict=True,
    )
)
# Axes of line, sample and band in the stored order.
_AXES = {"bip": (0, 1, 2), "bil": (0, 2, 1), "bsq": (1, 2, 0)}
_KEYS = {
    "specular": "specular",
    "geometry": "geometry",
    "instrument": "sensor type",
    "date": "acquisition time",
    "comment": "description",
}
_FILE_TYPES = ("envi", "envi standard")


def read(file: Path) -> RawSpectra:
    """Return the cube; 8- and 16-bit integers and float32 become float32."""
    header = read_header(file)
    if PICTURE_FIELD in header:
        raise DataError(
            f"{file}: has the radiance of a picture that skinviz computed, which is no "
            "reflectance; divide it by that of white first"
        )
    cube = _stored(header, file)
    bands = cube.shape[-1]
    unit = header.get("wavelength units")
    if unit is None or "wavelength" not in header:
        raise DataError(
            f"{file}: says no 'wavelength' or no 'wavelength units'; add the list of "
            "bands and 'wavelength units = Nanometers' to the header"
        )
    wavelengths = np.array(numbers(header, "wavelength", bands, file))
    scale = header.get("reflectance scale factor")
    _require_no_gains(header, bands, file)
    return RawSpectra(
        values=_converted(cube, _bad_bands(header, bands, file), header, file),
        wavelengths=in_nanometres(wavelengths, unit, file),
        labels=None,
        written_as=None
        if scale is None
        else number(scale, f"{file}, reflectance scale factor"),
        attributes=stated(
            {key: joined(header.get(word, "")) for key, word in _KEYS.items()}
        ),
    )


def write(file: Path, spectra: xarray.Dataset) -> None:
    """Write float32, band-interleaved by pixel, 0–1; NaN marks missing values."""
    reflectance = spectra["reflectance"].values
    notes = notes_to_write(spectra, file)
    fields: dict[str, object] = {
        "reflectance scale factor": 1,
        "data ignore value": "nan",
        "wavelength units": "Nanometers",
        "wavelength": spectra["wavelength"].values.astype(np.float64).tolist(),
    } | {_KEYS[key]: text for key, text in notes.items()}
    text = header_text(reflectance.shape, "bip", fields, file)
    write_pair(file, ".bip", text, _as_float32(reflectance, file))


def _as_float32(values: NDArray[Any], file: Path) -> Iterator[NDArray[np.float32]]:
    """Yield blocks of lines of a cube, none of a value that overflows."""
    for block in blocks_of_lines(len(values), values[0].size * 4):
        with np.errstate(over="ignore"):
            part = values[block].astype(np.float32)
        if np.isinf(part).any():
            raise ArgumentError(f"{file}: a value is too large for float32")
        yield part


def _stored(header: dict[str, str], file: Path) -> NDArray[Any]:
    """Return the raw file, not yet in memory, with the axes line, sample, band."""
    kind = header.get("file type", "ENVI")
    if kind.lower() not in _FILE_TYPES:
        raise DataError(
            f"{file}: the file type is {kind[:40]!r}; cubes are ENVI Standard"
        )
    axes = _AXES[choice(header, "interleave", _AXES, file)]
    code = choice(header, "data type", _TYPES, file)
    order = {"0": "<", "1": ">"}[choice(header, "byte order", ("0", "1"), file)]
    dtype = np.dtype(order + _TYPES[code])
    shape = [count(header, name, file) for name in ("lines", "samples", "bands")]
    offset = count(header, "header offset", file) if "header offset" in header else 0
    raw = raw_file(file)
    expected = offset + int(np.prod([*map(int, shape)], dtype=object)) * dtype.itemsize
    size = raw.stat().st_size
    if 0 in shape or size != expected:
        what = " × ".join(map(str, shape))
        raise DataError(
            f"{file}: {what} lines, samples and bands of {dtype.itemsize} bytes after "
            f"{offset} need {expected} bytes, at least one; {raw.name} has {size}"
        )
    stored = [shape[axes.index(axis)] for axis in range(3)]
    try:
        cube = np.memmap(raw, dtype, "r", offset, tuple(stored))
    except (OSError, ValueError) as error:
        raise DataError(f"{raw}: cannot be read: {error}") from error
    return np.transpose(cube, axes)


def _converted(
    cube: NDArray[Any], bad: NDArray[np.bool_], header: dict[str, str], file: Path
) -> NDArray[Any]:
    """Return the cube as floats in memory, NaN where it is marked as missing."""
    ignored = None
    if "data ignore value" in header:
        ignored = number(header["data ignore value"], f"{file}, data ignore value")
    lines, samples, bands = cube.shape
    try:
        values = np.zeros(cube.shape, dtype=np.result_type(cube.dtype, np.float32))
    except MemoryError as error:
        raise DataError(f"{file}: the cube does not fit into the memory") from error
    # A signalling NaN or an ignore value beyond float32 would warn.
    with np.errstate(all="ignore"):
        if ignored is not None and cube.dtype.kind == "f":
            ignored = float(cube.dtype.type(ignored))
        for block in blocks_of_lines(lines, samples * bands * cube.dtype.itemsize):
            part = cube[block]
            values[block] = part
            if ignored is not None:
                values[block][part == ignored] = np.nan
    values[..., bad] = np.nan
    return values


def _bad_bands(header: dict[str, str], bands: int, file: Path) -> NDArray[np.bool_]:
    """Return which bands the header's list marks as bad."""
    if "bbl" not in header:
        return np.zeros(bands, dtype=bool)
    marks = np.array(numbers(header, "bbl", bands, file))
    if not np.isin(marks, (0, 1)).all():
        raise DataError(f"{file}: 'bbl' has other values than 0 (bad) and 1 (good)")
    return np.asarray(marks == 0)


def _require_no_gains(header: dict[str, str], bands: int, file: Path) -> None:
    """Refuse gains and offsets that are not applied yet: they make no reflectance."""
    for name, neutral in (("data gain values", 1.0), ("data offset values", 0.0)):
        if name in header and set(numbers(header, name, bands, file)) != {neutral}:
            raise DataError(
                f"{file}: '{name}' are not applied yet, so it is no reflectance; "
                "convert it first"
            )
