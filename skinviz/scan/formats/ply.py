"""The PLY container: parsed strictly, so that a broken file never half loads.

Every count is checked against the bytes that are there before anything is made of
it. What the elements mean belongs in ``range_grid``, ``surface`` and ``cloud``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.formats.content import read_bytes
from skinviz.scan.formats.ply_binary import binary_elements
from skinviz.scan.formats.ply_header import Element, parse_header
from skinviz.scan.formats.ply_text import text_elements


@dataclass(frozen=True)
class Ply:
    """A parsed file: its elements by name, and what its header says."""

    elements: Mapping[str, Element]
    comments: tuple[str, ...]
    obj_info: tuple[str, ...]


def read_ply(path: Path) -> Ply:
    """Return the parsed file, or say where it is broken."""
    content = read_bytes(path)
    header, body = parse_header(content, path)
    if header.order:
        elements = binary_elements(content, body, header, path)
    else:
        elements = text_elements(content[body:], header, path)
    return Ply(elements, header.comments, header.obj_info)


def columns(
    element: Element | None, names: Iterable[str], path: Path
) -> NDArray[np.float64]:
    """Return scalar properties as the columns (rows, names) of an array."""
    try:
        if element is None:
            raise KeyError("vertex")
        found = [element.scalars[name] for name in names]
    except KeyError as error:
        raise MeshError(f"{path}: no vertices with x, y and z") from error
    with np.errstate(invalid="ignore"):  # NaN is refused by who needs a number
        return np.stack([values.astype(np.float64) for values in found], axis=1)
