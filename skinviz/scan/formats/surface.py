"""Triangle meshes: PLY, OBJ, STL, OFF and VTP files."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skinviz._files import whole_file
from skinviz._validate import one_of
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles
from skinviz.scan.formats.ply import UNIT_COMMENT, stated_unit
from skinviz.scan.scan import scale_to_millimetres

if TYPE_CHECKING:
    import pyvista

UNIT_FIELD = "unit"
"""Field array by which our VTP files state their unit of length."""


def mesh_from_ply(ply: Any, path: Path, unit: str | None) -> pyvista.PolyData:
    """Return the triangle mesh in a parsed PLY file, in mm."""
    try:
        vertices = ply["vertex"].data
        points = np.stack([vertices[k] for k in "xyz"], axis=1).astype(np.float64)
    except (KeyError, ValueError) as error:
        raise MeshError(f"{path}: no vertices with x, y and z") from error
    if "face" not in ply or ply["face"].count == 0:
        raise MeshError(
            f"{path} has {len(points)} points but no faces; a mesh with faces or a "
            "range grid is needed"
        )
    cells = ply["face"].data
    names = [n for n in cells.dtype.names if n in ("vertex_indices", "vertex_index")]
    if not names:
        raise MeshError(f"{path}: faces without vertex_indices")
    faces = _triangles(cells[names[0]], len(points), path)
    scale = scale_to_millimetres(unit, str(path), stated_unit(ply))
    mesh = topology.polydata(points * scale, faces)
    require_triangles(mesh, str(path))
    return mesh


def read_by_trimesh(path: Path, unit: str | None) -> pyvista.PolyData:
    """Return the mesh in an OBJ, STL or OFF file, in mm."""
    import trimesh

    try:
        loaded = trimesh.load_mesh(path, process=False)
    # trimesh's parsers raise whatever the broken bytes lead them to.
    except Exception as error:
        raise MeshError(
            f"{path}: not a whole {path.suffix[1:].upper()} file: {error}"
        ) from error
    points = np.asarray(getattr(loaded, "vertices", ()), dtype=np.float64)
    faces = np.asarray(getattr(loaded, "faces", ()), dtype=np.int64)
    stated = _off_face_count(path) if path.suffix.lower() == ".off" else None
    if faces.size == 0 or (stated is not None and len(faces) < stated):
        raise MeshError(
            f"{path}: {len(points)} points and {len(faces)} faces could be read"
            + (f" of {stated}" if stated is not None else "")
            + "; the file is cut short or is no triangle mesh"
        )
    scale = scale_to_millimetres(unit, str(path))
    # These formats repeat a point for each triangle or texture seam that has it.
    points, inverse = np.unique(points, axis=0, return_inverse=True)
    mesh = topology.polydata(points * scale, inverse.reshape(-1)[faces])
    require_triangles(mesh, str(path))
    return mesh


def read_vtp(path: Path, unit: str | None) -> pyvista.PolyData:
    """Return the mesh in a VTP file with its data arrays, in mm."""
    import pyvista as pv

    content = path.read_bytes()
    if b"<VTKFile" not in content[:1024] or b"</VTKFile>" not in content[-1024:]:
        raise MeshError(
            f"{path}: not a whole VTP file; it is cut short or another kind"
        )
    try:
        with (
            pv.vtk_verbosity("off"),
            pv.VtkErrorCatcher(raise_errors=True, send_to_logging=False),
            warnings.catch_warnings(action="ignore"),
        ):
            mesh = pv.read(path)
    except Exception as error:
        raise MeshError(f"{path}: VTK cannot read it; write the file anew") from error
    if not isinstance(mesh, pv.PolyData):
        raise MeshError(f"{path}: not a surface but a {type(mesh).__name__}")
    stated = mesh.field_data.get(UNIT_FIELD)
    named = str(stated[0]) if stated is not None else None
    points, faces = require_triangles(mesh, str(path))
    scale = scale_to_millimetres(unit, str(path), named)
    if not mesh.is_all_triangles:
        return topology.polydata(points * scale, faces)
    mesh.points = points * scale
    return mesh


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


def _triangles(lists: Any, n_points: int, path: Path) -> topology.Faces:
    """Return polygons (an array of index lists) fanned into triangles (m, 3)."""
    counts = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
    flat = np.concatenate([np.asarray(x, dtype=np.int64) for x in lists])
    if flat.size == 0 or counts.min() < 3:
        raise MeshError(f"{path}: a face has fewer than three points")
    if flat.min() < 0 or flat.max() >= n_points:
        raise MeshError(f"{path}: a face names point {flat.max()} of {n_points}")
    start = np.repeat(np.cumsum(counts) - counts, counts - 2)
    fan = np.arange(start.size) - np.repeat(
        np.cumsum(counts - 2) - (counts - 2), counts - 2
    )
    return np.stack([flat[start], flat[start + fan + 1], flat[start + fan + 2]], axis=1)


def _off_face_count(path: Path) -> int | None:
    """Return how many faces an OFF header promises, if it can be read."""
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            words = line.split("#")[0].removeprefix("OFF").split()
            if words:
                return int(words[1]) if len(words) > 1 and words[1].isdigit() else None
    return None


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
