"""Stanford range views: PLY files with a ``range_grid``, placed by a ``.conf``.

A ``.conf`` line is ``bmesh FILE tx ty tz qi qj qk ql``. In these files the
quaternion turns the *frame*, not the points: the rotation that places a view is
its inverse. That is the repository's convention; ours reads and writes the same.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file, whole_file
from skinviz.errors import MeshError
from skinviz.scan.checks import to_millimetres
from skinviz.scan.formats.content import (
    UNIT_COMMENT,
    as_indices,
    read_lines,
    stated_unit,
)
from skinviz.scan.formats.ply import Ply, read_ply
from skinviz.scan.formats.ply import columns as ply_columns
from skinviz.scan.formats.ply_header import Element
from skinviz.scan.scan import RangeView, Scan, scale_to_millimetres

_EYE = "eye"  # first word of the comment that says where rays meet


def is_range_grid(ply: Ply) -> bool:
    """Return whether a parsed PLY file holds a range grid."""
    return "range_grid" in ply.elements


def view_from_ply(
    ply: Ply, path: Path, unit: str | None, pose: NDArray[np.float64]
) -> RangeView:
    """Return the range view in a parsed PLY file, in mm."""
    scale = scale_to_millimetres(unit, str(path), stated_unit(ply.comments))
    cells = ply.elements["range_grid"]
    rows, columns = _grid_shape(ply, cells.count, path)
    points = ply_columns(ply.elements.get("vertex"), "xyz", path)
    filled, index = _cells(cells, len(points), path)
    if index.size == 0:
        raise MeshError(f"{path}: the range grid has no return at all")
    if not np.isfinite(points[index]).all():
        raise MeshError(f"{path}: a return is not finite; remove it from the grid")
    grid = np.full((rows * columns, 3), np.nan)
    grid[filled] = to_millimetres(points[index], scale, str(path))
    eye = _eye(ply.comments, scale, path)
    return RangeView(path.stem, grid.reshape(rows, columns, 3), pose, eye)


def _eye(
    comments: Iterable[str], scale: float, path: Path
) -> NDArray[np.float64] | None:
    """Return where the rays meet, if a comment ``eye x y z`` says so. [mm]"""
    for comment in comments:
        words = comment.split()
        if words[:1] == [_EYE] and len(words) == 4:
            try:
                eye = np.array([float(word) for word in words[1:]])
            except ValueError:
                continue  # prose that begins with that word
            return to_millimetres(eye, scale, str(path))
    return None


def _grid_shape(ply: Ply, n_cells: int, path: Path) -> tuple[int, int]:
    """Return the rows and columns that the header states for its cells."""
    info = dict(words[:2] for line in ply.obj_info if len(words := line.split()) >= 2)
    try:
        rows, columns = int(info["num_rows"]), int(info["num_cols"])
    except (KeyError, ValueError) as error:
        raise MeshError(
            f"{path}: a range grid needs 'obj_info num_rows' and 'num_cols' lines"
        ) from error
    if rows <= 0 or columns <= 0 or n_cells != rows * columns:
        raise MeshError(
            f"{path}: the header says {rows} x {columns} cells, the file has {n_cells}"
        )
    return rows, columns


def _cells(
    cells: Element, n_points: int, path: Path
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return which cells have a return, and the vertex of each."""
    if not cells.lists:
        raise MeshError(f"{path}: a range grid needs a list of vertices in each cell")
    lists = next(iter(cells.lists.values()))
    filled = np.flatnonzero(lists.counts)
    first = (np.cumsum(lists.counts) - lists.counts)[filled]
    index = as_indices(lists.values[first], str(path))
    wrong = index[(index < 0) | (index >= n_points)]
    if wrong.size:
        raise MeshError(f"{path}: a grid cell names vertex {wrong[0]} of {n_points}")
    return filled, index


