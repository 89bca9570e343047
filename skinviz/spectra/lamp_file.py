"""Files of lamps, by the readers of spectra; their unit and scale do not matter."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file
from skinviz.errors import DataError
from skinviz.spectra.formats import LAMP_READERS
from skinviz.spectra.formats.raw import RawSpectra
from skinviz.spectra.plausible import Judged, require_wavelengths

Array = NDArray[np.float64]


def read_lamp(path: str | os.PathLike[str]) -> tuple[Path, Array, Array]:
    """Return the file, and wavelengths (n,) [nm] and power (n,) of its one spectrum.

    Raises
    ------
    DataError
        If the file is missing, broken, no lamp's or has not one spectrum.
    """
    file = existing_file(path, DataError)
    suffix = file.suffix.lower()
    if suffix not in LAMP_READERS:
        raise DataError(
            f"{file}: lamps are read from {', '.join(LAMP_READERS)}; "
            f"{suffix or 'no suffix'!r} is none of them"
        )
    raw = LAMP_READERS[suffix](file)
    _require_one(raw, file)
    if "specular" in raw.attributes:
        raise DataError(
            f"{file}: says how its surface reflection was measured, so it is a "
            "reflectance; a lamp is expected"
        )
    require_wavelengths(raw.wavelengths, Judged(str(file)))
    return file, raw.wavelengths, raw.values[0]


def _require_one(raw: RawSpectra, file: Path) -> None:
    """Refuse a file with none or several spectra, naming them."""
    count = len(raw.values)
    if count != 1:
        names = ", ".join(label[:20] for label in (raw.labels or [])[:5])
        more = " ..." if count > 5 else ""
        raise DataError(
            f"{file}: {count} spectra ({names}{more}), and a lamp is one; keep the one "
            "you mean in a file of its own"
        )
