"""Files of pictures: one module a format, and the table of their suffixes.

A format is added by its module, which has what :class:`Format` lists, and its line
here. What does not belong here: how colours and spectra are computed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from skinviz.rendering.formats import envi, exr, png, tiff
from skinviz.rendering.formats.picture import Advance, SpectralPicture


class Format(Protocol):
    """What a module of a format has."""

    def write(
        self, file: Path, picture: SpectralPicture, advance: Advance | None = None
    ) -> None:
        """Write a picture, whole or not at all, telling ``advance`` the rows."""

    def read_metadata(self, file: Path) -> str | None:
        """Return the JSON of an existing file, None if it has none."""


FORMATS: dict[str, Format] = {
    ".png": png,
    ".tif": tiff,
    ".tiff": tiff,
    ".exr": exr,
    ".hdr": envi,
}
"""Which module writes the files of a suffix."""
