"""The PLY container: parsed strictly, so that a broken file never half loads."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from skinviz.errors import MeshError

UNIT_COMMENT = "unit "
"""Comment by which our PLY files state their unit of length: ``unit mm``."""


def read_ply(path: Path) -> Any:  # plyfile has no types
    """Return the parsed file, or say where it is broken."""
    import plyfile

    try:
        with warnings.catch_warnings(action="ignore"):  # of empty lists in text files
            return plyfile.PlyData.read(path)
    except plyfile.PlyParseError as error:
        raise MeshError(f"{path}: not a whole PLY file: {error}") from error
    except (ValueError, KeyError, IndexError, OverflowError, MemoryError) as error:
        raise MeshError(f"{path}: not a valid PLY file: {error}") from error


def stated_unit(ply: Any) -> str | None:
    """Return the unit of length that the header states, if any."""
    for comment in ply.comments:
        if comment.startswith(UNIT_COMMENT):
            return str(comment[len(UNIT_COMMENT) :]).strip()
    return None