def read_conf(path: Path, unit: str | None) -> Scan:
    """Return the views that a ``.conf`` file lists, in mm, with their poses."""
    views = []
    lines = read_lines(path)
    for number, line in zip(lines.numbers, lines.texts, strict=True):
        words = line.split()
        if not words or words[0] != "bmesh":
            continue  # comments, and the viewer's camera
        where = f"{path} line {number}"
        name = line.split(maxsplit=1)[-1].rsplit(maxsplit=7)[0]  # may hold spaces
        if len(words) < 9:
            raise _not_nine(words, where)
        try:
            file = existing_file(path.parent / name, MeshError)
        except MeshError as error:
            told = _not_nine(words, where) if len(words) > 9 else None
            raise told or MeshError(f"{where}: {error}") from error
        ply = read_ply(file)
        if not is_range_grid(ply):
            raise MeshError(f"{file}: has no range_grid, which {where} expects")
        scale = scale_to_millimetres(unit, str(file), stated_unit(ply.comments))
        views.append(view_from_ply(ply, file, unit, _pose(words[-7:], scale, where)))
    if not views:
        raise MeshError(f"{path}: no 'bmesh' line, so no view to read")
    return Scan(views=tuple(views), source=str(path))


def _not_nine(words: list[str], where: str) -> MeshError:
    """Return the error of a line with too few or too many values."""
    return MeshError(
        f"{where}: expected 'bmesh FILE tx ty tz qi qj qk ql', got {len(words) - 1} "
        "values"
    )


def write_scan(
    path: str | os.PathLike[str], scan: Scan, comments: tuple[str, ...] = ()
) -> list[Path]:
    """Write range views as PLY files in mm, placed by a ``.conf``.

    Parameters
    ----------
    path : str or path-like
        The ``.conf`` file; each view goes beside it, under its own name.
    scan : Scan
        Its views are written.
    comments : tuple of str
        One line each, put at the head of every file.

    Returns
    -------
    files : list of Path
        The views' files and, last, the ``.conf``.

    Raises
    ------
    MeshError
        If the scan has no views, or two of one name.

    Notes
    -----
    Where the rays of a view meet in a point, a comment ``eye x y z`` says where.
    """
    names = [view.name for view in scan.views]
    if not names or len(set(names)) < len(names):
        raise MeshError(
            f"{path}: a scan is written as its views, each under its own name; got "
            f"{names}"
        )
    from scipy.spatial.transform import Rotation

    conf = Path(path)
    written, lines = [], [f"# {comment}" for comment in comments]
    for view in scan.views:
        file = conf.with_name(f"{view.name}.ply")
        _write_view(file, view, comments)
        written.append(file)
        frame = Rotation.from_matrix(view.pose[:3, :3]).inv().as_quat()
        numbers = " ".join(f"{x:.9g}" for x in (*view.pose[:3, 3], *frame))
        lines.append(f"bmesh {file.name} {numbers}")
    with whole_file(conf) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return [*written, conf]


def _pose(words: list[str], scale: float, where: str) -> NDArray[np.float64]:
    """Return the pose of a ``bmesh`` line, its shift scaled to mm."""
    from scipy.spatial.transform import Rotation

    try:
        numbers = np.array([float(word) for word in words])
    except ValueError as error:
        raise MeshError(f"{where}: {error}") from error
    shift = to_millimetres(numbers[:3], scale, where)
    if not 0.25 < np.abs(numbers[3:]).max() < 100:
        raise MeshError(f"{where}: the quaternion is not finite or far from length 1")
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(numbers[3:]).inv().as_matrix()
    pose[:3, 3] = shift
    return pose


def _write_view(path: Path, view: RangeView, comments: tuple[str, ...]) -> None:
    """Write one view as a binary PLY file with a range grid, in mm."""
    import plyfile

    valid = view.valid
    points = view.points[valid].astype("<f4")
    vertex = np.array([tuple(p) for p in points], dtype=[(k, "<f4") for k in "xyz"])
    cells = np.zeros(valid.size, dtype=[("vertex_indices", "O")])
    index = np.full(valid.size, -1)
    index[valid.ravel()] = np.arange(len(points))
    none = np.zeros(0, dtype="<i4")
    cells["vertex_indices"] = [
        none if i < 0 else np.array([i], dtype="<i4") for i in index
    ]
    rows, columns = valid.shape
    eye = []
    if view.eye is not None:
        eye = [" ".join([_EYE, *(f"{float(x):.9g}" for x in view.eye)])]
    data = plyfile.PlyData(
        [
            plyfile.PlyElement.describe(vertex, "vertex"),
            plyfile.PlyElement.describe(
                cells,
                "range_grid",
                len_types={"vertex_indices": "u1"},
                val_types={"vertex_indices": "i4"},
            ),
        ],
        byte_order="<",
        comments=[f"{UNIT_COMMENT}mm", *eye, *comments],
        obj_info=[f"num_cols {columns}", f"num_rows {rows}"],
    )
    with whole_file(path) as partial:
        data.write(str(partial))
