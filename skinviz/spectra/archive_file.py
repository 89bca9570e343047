"""Archives of measured skin as netCDF files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file, whole_file
from skinviz._validate import one_of
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.archive_data import ATTRIBUTES, LABELS, archive_dataset
from skinviz.spectra.measurement import as_specular

if TYPE_CHECKING:
    import xarray

SUFFIX = ".nc"
"""Of an archive's file: netCDF 4."""

_STORED = ("reflectance", "record", "wavelength", *LABELS)
_MOST_BYTES = 1_000_000_000  # a compressed file can claim any size


def write_archive(path: str | os.PathLike[str], archive: xarray.Dataset) -> Path:
    """Write an archive as compressed netCDF that :func:`load_archive` reads.

    Parameters
    ----------
    path : str or path-like
        The ``.nc`` file to write.
    archive : xarray.Dataset
        As :func:`load_archive` returns.

    Returns
    -------
    path : Path
        The file written.

    Raises
    ------
    ArgumentError
        If the suffix is another, or the dataset is no archive.
    """
    file = Path(path)
    one_of(file.suffix.lower(), (SUFFIX,), "suffix of an archive")
    missing = _missing(archive)
    if missing:
        raise ArgumentError(f"an archive needs {', '.join(missing)}")
    others = [name for name in archive.variables if name not in _STORED]
    packed = {"zlib": True, "complevel": 5, "shuffle": True}
    with whole_file(file) as partial:
        archive.drop_vars(others).to_netcdf(
            partial,
            engine="h5netcdf",
            encoding={
                "reflectance": packed,
                # As characters: text of varying length is not compressed.
                **{label: {**packed, "dtype": "S1"} for label in LABELS},
            },
        )
    return file


def read_archive(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Return the archive in a netCDF file, its faults flagged anew.

    Parameters
    ----------
    path : str or path-like
        A ``.nc`` file that :func:`write_archive` wrote.

    Raises
    ------
    DataError
        If the file is missing, broken or no archive.
    """
    file = existing_file(path, DataError)
    import xarray

    try:
        with xarray.open_dataset(file, engine="h5netcdf") as stored:
            missing = _missing(stored)
            if missing:
                raise DataError(
                    f"{file}: no archive, {', '.join(missing)} missing; write it with "
                    "skinviz archive import"
                )
            if stored.nbytes > _MOST_BYTES:
                raise DataError(
                    f"{file}: claims to hold {stored.nbytes / 1e9:.3g} GB; an archive "
                    f"has at most {_MOST_BYTES / 1e9:g}"
                )
            stored.load()
    except DataError:
        raise
    except Exception as error:  # whatever a broken file makes HDF5 raise
        raise DataError(f"{file}: no netCDF file that can be read: {error}") from error
    return _sound(stored, file)


def _missing(dataset: xarray.Dataset) -> list[str]:
    """Return what a dataset lacks or has in another shape than an archive."""
    wanted = {
        "reflectance": ("record", "wavelength"),
        "record": ("record",),
        "wavelength": ("wavelength",),
        **dict.fromkeys(LABELS, ("record",)),
    }
    lacking = [
        f"{name} ({', '.join(dims)})"
        for name, dims in wanted.items()
        if name not in dataset.variables or dataset[name].dims != dims
    ]
    attributes = [key for key in ATTRIBUTES if key not in dataset.attrs]
    return lacking + [f"the attribute {key}" for key in attributes]


def _sound(stored: xarray.Dataset, file: Path) -> xarray.Dataset:
    """Return a loaded file's archive, or say which part is not as it must be."""
    labels = {label: stored[label].to_numpy().astype(object) for label in LABELS}
    for label, texts in labels.items():
        if not all(isinstance(text, str) for text in texts):
            raise DataError(f"{file}: {label} must be text")
    wavelengths = _numbers(stored, "wavelength", file)
    reflectance = _numbers(stored, "reflectance", file)
    if not reflectance.size:
        raise DataError(f"{file}: the archive holds no spectra")
    if not (np.diff(wavelengths) > 0).all() or not np.isfinite(wavelengths).all():
        raise DataError(f"{file}: the wavelengths do not ascend")
    if np.isinf(reflectance).any():
        raise DataError(f"{file}: a reflectance is infinite")
    try:
        as_specular(stored.attrs["specular"])
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error
    records = stored["record"].to_numpy()
    return archive_dataset(
        records, labels, wavelengths, reflectance, dict(stored.attrs)
    )


def _numbers(stored: xarray.Dataset, name: str, file: Path) -> NDArray[np.float64]:
    """Return a variable as float64 or say that it holds no numbers."""
    values: NDArray[Any] = stored[name].to_numpy()
    if not np.issubdtype(values.dtype, np.number):
        raise DataError(f"{file}: {name} must be numbers; it is {values.dtype}")
    return values.astype(np.float64)
