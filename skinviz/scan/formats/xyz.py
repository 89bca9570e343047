"""Points in text, a line each: XYZ and ASC files.

Columns are parted by blanks, tabs, commas or semicolons; a line of their names may
come first. Without names, the first three are x, y and z, and three more are normals
if all have length 1; what else follows (intensity, colour) is left out.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.formats.cloud import are_normals, point_cloud
from skinviz.scan.formats.content import (
    Lines,
    is_number,
    read_lines,
    shown,
    stated_unit,
    table,
)
from skinviz.scan.scan import Scan

COMMENTS = ("#", "//", "%")

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")


def read_xyz(path: Path, unit: str | None) -> Scan:
    """Return the points in an XYZ file, in mm."""
    return scan_of_points(read_lines(path, COMMENTS), unit)


def scan_of_points(lines: Lines, unit: str | None) -> Scan:
    """Return the points in lines of text, in mm."""
    names, rows = _column_names(_without_count(lines))
    if len(rows) == 0:
        raise MeshError(f"{lines.path} has no points")
    values = table(_without_last(rows), separator=separator_of(rows))
    xyz, normals = _columns(values, names, rows)
    cloud = point_cloud(
        xyz, lines.path, unit, stated=stated_unit(lines.comments), normals=normals
    )
    return Scan(cloud=cloud, source=str(lines.path))


def separator_of(lines: Lines) -> str | None:
    """Return what parts the columns of the first line: None for blanks and tabs."""
    text = lines.texts[0]
    parted = text.split(";") if ";" in text else text.split()
    decimal = [word for word in parted if _DECIMAL_COMMA.fullmatch(word.strip())]
    if len(parted) >= 3 and decimal:
        raise lines.fault(
            0, f"{shown(decimal[0].strip())} has a decimal comma; write the file "
            "with decimal points"
        )  # fmt: skip
    return next((mark for mark in ";," if mark in text), None)


def _without_count(lines: Lines) -> Lines:
    """Return lines without the number of points that some programs begin with."""
    word = lines.texts[0]
    if not word.isdecimal() or len(lines) == 1:
        return lines
    if int(word[:19]) != len(lines) - 1:
        raise lines.fault(0, f"{shown(word)} points expected, {len(lines) - 1} follow")
    return lines.part(1)


def _without_last(lines: Lines) -> Lines:
    """Return lines without the separator that some programs end each with."""
    if lines.texts[0][-1] not in ";,":
        return lines
    texts = [text.rstrip(" \t;,") for text in lines.texts]
    return Lines(lines.path, texts, lines.numbers)


def _column_names(lines: Lines) -> tuple[list[str], Lines]:
    """Return the names in the first line, if it has any, and the other lines."""
    words = re.split(r"[;,\s]+", lines.texts[0].lower().strip(" \t;,"))
    if any(map(is_number, words)) or not {"x", "y", "z"} <= set(words):
        return [], lines
    if len(set(words)) < len(words):
        raise lines.fault(0, "two columns have the same name")
    return words, lines.part(1)


def _columns(
    values: NDArray[np.float64], names: list[str], lines: Lines
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Return the points and, where the columns hold them, the normals."""
    n_columns = values.shape[1]
    if names and len(names) != n_columns:
        raise lines.fault(0, f"{n_columns} numbers under {len(names)} names")
    if n_columns < 3:
        raise lines.fault(
            0, f"expected x, y and z, got {n_columns} numbers: {shown(lines.texts[0])}"
        )
    if names:
        xyz = values[:, [names.index(k) for k in "xyz"]]
        found = [names.index(k) for k in ("nx", "ny", "nz") if k in names]
        return xyz, values[:, found] if len(found) == 3 else None
    if n_columns >= 6 and are_normals(values[:, 3:6]):
        return values[:, :3], values[:, 3:6]
    return values[:, :3], None
