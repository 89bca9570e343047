"""The raw file beside an ENVI header: which one it is, and its writing."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_files
from skinviz.errors import ArgumentError, DataError

RAW_SUFFIXES = (".bip", ".bil", ".bsq", ".img", ".dat", ".raw", ".bin")
"""How the raw file beside a header may end; it may also have no suffix."""

_BLOCK = 2**22  # bytes converted at once, which bounds the memory beside the cube


def raw_file(file: Path) -> Path:
    """Return the one raw file that belongs to a header."""
    found = _raw_files(file)
    if len(found) == 1:
        return found[0]
    if found:
        names = ", ".join(sorted(path.name for path in found))
        raise DataError(f"{file}: {names} may all be its raw file; keep one beside it")
    raise DataError(
        f"{file}: no raw file beside it; expected {file.stem} alone or with one of "
        f"{', '.join(RAW_SUFFIXES)}"
    )


def require_free(file: Path, suffix: str) -> None:
    """Refuse a header beside which a file lies that is not its own raw file."""
    own = file.with_suffix(suffix) if file.exists() else None
    for other in _raw_files(file):
        if other != own:
            raise ArgumentError(
                f"{file}: {other.name} lies beside it and would be lost or taken for "
                "its raw file; choose another name"
            )


def blocks_of_lines(lines: int, bytes_a_line: int) -> list[slice]:
    """Return slices of lines that hold a few megabytes each."""
    step = max(1, _BLOCK // max(bytes_a_line, 1))
    return [slice(i, i + step) for i in range(0, lines, step)]


def write_pair(
    file: Path, suffix: str, text: str, blocks: Iterable[NDArray[Any]]
) -> None:
    """Write a header and its raw file, both whole or neither.

    Parameters
    ----------
    file : Path
        The header.
    suffix : str
        How the raw file ends.
    text : str
        What the header says.
    blocks : iterable of ndarray
        What the raw file has, in order, in any shapes. Only one is held at a time.

    Raises
    ------
    ArgumentError
        As :func:`require_free`.
    """
    require_free(file, suffix)
    raw = file.with_suffix(suffix)
    # The raw file takes its name first: no header without it.
    with whole_files(raw, file) as (body, head):
        head.write_text(text, encoding="utf-8")
        with body.open("wb") as stream:
            for block in blocks:
                stream.write(np.ascontiguousarray(block, dtype="<f4").data)


def _raw_files(file: Path) -> list[Path]:
    """Return the files that may be a header's raw file."""
    if not file.parent.is_dir():
        return []
    return [
        path
        for path in file.parent.iterdir()
        if (
            path.name == file.stem
            or (path.stem == file.stem and path.suffix.lower() in RAW_SUFFIXES)
        )
        and path.is_file()
    ]
