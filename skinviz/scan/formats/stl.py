"""STL meshes, binary or text."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skinviz.errors import MeshError
from skinviz.scan.formats.content import Lines, read_bytes, read_lines, shown, table
from skinviz.scan.formats.surface import welded
from skinviz.scan.scan import Scan
from skinviz.scan.topology import Points

_HEAD = 84
_TRIANGLE = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]
)
_FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")


def read_stl(path: Path, unit: str | None) -> Scan:
    """Return the mesh in an STL file, in mm."""
    content = read_bytes(path)
    corners = _binary(content, path)
    if corners is None:
        corners = _text(read_lines(path, ()))
    if len(corners) == 0:
        raise MeshError(f"{path} has no faces; a mesh with faces is needed")
    faces = np.arange(len(corners), dtype=np.int64).reshape(-1, 3)
    return welded(corners, faces, path, unit)


def _binary(content: bytes, path: Path) -> Points | None:
    """Return the triangles' corners (3 n, 3), or None of a file in text."""
    count = int.from_bytes(content[80:_HEAD], "little")
    if len(content) == _HEAD + count * _TRIANGLE.itemsize:
        rows = np.frombuffer(content, _TRIANGLE, count, _HEAD)
        with np.errstate(invalid="ignore"):  # NaN is refused with the other points
            return rows["corners"].reshape(-1, 3).astype(np.float64)
    if content.lstrip()[:5].lower() == b"solid" and b"\0" not in content:
        return None
    room = max(len(content) - _HEAD, 0) / _TRIANGLE.itemsize
    raise MeshError(
        f"{path}: not a whole STL file: it says {count} triangles and has bytes for "
        f"{room:.10g}, and it is no text that begins with 'solid'"
    )


def _text(lines: Lines) -> Points:
    """Return the triangles' corners (3 n, 3) of a file in text."""
    kinds = np.array([text.split(None, 1)[0][:9].lower() for text in lines.texts])
    frame = np.isin(kinds, ["solid", "endsolid"])
    edges = kinds[frame]
    if (edges[0::2] != "solid").any() or (edges[1::2] != "endsolid").any():
        raise MeshError(f"{lines.path}: 'solid' and 'endsolid' do not alternate")
    if kinds[-1] != "endsolid":
        raise lines.fault(
            len(lines) - 1, "not a whole STL file: it does not end with 'endsolid'"
        )
    body = np.flatnonzero(~frame)
    expected = np.resize(np.array(_FACET), len(body))
    wrong = np.flatnonzero(kinds[body] != expected)
    if wrong.size or len(body) % len(_FACET):
        i = int(wrong[0]) if wrong.size else len(body) - 1
        raise lines.fault(
            int(body[i]),
            f"expected {expected[i]!r} of a facet, got {shown(lines.texts[body[i]])}",
        )
    at = body[expected == "vertex"]
    return table(
        Lines(
            lines.path,
            [lines.texts[i][len("vertex") :] for i in at],
            [lines.numbers[i] for i in at],
        ),
        columns=3,
    )
