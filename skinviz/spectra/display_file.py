"""Displays in files: TOML with measurements, or an ICC profile."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

from skinviz._files import existing_file
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.display import Display, measured_display, read_icc

PROFILES = (".icc", ".icm")
"""How files of ICC profiles end."""

_AT_MOST = 2**22  # bytes
_KEYS = {"name", "primaries", "curves", "black"}


def read_display(path: str | os.PathLike[str]) -> Display:
    """Read a display from a file of measurements or an ICC profile.

    Parameters
    ----------
    path : str or path-like
        ``.icc`` or ``.icm``, or ``.toml`` with ``primaries`` (three XYZ), ``curves``
        and, if wanted, ``black`` and ``name``, as :func:`measured_display` takes
        them.

    Returns
    -------
    display : Display
        What the file describes.

    Raises
    ------
    DataError
        If the file is missing, broken or describes no display; the message names the
        key.
    """
    file = existing_file(path, DataError)
    suffix = file.suffix.lower()
    if suffix in PROFILES:
        return read_icc(file)
    if suffix != ".toml":
        raise DataError(
            f"{file}: displays are read from .toml and {', '.join(PROFILES)}; "
            f"{suffix or 'no suffix'!r} is none of them"
        )
    table = _table(file)
    try:
        return measured_display(
            table["primaries"],
            table["curves"],
            black=table.get("black"),
            name=str(table.get("name", file.stem)),
        )
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error


def _table(file: Path) -> dict[str, Any]:
    """Return the file's keys, refusing unknown and missing ones."""
    if file.stat().st_size > _AT_MOST:
        raise DataError(f"{file}: more than {_AT_MOST // 2**20} MiB are no display")
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DataError(f"{file}: not a TOML file: {error}") from error
    unknown = sorted(content.keys() - _KEYS)
    if unknown:
        raise DataError(
            f"{file}: unknown key {unknown[0]!r}; known are {', '.join(sorted(_KEYS))}"
        )
    for key in ("primaries", "curves"):
        if key not in content:
            raise DataError(f"{file}: {key} is missing")
    return content
