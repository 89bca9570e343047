"""PyVista's own ``read`` opens range views: as surfaces, without bridges.

VTK reads a ``range_grid`` as bare points, and ``.conf`` and ``.ptx`` not at all. The
package declares these readers to PyVista, which loads this module when it meets such
a file; :func:`register` does the same for a checkout that is not installed.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.formats.read import read_scan
from skinviz.scan.grid import triangulate
from skinviz.scan.scan import MissingUnitError, RangeView, Scan, transform

if TYPE_CHECKING:
    import pyvista

_MAX_INCIDENCE = np.deg2rad(75)
_MOST_HEADER = 1 << 16


def register() -> None:
    """Make ``pyvista.read`` use these readers."""
    import pyvista as pv

    for suffix, reader in (
        (".conf", read_views),
        (".ptx", read_views),
        (".ply", read_ply),
    ):
        pv.register_reader(suffix, reader, override=True)


def read_views(path: str, *, unit: str | None = None) -> pyvista.MultiBlock:
    """Read range views as one surface each, placed by their poses.

    Parameters
    ----------
    path : str
        A ``.conf`` or ``.ptx`` file.
    unit : str, optional
        Unit of length, as for :func:`skinviz.read_scan`. Without it, and if the
        file states none, the file's own numbers are kept.

    Returns
    -------
    views : pyvista.MultiBlock
        A surface a view, by its name. [mm]
    """
    import pyvista as pv

    views = _scan(path, unit).views
    return pv.MultiBlock({view.name: _surface(view) for view in views})


def read_ply(path: str) -> pyvista.DataSet:
    """Read a PLY file: a range grid as a surface, any other by VTK.

    Parameters
    ----------
    path : str
        The file.

    Returns
    -------
    mesh : pyvista.PolyData
        Of a range grid in mm, or in the file's own numbers if it states no unit.
    """
    import pyvista as pv

    with Path(path).open("rb") as file:
        head = file.read(_MOST_HEADER).partition(b"end_header")[0]
    if b"element range_grid" not in head:
        return pv.PLYReader(path).read()
    (view,) = _scan(path).views
    return _surface(view)


def _scan(path: str | os.PathLike[str], unit: str | None = None) -> Scan:
    """Return a scan in mm, or in the file's own numbers if nobody knows its unit."""
    try:
        return read_scan(path, unit)
    except MissingUnitError:
        return read_scan(path, "mm")


def _surface(view: RangeView) -> pyvista.PolyData:
    """Return a view's returns, joined where they are neighbours on one surface."""
    points, faces, _ = triangulate(view.points, _MAX_INCIDENCE, view.eye)
    if len(faces) == 0:
        raise MeshError(f"view {view.name!r} has no two neighbours on one surface")
    return topology.polydata(transform(view.pose, points), faces)
