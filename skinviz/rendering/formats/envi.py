"""ENVI cubes of radiance, written row by row: a header and a raw file beside it.

How the picture was made is a field of the header, JSON that is percent-encoded: it
has no brace, comma or space, which header files give a meaning.
"""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote, unquote

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.formats.metadata import as_json, caption
from skinviz.rendering.formats.picture import (
    Advance,
    SpectralPicture,
    radiance_rows,
)
from skinviz.spectra.formats.envi_header import (
    PICTURE_FIELD,
    header_text,
    read_header,
)
from skinviz.spectra.formats.envi_raw import write_pair

_SHOWN_AS = (640.0, 550.0, 460.0)  # what viewers show as red, green and blue [nm]
_LINE = 80  # characters
_PLAIN = '":[]/'  # what of JSON needs no encoding


def write(file: Path, picture: SpectralPicture, advance: Advance | None = None) -> None:
    """Write float32, band-interleaved by pixel; no more than some rows are held."""
    width, height = picture.size
    encoded = quote(as_json(picture.metadata, file), safe=_PLAIN)
    lines = [encoded[i : i + _LINE] for i in range(0, len(encoded), _LINE)]
    fields: dict[str, object] = {
        "description": caption(picture.metadata).translate(str.maketrans("{}", "()")),
        "wavelength units": "Nanometers",
        "wavelength": picture.wavelengths.tolist(),
        "default bands": _shown_bands(picture.wavelengths),
        PICTURE_FIELD: [" ".join(lines)],
    }
    shape = (height, width, len(picture.wavelengths))
    text = header_text(shape, "bip", fields, file)
    write_pair(file, ".bip", text, radiance_rows(picture, file, advance))


def read_metadata(file: Path) -> str | None:
    """Return how a picture was made; None if the header does not say it."""
    encoded = read_header(file).get(PICTURE_FIELD)
    return None if encoded is None else unquote("".join(encoded.split()))


def _shown_bands(wavelengths: NDArray[np.float64]) -> list[int]:
    """Return the bands, from 1, that are nearest to those of a colour picture."""
    return [int(np.abs(wavelengths - nm).argmin()) + 1 for nm in _SHOWN_AS]
