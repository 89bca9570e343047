"""Wavefront OBJ meshes: points and faces; texture, colour and groups are left out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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

_PASSED_OVER = {
    *("vt", "vn", "vp", "g", "o", "s", "p", "l", "mg", "lod"),
    *("usemtl", "mtllib", "usemap", "maplib", "bevel", "c_interp", "d_interp"),
    *("shadow_obj", "trace_obj", "call", "csh"),
}


def read_obj(path: Path, unit: str | None) -> Scan:
    """Return the mesh in an OBJ file, in mm."""
    lines = _joined(read_lines(path))
    first_words = [text.split(None, 1)[0] for text in lines.texts]
    kinds = np.array([word[:12] for word in first_words])  # no array of long words
    known = np.isin(kinds, [*_PASSED_OVER, "v", "f"])
    if not known.all():
        i = int(np.flatnonzero(~known)[0])
        raise lines.fault(i, f"{shown(first_words[i])} begins no line of an OBJ mesh")
    points = table(_rest(lines, np.flatnonzero(kinds == "v")), first=3)
    face_lines = np.flatnonzero(kinds == "f")
    if len(points) == 0 or face_lines.size == 0:
        raise MeshError(
            f"{path} has {len(points)} points and {face_lines.size} faces; a mesh with "
            "faces is needed"
        )
    # A negative number counts back from the points before its line.
    before = np.cumsum(kinds == "v")[face_lines]
    counts, flat = _polygons(lines, face_lines)
    if (flat == 0).any():
        raise MeshError(f"{path}: a face names point 0; the first is 1")
    flat = np.where(flat < 0, flat + np.repeat(before, counts), flat - 1)
    faces = fan(Lists(counts, flat), len(points), str(path))
    return welded(points, faces, path, unit, stated_unit(lines.comments))


def _joined(lines: Lines) -> Lines:
    """Return lines of which those that end in a backslash go on in the next."""
    if not any(text.endswith("\\") for text in lines.texts):
        return lines
    texts, numbers, begun = [], [], ""
    for text, number in zip(lines.texts, lines.numbers, strict=True):
        begun += text.removesuffix("\\") + " "
        if not text.endswith("\\"):
            texts.append(begun.strip())
            numbers.append(number)
            begun = ""
    if begun or not all(texts):
        raise MeshError(f"{lines.path}: ends or is empty after a backslash")
    return Lines(lines.path, texts, numbers, lines.comments)


def _rest(lines: Lines, at: Sequence[int] | np.ndarray) -> Lines:
    """Return some of the lines without the letter that each begins with."""
    return Lines(
        lines.path,
        [lines.texts[i][1:] for i in at],
        [lines.numbers[i] for i in at],
    )


def _polygons(
    lines: Lines, at: NDArray[np.intp]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return how many points each face's line names, and all that they name."""
    uniform = uniform_integers([lines.texts[i][1:] for i in at])
    if uniform is not None and uniform.shape[1] >= 3:
        return np.full(len(at), uniform.shape[1]), uniform.reshape(-1)
    corners = [_corners(lines, int(i)) for i in at]
    return np.array([len(c) for c in corners]), flat_lists(corners)


def _corners(lines: Lines, index: int) -> list[int]:
    """Return the points that a face's line names."""
    words = [word.partition("/")[0] for word in lines.texts[index].split()[1:]]
    corners = integers(lines, words, index)
    if len(corners) < 3:
        raise lines.fault(index, "a face has fewer than three points")
    return corners
