"""Files of pictures: the two public doors.

What is the same for all formats is here; :mod:`skinviz.rendering.formats` has them.
"""

from __future__ import annotations

import json
import os
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from skinviz._files import existing_file
from skinviz.errors import ArgumentError, DataError, SkinvizError
from skinviz.rendering.formats import FORMATS, Format
from skinviz.rendering.formats.picture import Advance, SpectralPicture
from skinviz.spectra.formats.envi_raw import RAW_SUFFIXES


def write_picture(
    path: str | os.PathLike[str],
    picture: SpectralPicture,
    advance: Advance | None = None,
) -> Path:
    """Write a picture in the format that the suffix names, whole or not at all.

    Parameters
    ----------
    path : str or path-like
        ``.png`` (8-bit colour), ``.tif`` or ``.tiff`` (16-bit colour), ``.exr`` (a
        float32 channel for each band, linear colour beside them) or ``.hdr`` (an
        ENVI cube of float32; the raw file beside it ends in ``.bip``). All of them
        say how the picture was made.
    picture : SpectralPicture
        What to write, a rendering for example.
    advance : callable, optional
        Told how many more rows are done.

    Returns
    -------
    path : Path
        The file written.

    Raises
    ------
    ArgumentError
        If the suffix is unknown, or the picture is one that the format cannot hold.
    SkinvizError
        If the disk is full or the folder may not be written to. What was there
        before is still there.
    """
    file = Path(path)
    _format_of(file, ArgumentError).write(file, picture, advance)
    return file


def read_picture_metadata(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return how a picture was made, from a file of :func:`write_picture`.

    Parameters
    ----------
    path : str or path-like
        The file; of an ENVI cube the header.

    Returns
    -------
    metadata : dict
        What the picture's ``metadata`` had: the scene, units, versions.

    Raises
    ------
    DataError
        If the file is missing, broken, of another format, or does not say it.
    """
    file = existing_file(path, DataError)
    text = _format_of(file, DataError).read_metadata(file)
    try:
        metadata = json.loads(text or "null")
    except (ValueError, RecursionError):
        metadata = None
    if not isinstance(metadata, dict):
        raise DataError(
            f"{file}: does not say how it was made; only files that skinviz wrote do, "
            "and some programs that change pictures take it out"
        )
    return metadata


def _format_of(file: Path, error: type[SkinvizError]) -> Format:
    """Return the format of a suffix, or list the known ones, nearest first."""
    suffix = file.suffix.lower()
    if suffix in FORMATS:
        return FORMATS[suffix]
    if suffix in RAW_SUFFIXES:
        raise error(
            f"{file}: an ENVI cube is known by the header beside its raw file; give "
            f"{file.with_suffix('.hdr').name}"
        )
    near = get_close_matches(suffix, FORMATS, n=1)
    raise error(
        f"{file}: pictures are {', '.join(FORMATS)}; {suffix or 'no suffix'!r} is none "
        f"of them{f'; did you mean {near[0]!r}?' if near else ''}"
    )
