"""VTP: VTK's own XML files of surfaces, with all their data arrays.

VTK's reader dies of some broken files, so this one reads the XML itself.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles, to_millimetres
from skinviz.scan.formats.content import as_indices, read_bytes, shown
from skinviz.scan.formats.ply_header import Lists
from skinviz.scan.formats.surface import UNIT_FIELD, fan
from skinviz.scan.formats.vtk_arrays import ArrayReader, BrokenArrayError
from skinviz.scan.scan import Scan, scale_to_millimetres

if TYPE_CHECKING:
    import pyvista

_Xml = ET.Element
_ORDERS = {"LittleEndian": "<", "BigEndian": ">"}
_HEADERS = {"UInt32": "u4", "UInt64": "u8"}


def read_vtp(path: Path, unit: str | None) -> Scan:
    """Return the mesh in a VTP file with its data arrays, in mm."""
    try:
        mesh = _read(path, unit)
    except BrokenArrayError as error:
        raise MeshError(f"{path}: not a whole VTP file: {error}") from error
    return Scan(mesh=mesh, source=str(path))


def _read(path: Path, unit: str | None) -> pyvista.PolyData:
    """Return the mesh in a VTP file."""
    root, arrays = _parsed(path)
    piece = root.find("PolyData/Piece")
    if piece is None or len(root.findall("PolyData/Piece")) != 1:
        raise MeshError(
            f"{path}: not one surface in one piece, as a VTP file should be"
        )
    stored = piece.find("Points/DataArray")
    points = np.zeros((0, 3)) if stored is None else arrays.read(stored)
    n_points = _stated(piece, "NumberOfPoints")
    if points.shape != (n_points, 3):
        raise BrokenArrayError(
            f"it states {n_points} points and has an array of {points.shape}"
        )
    faces, as_stored = _faces(piece, arrays, n_points, path)
    fields = _data(root.find("PolyData/FieldData"), arrays)
    named = fields.get(UNIT_FIELD)
    scale = scale_to_millimetres(unit, str(path), None if named is None else str(named))
    placed = to_millimetres(points, scale, str(path))
    mesh = topology.polydata(placed, faces)
    require_triangles(mesh, str(path))
    _attach(mesh.point_data, _data(piece.find("PointData"), arrays), n_points)
    if as_stored:
        _attach(mesh.cell_data, _data(piece.find("CellData"), arrays), len(faces))
    for name, values in fields.items():
        mesh.field_data[name] = [values] if isinstance(values, str) else values
    return mesh


def _parsed(path: Path) -> tuple[_Xml, ArrayReader]:
    """Return the file's XML and the reader of its arrays."""
    content = read_bytes(path)
    if b"<VTKFile" not in content[:1024] or b"</VTKFile>" not in content[-1024:]:
        raise MeshError(
            f"{path}: not a whole VTP file; it is cut short or another kind"
        )
    xml, appended, encoded = _split(content)
    if b"<!DOCTYPE" in xml or b"<!ENTITY" in xml:
        raise MeshError(f"{path}: not a VTP file: it declares entities of its own")
    try:
        root = ET.fromstring(xml)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise MeshError(f"{path}: not a whole VTP file: {error}") from error
    kind = root.get("type", "")
    if root.tag != "VTKFile" or kind != "PolyData":
        raise MeshError(f"{path}: not a surface but {shown(kind)}")
    order = _ORDERS.get(root.get("byte_order", "LittleEndian"))
    header = _HEADERS.get(root.get("header_type", "UInt32"))
    if order is None or header is None:
        raise BrokenArrayError("unknown byte_order or header_type")
    return root, ArrayReader(
        order, header, root.get("compressor", ""), appended, encoded, len(content)
    )


