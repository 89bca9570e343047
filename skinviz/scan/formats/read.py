"""Choosing the reader by the file: the table of formats."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from skinviz._files import existing_file
from skinviz.errors import MeshError
from skinviz.scan.formats import range_grid, surface
from skinviz.scan.formats.asc import read_asc
from skinviz.scan.formats.obj import read_obj
from skinviz.scan.formats.off import read_off
from skinviz.scan.formats.ply import read_ply
from skinviz.scan.formats.pts import read_pts
from skinviz.scan.formats.ptx import read_ptx
from skinviz.scan.formats.stl import read_stl
from skinviz.scan.formats.vtp import read_vtp
from skinviz.scan.formats.xyz import read_xyz
from skinviz.scan.scan import Scan, no_surface

if TYPE_CHECKING:
    import pyvista


def read_scan(path: str | os.PathLike[str], unit: str | None = None) -> Scan:
    """Read a raw scan or a mesh, in millimetres whatever the file's unit.

    Parameters
    ----------
    path : str or path-like
        Stanford ``.conf`` with its range views; a ``.ply``, ``.ptx`` or ``.asc``
        (Esri) grid; a mesh in ``.ply``, ``.obj``, ``.stl``, ``.off`` or ``.vtp``;
        or points in ``.xyz``, ``.asc``, ``.pts`` or ``.ply``.
    unit : str, optional
        Unit of length in the file: mm, cm, m, um or inch. Required unless the
        file states it, as those written by skinviz do.

    Returns
    -------
    scan : Scan
        Views with grid and pose, a triangle mesh, or bare points: what the file
        has. [mm]

    Raises
    ------
    MeshError
        If the file is missing, empty, broken, of another kind, or without unit.
    """
    file = existing_file(path, MeshError)
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        packed = file.suffix.lower() in (".gz", ".zip", ".bz2", ".xz", ".7z")
        raise MeshError(
            f"{file}: no reader for {file.suffix or 'a file without suffix'!r}; "
            f"known are {', '.join(_READERS)}" + ("; unpack it first" if packed else "")
        )
    return reader(file, unit)


def read_mesh(
    path: str | os.PathLike[str], unit: str | None = None
) -> pyvista.PolyData:
    """Read a triangle mesh in mm; a file of range views or points is refused.

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
        As :func:`read_scan`, and if the file holds range views or points.
    """
    scan = read_scan(path, unit)
    if scan.cloud is not None:
        raise no_surface(scan.cloud, str(path))
    if scan.mesh is None:
        raise MeshError(
            f"{path} holds raw range views, not a mesh; clean it first: "
            f"skinviz clean {path} -o hand.ply"
        )
    return scan.mesh


def _read_ply(path: Path, unit: str | None) -> Scan:
    """Read a PLY file that holds a range grid, a mesh or points."""
    ply = read_ply(path)
    if range_grid.is_range_grid(ply):
        view = range_grid.view_from_ply(ply, path, unit, np.eye(4))
        return Scan(views=(view,), source=str(path))
    return surface.scan_from_ply(ply, path, unit)


_READERS = {
    ".conf": range_grid.read_conf,
    ".ply": _read_ply,
    ".obj": read_obj,
    ".stl": read_stl,
    ".off": read_off,
    ".xyz": read_xyz,
    ".asc": read_asc,
    ".pts": read_pts,
    ".ptx": read_ptx,
    ".vtp": read_vtp,
}
