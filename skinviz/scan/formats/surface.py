"""Triangle meshes: what all their readers share, PLY meshes, and writing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz._validate import one_of
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles, to_millimetres
from skinviz.scan.formats.cloud import cloud_from_ply
from skinviz.scan.formats.content import UNIT_COMMENT, as_indices, stated_unit
from skinviz.scan.formats.ply import Ply, columns
from skinviz.scan.formats.ply_header import Lists
from skinviz.scan.scan import Scan, scale_to_millimetres

if TYPE_CHECKING:
    import pyvista

UNIT_FIELD = "unit"
"""Field array by which our VTP files state their unit of length."""


def scan_from_ply(ply: Ply, path: Path, unit: str | None) -> Scan:
    """Return the mesh in a parsed PLY file, or its points if it has no faces. [mm]"""
    if "tristrips" in ply.elements:
        raise MeshError(
            f"{path}: its triangles are in strips; write it with faces instead"
        )
    face = ply.elements.get("face")
    if face is None or face.count == 0:
        return Scan(cloud=cloud_from_ply(ply, path, unit), source=str(path))
    names = [n for n in face.lists if n in ("vertex_indices", "vertex_index")]
    if not names:
        raise MeshError(f"{path}: faces without vertex_indices")
    points = columns(ply.elements.get("vertex"), "xyz", path)
    faces = fan(face.lists[names[0]], len(points), str(path))
    scale = scale_to_millimetres(unit, str(path), stated_unit(ply.comments))
    mesh = topology.polydata(to_millimetres(points, scale, str(path)), faces)
    require_triangles(mesh, str(path))
    return Scan(mesh=mesh, source=str(path))


def welded(
    points: topology.Points,
    faces: topology.Faces,
    path: Path,
    unit: str | None,
    stated: str | None = None,
) -> Scan:
    """Return a mesh in mm, in which points at one place are one point.

    STL repeats each point in each triangle, other programs' OBJ and OFF at seams.
    """
    scale = scale_to_millimetres(unit, str(path), stated)
    single, inverse = _distinct(points)
    mesh = topology.polydata(to_millimetres(single, scale, str(path)), inverse[faces])
    require_triangles(mesh, str(path))
    return Scan(mesh=mesh, source=str(path))


def fan(polygons: Lists, n_points: int, where: str) -> topology.Faces:
    """Return polygons, each cut into triangles (m, 3) at its first corner."""
    counts, flat = polygons.counts, as_indices(polygons.values, where)
    if flat.size == 0 or counts.min() < 3:
        raise MeshError(f"{where}: a face has fewer than three points")
    wrong = flat[(flat < 0) | (flat >= n_points)]
    if wrong.size:
        raise MeshError(f"{where}: a face names point {wrong[0]} of {n_points}")
    start = np.repeat(np.cumsum(counts) - counts, counts - 2)
    step = np.arange(start.size) - np.repeat(
        np.cumsum(counts - 2) - (counts - 2), counts - 2
    )
    return np.stack([flat[start], flat[start + step + 1], flat[start + step + 2]], 1)


def _distinct(points: topology.Points) -> tuple[topology.Points, NDArray[np.int64]]:
    """Return the points without repetitions, and which of them each one is."""
    order = np.lexsort(points.T[::-1])
    ordered = points[order]
    new = np.ones(len(points), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    inverse = np.zeros(len(points), dtype=np.int64)
    inverse[order] = np.cumsum(new) - 1
    return ordered[new], inverse


def write_mesh(path: str | Path, mesh: pyvista.PolyData) -> Path:
    """Write a mesh in mm as PLY or VTP; the file states its unit.

    Parameters
    ----------
    path : str or Path
        Ends in ``.ply`` (points, faces, normals, colour) or ``.vtp`` (all data).
    mesh : pyvista.PolyData
        Triangles. [mm]

    Returns
    -------
    path : Path
        The file written.
    """
    file = Path(path)
    suffix = one_of(file.suffix.lower(), (".ply", ".vtp"), "mesh file suffix")
    with whole_file(file) as partial:
        if suffix == ".vtp":
            stated = mesh.copy(deep=False)
            stated.field_data[UNIT_FIELD] = ["mm"]
            stated.save(partial)
        else:
            _write_ply(partial, mesh)
    return file


def _write_ply(path: Path, mesh: pyvista.PolyData) -> None:
    """Write points, normals, colour and faces as a binary PLY file."""
    import plyfile

    points, faces = topology.arrays(mesh)
    columns = [(k, points[:, i], "<f4") for i, k in enumerate("xyz")]
    if "Normals" in mesh.point_data:
        normals = np.asarray(mesh.point_data["Normals"])
        columns += [(f"n{k}", normals[:, i], "<f4") for i, k in enumerate("xyz")]
    if "rgb" in mesh.point_data:
        rgb = np.asarray(mesh.point_data["rgb"])
        names = ("red", "green", "blue")
        columns += [(k, rgb[:, i], "u1") for i, k in enumerate(names)]
    vertex = np.zeros(len(points), dtype=[(name, kind) for name, _, kind in columns])
    for name, values, _ in columns:
        vertex[name] = values
    face = np.zeros(len(faces), dtype=[("vertex_indices", "<i4", (3,))])
    face["vertex_indices"] = faces
    plyfile.PlyData(
        [
            plyfile.PlyElement.describe(vertex, "vertex"),
            plyfile.PlyElement.describe(face, "face"),
        ],
        byte_order="<",
        comments=[f"{UNIT_COMMENT}mm"],
    ).write(str(path))