def _split(content: bytes) -> tuple[bytes, bytes, bool]:
    """Return the XML, the bytes after it, and whether those are base64."""
    begin = re.search(rb"<AppendedData([^>]*)>\s*_", content)
    if begin is None:
        return content, b"", False
    end = content.rfind(b"</AppendedData>")
    encoded = b"base64" in begin.group(1)
    appended = content[begin.end() : end]
    return content[: begin.start()] + b"</VTKFile>", appended, encoded


def _stated(piece: _Xml, name: str) -> int:
    """Return a number that the piece states; none is 0."""
    word = piece.get(name, "0").strip()
    if not word.isdecimal():
        raise BrokenArrayError(f"{name} is {shown(word)}")
    return int(word[:19])


def _faces(
    piece: _Xml, arrays: ArrayReader, n_points: int, path: Path
) -> tuple[topology.Faces, bool]:
    """Return the triangles (m, 3), and whether they are all of the file's cells."""
    polygons = _cells(piece, arrays, "Polys", path)
    strips = _cells(piece, arrays, "Strips", path)
    found = []
    if polygons.counts.size:
        found.append(fan(polygons, n_points, str(path)))
    if strips.counts.size:
        faces = fan(_strip_triangles(strips), n_points, str(path))
        found.append(faces)
    if not found:
        raise MeshError(
            f"{path} has {n_points} points but no faces; a mesh with faces or a range "
            "grid is needed"
        )
    others = _stated(piece, "NumberOfVerts") + _stated(piece, "NumberOfLines")
    plain = not others and not strips.counts.size and (polygons.counts == 3).all()
    return np.concatenate(found), bool(plain)


def _cells(piece: _Xml, arrays: ArrayReader, kind: str, path: Path) -> Lists:
    """Return the cells of a kind as lists of points."""
    stored = {a.get("Name"): a for a in piece.findall(f"{kind}/DataArray")}
    count = _stated(piece, f"NumberOf{kind}")
    if count == 0:
        return Lists(np.zeros(0, np.int64), np.zeros(0, np.int64))
    if not {"connectivity", "offsets"} <= set(stored):
        raise BrokenArrayError(f"{kind} without connectivity and offsets")
    flat = as_indices(arrays.read(stored["connectivity"]).reshape(-1), str(path))
    ends = as_indices(arrays.read(stored["offsets"]).reshape(-1), str(path))
    counts = np.diff(ends, prepend=0)
    if ends.size != count or counts.min() < 0 or ends[-1] != flat.size:
        raise BrokenArrayError(f"its {kind} are not the {count} that it states")
    return Lists(counts, flat)


def _strip_triangles(strips: Lists) -> Lists:
    """Return the triangles of strips, every second one turned round."""
    if strips.counts.min() < 3:
        raise BrokenArrayError("a strip has fewer than three points")
    n = strips.counts - 2
    start = np.repeat(np.cumsum(strips.counts) - strips.counts, n)
    step = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
    odd = step % 2
    at = start + step
    corners = np.stack([at + odd, at + 1 - odd, at + 2], axis=1)
    return Lists(np.full(len(at), 3), strips.values[corners].reshape(-1))


def _data(section: _Xml | None, arrays: ArrayReader) -> dict[str, NDArray[Any] | str]:
    """Return a section's arrays by name; of strings the first one."""
    found: dict[str, NDArray[Any] | str] = {}
    for element in section if section is not None else ():
        name = element.get("Name", "")
        if not name or element.tag not in ("DataArray", "Array"):
            continue
        if element.get("type") == "String":
            found[name] = arrays.text(element)
        else:
            found[name] = arrays.read(element)
    return found


def _attach(data: Any, arrays: dict[str, NDArray[Any] | str], n_rows: int) -> None:
    """Put arrays on a mesh's points or cells."""
    for name, values in arrays.items():
        if isinstance(values, str):
            continue
        if len(values) != n_rows:
            raise BrokenArrayError(
                f"array {name!r} has {len(values)} rows for {n_rows} points or cells"
            )
        data[name] = values
