"""ASC files: an Esri grid of heights, or points in text.

A grid says ``ncols``, ``nrows``, its corner, ``cellsize`` and perhaps
``NODATA_value``; the heights follow, the northmost row first.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skinviz.errors import MeshError
from skinviz.scan.checks import to_millimetres
from skinviz.scan.formats.content import (
    Lines,
    is_number,
    read_lines,
    shown,
    stated_unit,
    table,
)
from skinviz.scan.formats.xyz import COMMENTS, scan_of_points
from skinviz.scan.scan import RangeView, Scan, scale_to_millimetres

_KEYS = {
    *("ncols", "nrows", "cellsize", "nodata_value"),
    *("xllcorner", "xllcenter", "yllcorner", "yllcenter"),
}


def read_asc(path: Path, unit: str | None) -> Scan:
    """Return the grid's view or the points in an ASC file, in mm."""
    lines = read_lines(path, COMMENTS)
    if lines.texts[0].split()[0].lower() not in _KEYS:
        return scan_of_points(lines, unit)
    header, rows = _header(lines)
    shape = (int(header["nrows"]), int(header["ncols"]))
    heights = _heights(rows, shape)
    heights[heights == header.get("nodata_value", -9999.0)] = np.nan
    if np.isnan(heights).all():
        raise MeshError(f"{path}: the grid has no return at all")
    scale = scale_to_millimetres(unit, str(path), stated_unit(lines.comments))
    step = header["cellsize"]
    x, y = (
        header.get(f"{k}llcenter", header.get(f"{k}llcorner", 0.0) + step / 2)
        for k in "xy"
    )
    points = np.zeros((*shape, 3))
    points[..., 0] = x + step * np.arange(shape[1])
    points[..., 1] = (y + step * np.arange(shape[0])[::-1])[:, None]
    points[..., 2] = heights
    filled = ~np.isnan(heights)
    points[filled] = to_millimetres(points[filled], scale, str(path))
    points[~filled] = np.nan
    view = RangeView(path.stem, points, np.eye(4))
    return Scan(views=(view,), source=str(path))


def _header(lines: Lines) -> tuple[dict[str, float], Lines]:
    """Return what the header states by name, and the lines after it."""
    header: dict[str, float] = {}
    for i, text in enumerate(lines.texts):
        key, *values = text.lower().split()
        if key not in _KEYS:
            break
        value = values[0] if len(values) == 1 else ""
        if not is_number(value) or not np.isfinite(float(value)) or key in header:
            raise lines.fault(i, f"expected one number after {key}, once")
        header[key] = float(value)
    for key in ("ncols", "nrows", "cellsize"):
        if not header.get(key, 0.0) > 0:
            raise MeshError(f"{lines.path}: the grid's {key} must be given, above 0")
        if key != "cellsize" and header[key] != int(header[key]):
            raise MeshError(f"{lines.path}: the grid's {key} must be a whole number")
    return header, lines.part(len(header))


def _heights(lines: Lines, shape: tuple[int, int]) -> np.ndarray:
    """Return the grid's heights (rows, columns); lines need not be rows."""
    rows, columns = shape
    if len(lines) == rows:
        return table(lines, columns=columns)
    words = [word for text in lines.texts for word in text.split()]
    if len(words) != rows * columns:
        raise MeshError(
            f"{lines.path}: the header says {rows} x {columns} cells, the file has "
            f"{len(words)}"
        )
    bad = [word for word in words if not is_number(word)]
    if bad:
        raise MeshError(f"{lines.path}: {shown(bad[0])} is no number")
    heights = np.array(words, dtype=np.float64).reshape(shape)
    if not np.isfinite(heights).all():
        raise MeshError(f"{lines.path}: a height is not finite; mark it as no data")
    return heights
