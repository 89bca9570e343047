"""The header of a PLY file: what it promises."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.formats.content import shown, split_lines

_KINDS = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Property:
    """A column of an element; with a ``length_kind`` it holds lists."""

    name: str
    kind: str
    length_kind: str | None = None


@dataclass(frozen=True)
class Declared:
    """An element as the header declares it."""

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def has_lists(self) -> bool:
        """Whether any property holds lists."""
        return any(p.length_kind for p in self.properties)

    @property
    def least_row(self) -> int:
        """The fewest bytes that a row can have."""
        return sum(np.dtype(p.length_kind or p.kind).itemsize for p in self.properties)


@dataclass(frozen=True)
class Lists:
    """A property whose rows are lists, one after the other.

    Attributes
    ----------
    counts : (rows,) ndarray of int64
        Length of each list.
    values : (sum of counts,) ndarray
        What they hold.
    """

    counts: NDArray[np.int64]
    values: NDArray[Any]


@dataclass(frozen=True)
class Element:
    """Rows of one kind: its scalar and its list properties by name."""

    count: int
    scalars: Mapping[str, NDArray[Any]]
    lists: Mapping[str, Lists]


@dataclass(frozen=True)
class Header:
    """What a header promises.

    Attributes
    ----------
    order : str
        ``<`` or ``>`` of binary numbers; empty for text.
    elements : tuple of Declared
        In their order.
    comments, obj_info : tuple of str
        What these lines say.
    n_lines : int
        Lines of the header, its last one included.
    """

    order: str
    elements: tuple[Declared, ...]
    comments: tuple[str, ...]
    obj_info: tuple[str, ...]
    n_lines: int


def parse_header(content: bytes, path: Path) -> tuple[Header, int]:
    """Return what a header promises, and where what follows it begins."""
    head, body = _split(content, path)
    texts = split_lines(head.decode("utf-8", errors="replace"))
    orders: list[str] = []
    elements: list[Declared] = []
    said: dict[str, list[str]] = {"comment": [], "obj_info": []}
    for number, line in enumerate(texts[1:], start=2):
        words = line.split()
        keyword = words[0] if words else "comment"
        if keyword in said:
            said[keyword].append(line.strip()[len(keyword) :].strip())
        elif not _declares(words, orders, elements):
            raise MeshError(
                f"{path} line {number}: not a valid PLY file: {shown(line)} is no line "
                "of a header"
            )
    if len(orders) != 1:
        raise MeshError(f"{path}: not a valid PLY file: {len(orders)} lines 'format'")
    _require_distinct([e.name for e in elements], path)
    for element in elements:
        _require_distinct([p.name for p in element.properties], path)
    return (
        Header(
            orders[0],
            tuple(elements),
            tuple(said["comment"]),
            tuple(said["obj_info"]),
            len(texts) + 1,
        ),
        body,
    )


def _declares(words: list[str], orders: list[str], elements: list[Declared]) -> bool:
    """Note what a line declares; return whether it is a valid one."""
    if words[0] == "format" and len(words) == 3 and words[1] in _ORDERS:
        orders.append(_ORDERS[words[1]])
    elif words[0] == "element" and len(words) == 3 and words[2].isdecimal():
        elements.append(Declared(words[1], int(words[2][:19]), ()))
    elif words[0] == "property" and elements and (found := _property(words)):
        last = elements[-1]
        elements[-1] = Declared(last.name, last.count, (*last.properties, found))
    else:
        return False
    return True


def _property(words: list[str]) -> Property | None:
    """Return the property that a header's line declares, if it is valid."""
    kinds = [_KINDS.get(word) for word in words[1:]]
    if len(words) == 3 and kinds[0]:
        return Property(words[2], kinds[0])
    if len(words) == 5 and words[1] == "list" and kinds[1] and kinds[2]:
        whole = not kinds[1].startswith("f")
        return Property(words[4], kinds[2], kinds[1]) if whole else None
    return None


def _require_distinct(names: list[str], path: Path) -> None:
    """Refuse two elements, or two properties of one, of the same name."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise MeshError(f"{path}: not a valid PLY file: two are called {name!r}")
        seen.add(name)


def _split(content: bytes, path: Path) -> tuple[bytes, int]:
    """Return the header's bytes and where what follows it begins."""
    if content[:3] != b"ply" or content[3:4] not in (b"\n", b"\r"):
        raise MeshError(f"{path}: not a valid PLY file: it does not begin with 'ply'")
    ending = b"\r\n" if content[3:5] == b"\r\n" else content[3:4]
    mark = ending + b"end_header"
    end = content.find(mark)
    if end < 0:
        raise MeshError(
            f"{path}: not a whole PLY file: its header has no line 'end_header'"
        )
    after = content.find(ending, end + len(mark))
    if after < 0 or content[end + len(mark) : after].strip():
        raise MeshError(f"{path}: not a whole PLY file: nothing follows its header")
    return content[:end], after + len(ending)
