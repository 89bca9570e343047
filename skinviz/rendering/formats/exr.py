"""EXR: a channel of float32 for every band, and R, G, B for viewers.

Radiance is "emissive" in the words of the layout [1]_ and unpolarised, so its
channels are ``S0.<nm>nm`` with a decimal comma, and only ``S0``. R, G, B are linear
sRGB whatever the display.

References
----------
.. [1] Fichet, Pacanowski & Wilkie, An OpenEXR Layout for Spectral Images, JCGT
   10(3):1 (2021).
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz._threads import processors
from skinviz.errors import ArgumentError, DataError
from skinviz.rendering.formats.metadata import KEY, SOFTWARE, as_json, caption
from skinviz.rendering.formats.picture import (
    Advance,
    SpectralPicture,
    radiance_rows,
)
from skinviz.spectra.colorimetry import xyz_to_linear_srgb

LARGEST = 2**31
"""Bytes of all channels: OpenEXR takes them whole, so they are in memory at once."""

_COLOURS = ("R", "G", "B")
_LAYOUT = {
    "spectralLayoutVersion": "1.0",
    # The one unit of radiance that the layout has; ours are relative, and the caption
    # and the metadata say to what.
    "emissiveUnits": "W.m^-2.sr^-1",
    # x and y of sRGB's red, green, blue and white.
    "chromaticities": (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290),
}


def write(file: Path, picture: SpectralPicture, advance: Advance | None = None) -> None:
    """Write all bands without loss.

    Raises
    ------
    ArgumentError
        If the channels are larger than ``LARGEST``.
    """
    import OpenEXR

    names = [*_COLOURS, *map(channel_name, picture.wavelengths)]
    width, height = picture.size
    size = 4 * len(names) * width * height
    if size > LARGEST:
        raise ArgumentError(
            f"{file}: {len(names)} channels of {width} × {height} pixels are "
            f"{size / 2**30:.1f} GiB; an .exr is put together in memory, at most "
            f"{LARGEST / 2**30:g} GiB: write .hdr (ENVI), which is streamed, or a "
            "smaller picture"
        )
    header: dict[str, Any] = _LAYOUT | {
        "type": OpenEXR.scanlineimage,
        # Lossless, and on spectra smaller and faster than ZIP.
        "compression": OpenEXR.PIZ_COMPRESSION,
        "software": SOFTWARE,
        "comments": caption(picture.metadata),
        KEY: as_json(picture.metadata, file),
    }
    with whole_file(file) as partial:
        channels = dict(zip(names, _planes(picture, file, advance), strict=True))
        with partial.open("wb") as stream, _all_processors():
            OpenEXR.File(header, channels).write(stream)


def channel_name(wavelength: float) -> str:
    """Return what the layout calls a band, with every digit of its wavelength."""
    digits = np.format_float_positional(wavelength, min_digits=6)
    return f"S0.{digits.replace('.', ',')}nm"


def read_metadata(file: Path) -> str | None:
    """Return how a picture was made; None if the file does not say it."""
    import OpenEXR

    try:
        with file.open("rb") as stream:
            text = OpenEXR.File(stream, header_only=True).header().get(KEY)
    except Exception as error:  # whatever a broken file makes OpenEXR raise
        raise DataError(f"{file}: not a whole EXR file: {error}") from error
    return text if isinstance(text, str) else None


def _planes(
    picture: SpectralPicture, file: Path, advance: Advance | None
) -> NDArray[np.float32]:
    """Return colours and bands as planes, (channels, height, width)."""
    width, height = picture.size
    bands = len(picture.wavelengths)
    planes = np.zeros((len(_COLOURS) + bands, height, width), dtype=np.float32)
    xyz = picture.xyz
    top = 0
    for block in radiance_rows(picture, file, advance):
        rows = slice(top, top + len(block))
        colours = xyz_to_linear_srgb(xyz[rows])
        planes[: len(_COLOURS), rows] = np.moveaxis(colours, -1, 0)
        planes[len(_COLOURS) :, rows] = np.moveaxis(block, -1, 0)
        top = rows.stop
    return planes


@contextlib.contextmanager
def _all_processors() -> Iterator[None]:
    """Let OpenEXR, which has one setting for the process, use all processors."""
    import OpenEXR

    before = OpenEXR.global_thread_count()
    OpenEXR.set_global_thread_count(processors())
    try:
        yield
    finally:
        OpenEXR.set_global_thread_count(before)
