"""OFF meshes in text, also with colours or normals, which are left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skinviz.errors import MeshError
from skinviz.scan.formats.content import (
    Lines,
    flat_lists,
    integers,
    read_lines,
    shown,
    stated_unit,
    table,
    uniform_integers,
)
from skinviz.scan.formats.ply_header import Lists
from skinviz.scan.formats.surface import fan, welded
from skinviz.scan.scan import Scan

_KINDS = ("OFF", "COFF", "NOFF", "CNOFF", "STOFF")


def read_off(path: Path, unit: str | None) -> Scan:
    """Return the mesh in an OFF file, in mm."""
    lines = read_lines(path)
    n_points, n_faces, start = _counts(lines)
    found = len(lines) - start
    if n_points == 0 or n_faces == 0 or n_points + n_faces != found:
        raise MeshError(
            f"{path}: not a whole OFF mesh: its header says {n_points} points and "
            f"{n_faces} faces, a line each, and {found} lines follow; points without "
            "faces are no mesh"
        )
    points = table(lines.part(start, start + n_points), first=3)
    polygons = _polygons(lines.part(start + n_points))
    faces = fan(polygons, n_points, str(path))
    return welded(points, faces, path, unit, stated_unit(lines.comments))


def _counts(lines: Lines) -> tuple[int, int, int]:
    """Return how many points and faces the header says, and the line after it."""
    words = lines.texts[0].split()
    if words[0] not in _KINDS:
        raise lines.fault(
            0, f"an OFF file begins with one of {', '.join(_KINDS)}; got "
            f"{shown(lines.texts[0])}"
        )  # fmt: skip
    at = 0
    words = words[1:]
    if not words:
        at = 1
        words = lines.texts[1].split() if len(lines) > 1 else []
    if len(words) not in (2, 3) or not all(w.isdecimal() for w in words):
        raise lines.fault(
            min(at, len(lines) - 1),
            "not a whole OFF file: after OFF come the numbers of points, faces and "
            "edges",
        )
    return int(words[0][:19]), int(words[1][:19]), at + 1


def _polygons(lines: Lines) -> Lists:
    """Return the polygons of lines ``n i j k ...``; colours may follow."""
    uniform = uniform_integers(lines.texts)
    if uniform is not None and (uniform[:, 0] == uniform.shape[1] - 1).all():
        return Lists(uniform[:, 0], uniform[:, 1:].reshape(-1))
    corners = []
    for i, text in enumerate(lines.texts):
        words = text.split()
        (count,) = integers(lines, words[:1], i)
        if count < 3:
            raise lines.fault(i, "a face has fewer than three points")
        if len(words) - 1 < count:
            raise lines.fault(
                i, f"a face of {count} points names {len(words) - 1} of them"
            )
        corners.append(integers(lines, words[1 : count + 1], i))
    counts = np.array([len(c) for c in corners], dtype=np.int64)
    return Lists(counts, flat_lists(corners))
