"""Rows of a binary PLY file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.formats.ply_header import Declared, Element, Header, Lists


def binary_elements(
    content: bytes, offset: int, header: Header, path: Path
) -> dict[str, Element]:
    """Return the elements of a binary file, whose rows begin at an offset."""
    elements = {}
    for declared in header.elements:
        room = len(content) - offset
        row = declared.least_row
        if declared.count * row > room:
            raise _too_many(declared, room // row, path)
        if declared.has_lists:
            element, offset = _list_rows(content, offset, declared, header.order, path)
        else:
            element, offset = _fixed_rows(content, offset, declared, header.order)
        elements[declared.name] = element
    if content[offset:].strip(b"\r\n\t \0"):
        raise MeshError(
            f"{path}: not a valid PLY file: {len(content) - offset} bytes follow what "
            "the header says; its counts are wrong"
        )
    return elements


def _too_many(declared: Declared, room: int, path: Path) -> MeshError:
    """Return the error of more rows than the file has bytes for."""
    return MeshError(
        f"{path}: not a whole PLY file: the header says {declared.count} rows of "
        f"{declared.name!r}, the file has room for {room}"
    )


def _fixed_rows(
    content: bytes, offset: int, declared: Declared, order: str
) -> tuple[Element, int]:
    """Return an element without lists, and where the next one begins."""
    if not declared.properties:
        return Element(declared.count, {}, {}), offset
    kind = np.dtype([(p.name, order + p.kind) for p in declared.properties])
    rows = np.frombuffer(content, kind, declared.count, offset)
    scalars = {p.name: rows[p.name] for p in declared.properties}
    end = offset + declared.count * kind.itemsize
    return Element(declared.count, scalars, {}), end


def _list_rows(
    content: bytes, offset: int, declared: Declared, order: str, path: Path
) -> tuple[Element, int]:
    """Return an element with lists, and where the next one begins."""
    equal = _equal_lists(content, offset, declared, order)
    if equal is not None:
        return equal
    try:
        starts, lengths, end = _walk(content, offset, declared, order)
    except IndexError as error:
        raise MeshError(
            f"{path}: not a whole PLY file: it ends before the {declared.count} rows "
            f"of {declared.name!r} that the header says"
        ) from error
    scalars, lists = {}, {}
    data = np.frombuffer(content, np.uint8)
    for p, start, length in zip(declared.properties, starts, lengths, strict=True):
        values = _gather(data, start, length, np.dtype(order + p.kind))
        if p.length_kind is None:
            scalars[p.name] = values
        else:
            lists[p.name] = Lists(length, values)
    return Element(declared.count, scalars, lists), end


def _equal_lists(
    content: bytes, offset: int, declared: Declared, order: str
) -> tuple[Element, int] | None:
    """Return an element whose lists are as long in every row, or None."""
    row = _first_row(content, offset, declared, order)
    if row is None or not 0 < declared.count * row.itemsize <= len(content) - offset:
        return None
    rows = np.frombuffer(content, row, declared.count, offset)
    scalars: dict[str, NDArray[Any]] = {}
    lists: dict[str, Lists] = {}
    for i, p in enumerate(declared.properties):
        values = rows[f"v{i}"].reshape(-1)
        if p.length_kind is None:
            scalars[p.name] = values
            continue
        lengths = rows[f"n{i}"].astype(np.int64)
        if (lengths != lengths[0]).any():
            return None
        lists[p.name] = Lists(lengths, values)
    end = offset + declared.count * row.itemsize
    return Element(declared.count, scalars, lists), end


def _first_row(
    content: bytes, offset: int, declared: Declared, order: str
) -> np.dtype[Any] | None:
    """Return the layout of the first row, or None if the file ends in it."""
    fields: list[Any] = []
    at = offset
    for i, p in enumerate(declared.properties):
        length = 1
        if p.length_kind is not None:
            kind = np.dtype(order + p.length_kind)
            if at + kind.itemsize > len(content):
                return None
            length = int(np.frombuffer(content, kind, 1, at)[0])
            at += kind.itemsize
            fields.append((f"n{i}", kind))
        at += length * np.dtype(p.kind).itemsize
        if length < 0 or at > len(content):
            return None
        fields.append((f"v{i}", order + p.kind, (length,)))
    return np.dtype(fields)


def _walk(
    content: bytes, offset: int, declared: Declared, order: str
) -> tuple[list[NDArray[np.int64]], list[NDArray[np.int64]], int]:
    """Return where each property of each row begins and how long it is."""
    ends: Literal["big", "little"] = "big" if order == ">" else "little"
    starts: list[list[int]] = [[] for _ in declared.properties]
    lengths: list[list[int]] = [[] for _ in declared.properties]
    each = [
        (
            np.dtype(p.kind).itemsize,
            np.dtype(p.length_kind).itemsize if p.length_kind else 0,
            bool(p.length_kind and p.length_kind[0] == "i"),
            begin,
            long,
        )
        for p, begin, long in zip(declared.properties, starts, lengths, strict=True)
    ]
    room, at = len(content), offset
    for _ in range(declared.count):
        for size, before, signed, begin, long in each:
            length = 1
            if before:
                head = content[at : at + before]
                length = int.from_bytes(head, ends, signed=signed)
                at += before
            begin.append(at)
            long.append(length)
            at += length * size
            if length < 0 or at > room:
                raise IndexError
    return (
        [np.array(s, dtype=np.int64) for s in starts],
        [np.array(n, dtype=np.int64) for n in lengths],
        at,
    )


def _gather(
    data: NDArray[np.uint8],
    starts: NDArray[np.int64],
    lengths: NDArray[np.int64],
    kind: np.dtype[Any],
) -> NDArray[Any]:
    """Return the values of lists that lie scattered in the bytes."""
    within = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    at = np.repeat(starts, lengths) + within * kind.itemsize
    scattered = data[at[:, None] + np.arange(kind.itemsize)]
    return np.asarray(scattered.reshape(-1).view(kind))
