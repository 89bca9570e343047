"""Files of spectra: one module a format, and the table of their suffixes.

A format is added by its module, which has what :class:`Format` lists, and its
line here. What does not belong here: scale, attributes and the judgement of
values; :mod:`skinviz.spectra.files` does these for all formats alike.
"""

from __future__ import annotations

from skinviz.spectra.formats import cgats, delimited, envi, netcdf, spdx
from skinviz.spectra.formats.raw import Format

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
