"""Files of spectra: one module a format, and the table of their suffixes.

A format is added by its module, which has what :class:`Format` lists, and its
line here. What does not belong here: scale, attributes and the judgement of
values; :mod:`skinviz.spectra.files` does these for all formats alike.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from skinviz.spectra.formats import cgats, delimited, envi, netcdf, spdx
from skinviz.spectra.formats.raw import Format, RawSpectra

FORMATS: dict[str, Format] = {
    ".csv": delimited,
    ".tsv": delimited,
    ".spdx": spdx,
    ".cgats": cgats,
    ".txt": cgats,
    ".nc": netcdf,
    ".hdr": envi,
}
"""Which module reads and writes the files of a suffix."""

LAMP_READERS: dict[str, Callable[[Path], RawSpectra]] = {
    ".csv": delimited.read,
    ".tsv": delimited.read,
    ".spdx": spdx.read_lamp,
    ".cgats": cgats.read_lamp,
    ".txt": cgats.read_lamp,
    ".sp": cgats.read_lamp,
}
"""Which function reads the light of a lamp from the files of a suffix."""
