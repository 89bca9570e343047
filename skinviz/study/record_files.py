"""Files that have a study's records: spectra, or logs of sessions at an instrument."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from skinviz.errors import DataError
from skinviz.instruments.skinlog import SUFFIX
from skinviz.spectra.files import read_spectra
from skinviz.spectra.formats import FORMATS

if TYPE_CHECKING:
    import xarray

SUFFIXES = (*FORMATS, SUFFIX)
"""Of files that can have records."""


def read_records(
    path: Path, *, scale: str | None, specular: str | float
) -> xarray.Dataset:
    """Return the spectra of a file of a study.

    Parameters
    ----------
    path : Path
        A file that :func:`skinviz.read_spectra` reads, or a ``.skinlog``, whose labels
        are its sites.
    scale, specular
        What the study says, as for :func:`skinviz.read_spectra`.

    Raises
    ------
    DataError, InstrumentError
        If the file cannot be read, or contradicts the study.
    """
    if path.suffix.lower() != SUFFIX:
        return read_spectra(path, scale=scale, specular=specular)
    from skinviz.instruments.derive import read_session

    spectra = read_session(path)
    if spectra.attrs["specular"] != specular:
        raise DataError(
            f"{path}: a session leaves the surface reflection out, and the study says "
            f'specular = {specular!r}; write "excluded", or keep logs in another study'
        )
    return spectra
