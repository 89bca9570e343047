"""PTX grids: one or more scans, each placed by its own header.

A scan is: columns; rows; the scanner's place and axes, four lines; a matrix of four
lines that takes a point as a row, ``[x y z 1] M``; then a line ``x y z intensity``,
perhaps with a colour, for every cell, column after column. A cell without a return
is ``0 0 0``. The rays meet at the scanner.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.checks import to_millimetres
from skinviz.scan.formats.content import Lines, read_lines, shown, stated_unit, table
from skinviz.scan.scan import RangeView, Scan, scale_to_millimetres

_HEAD = 10
_RIGID = 1e-3  # how far a matrix written with few digits may be from a rotation


def read_ptx(path: Path, unit: str | None) -> Scan:
    """Return the views in a PTX file, in mm, with their poses."""
    lines = read_lines(path)
    scale = scale_to_millimetres(unit, str(path), stated_unit(lines.comments))
    views: list[RangeView] = []
    at = 0
    while at < len(lines):
        if len(lines) - at < _HEAD:
            raise lines.fault(
                at, "not a whole PTX file: a scan begins with ten lines, here are "
                f"{len(lines) - at}"
            )  # fmt: skip
        columns, rows = _count(lines, at), _count(lines, at + 1)
        start, left = at + _HEAD, len(lines) - at - _HEAD
        if columns * rows > left:
            raise lines.fault(
                at, f"not a whole PTX file: the scan says {columns} x {rows} cells, "
                f"{left} lines are left"
            )  # fmt: skip
        at = start + columns * rows
        pose, eye = _placed(lines, start - _HEAD, scale)
        grid = _grid(lines.part(start, at), columns, rows, scale)
        name = f"{path.stem}_{len(views):02d}"
        views.append(RangeView(name, grid, pose, eye))
    if not any(view.valid.any() for view in views):
        raise MeshError(f"{path}: no scan in it has any return")
    return Scan(views=tuple(views), source=str(path))


def _count(lines: Lines, at: int) -> int:
    """Return the number of columns or rows that a line states."""
    word = lines.texts[at]
    if not word.isdecimal() or not int(word[:19]) > 0:
        raise lines.fault(
            at, f"expected a number of columns or rows, above 0, got {shown(word)}"
        )
    return int(word[:19])


def _placed(
    lines: Lines, at: int, scale: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a scan's pose, and the scanner's place in the frame of its points."""
    scanner = table(lines.part(at + 2, at + 6), columns=3)[0]
    matrix = table(lines.part(at + 6, at + _HEAD), columns=4).T
    u, stretch, v = np.linalg.svd(np.clip(matrix[:3, :3], -2, 2))
    turn = u @ v
    rigid = np.abs(stretch - 1).max() < _RIGID and np.linalg.det(turn) > 0
    if not rigid or np.abs(matrix[3] - [0, 0, 0, 1]).max() > _RIGID:
        raise lines.fault(at + 6, "the matrix is no rotation and shift")
    places = np.stack([matrix[:3, 3], scanner])
    shift, seat = to_millimetres(places, scale, f"{lines.path}: its scanner")
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = shift
    return pose, turn.T @ (seat - shift)


def _grid(lines: Lines, columns: int, rows: int, scale: float) -> NDArray[np.float64]:
    """Return a scan's points (rows, columns, 3), NaN where nothing came back."""
    points = to_millimetres(table(lines, first=3), scale, str(lines.path))
    points[(points == 0).all(axis=1)] = np.nan
    return points.reshape(columns, rows, 3).transpose(1, 0, 2).copy()
