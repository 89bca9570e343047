"""Choosing the reader by the file: the table of formats."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from skinviz._files import existing_file
from skinviz.errors import MeshError
from skinviz.scan.formats import range_grid, surface
from skinviz.scan.formats.ply import read_ply
from skinviz.scan.scan import Scan

if TYPE_CHECKING:
    import pyvista


def read_scan(path: str | os.PathLike[str], unit: str | None = None) -> Scan:
    """Read a raw scan or a mesh, in millimetres whatever the file's unit.

    Parameters
    ----------
    path : str or path-like
        Stanford ``.conf`` with its range views, a ``.ply`` range grid, or a mesh
        in ``.ply``, ``.obj``, ``.stl``, ``.off`` or ``.vtp``.
    unit : str, optional
        Unit of length in the file: mm, cm, m, um or inch. Required unless the
        file states it, as those written by skinviz do.

    Returns
    -------
    scan : Scan
        Views with grid and pose, or a triangle mesh. [mm]

    Raises
    ------
    MeshError
        If the file is missing, empty, broken, of another kind, or without unit.
    """
    file = existing_file(path, MeshError)
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise MeshError(
            f"{file}: no reader for {file.suffix or 'a file without suffix'!r}; "
            f"known are {', '.join(_READERS)}"
        )
    return reader(file, unit)


def read_mesh(
    path: str | os.PathLike[str], unit: str | None = None
) -> pyvista.PolyData:
    """Read a triangle mesh in mm; a file of range views is refused.

    Parameters
    ----------
    path : str or path-like
        A mesh file, as for :func:`read_scan`.
    unit : str, optional
        Unit of length, as for :func:`read_scan`.

    Returns
    -------
    mesh : pyvista.PolyData
        Triangles. [mm]

    Raises
    ------
    MeshError
        As :func:`read_scan`, and if the file holds range views.
    """
    scan = read_scan(path, unit)
    if scan.mesh is None:
        raise MeshError(
            f"{path} holds raw range views, not a mesh; clean it first: "
            f"skinviz clean {path} -o hand.ply"
        )
    return scan.mesh


def _read_ply(path: Path, unit: str | None) -> Scan:
    """Read a PLY file that holds a range grid or a mesh."""
    ply = read_ply(path)
    if range_grid.is_range_grid(ply):
        view = range_grid.view_from_ply(ply, path, unit, np.eye(4))
        return Scan(views=(view,), source=str(path))
    return Scan(mesh=surface.mesh_from_ply(ply, path, unit), source=str(path))


def _read_surface(path: Path, unit: str | None) -> Scan:
    """Read an OBJ, STL or OFF mesh."""
    return Scan(mesh=surface.read_by_trimesh(path, unit), source=str(path))


def _read_vtp(path: Path, unit: str | None) -> Scan:
    """Read a VTP mesh."""
    return Scan(mesh=surface.read_vtp(path, unit), source=str(path))


_READERS = {
    ".conf": range_grid.read_conf,
    ".ply": _read_ply,
    ".obj": _read_surface,
    ".stl": _read_surface,
    ".off": _read_surface,
    ".vtp": _read_vtp,
}
