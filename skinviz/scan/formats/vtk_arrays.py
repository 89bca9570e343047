"""Arrays of VTK's XML files: text, base64 or raw bytes, compressed or not.

Sizes that a file states are checked against its bytes before they are used, and what
all arrays expand to is bounded, so that a small file cannot ask for the memory.
"""

from __future__ import annotations

import base64
import binascii
import lzma
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

_TYPES = {
    **{f"Int{8 * n}": f"i{n}" for n in (1, 2, 4, 8)},
    **{f"UInt{8 * n}": f"u{n}" for n in (1, 2, 4, 8)},
    "Float32": "f4",
    "Float64": "f8",
    "String": "u1",
}
_FREELY = 2**28  # bytes that any file may expand to, and then as much a byte:
_EXPANSION = 50


class BrokenArrayError(Exception):
    """An array is not what the file says; told of the file by the reader."""


@dataclass
class ArrayReader:
    """The arrays of one file.

    Attributes
    ----------
    order : str
        ``<`` or ``>``, of the bytes.
    header : str
        Kind of the numbers that state sizes.
    compressor : str
        VTK's name of the compression; empty for none.
    appended : bytes
        What the file has after its XML.
    encoded : bool
        Whether that is base64.
    room : int
        Bytes that the arrays may yet expand to.
    """

    order: str
    header: str
    compressor: str
    appended: bytes
    encoded: bool
    file_size: int
    room: int = field(init=False)

    def __post_init__(self) -> None:
        """Set the bound from the file's size."""
        self.room = _FREELY + _EXPANSION * self.file_size

    def read(self, element: Element) -> NDArray[Any]:
        """Return an array (rows,) or (rows, components) of the file."""
        name = element.get("Name", "")
        kind = _TYPES.get(element.get("type", ""))
        if kind is None:
            raise BrokenArrayError(f"array {name!r} has an unknown type")
        values = self._values(element, np.dtype(self.order + kind))
        self.room -= values.nbytes
        components = element.get("NumberOfComponents", "1")
        if not components.isdecimal() or not 0 < int(components[:9]) <= 10**6:
            raise BrokenArrayError(f"array {name!r} has no valid NumberOfComponents")
        n = int(components)
        if values.size % n:
            raise BrokenArrayError(f"array {name!r} is not a whole number of rows")
        values = values.astype(values.dtype.newbyteorder("="))
        return values.reshape(-1, n) if n > 1 else values

    def text(self, element: Element) -> str:
        """Return the first string of an array of strings."""
        content = self._values(element, np.dtype("u1")).tobytes()
        return content.split(b"\0")[0].decode("utf-8", errors="replace")

    def _values(self, element: Element, kind: np.dtype[Any]) -> NDArray[Any]:
        """Return the numbers of an array, flat."""
        way = element.get("format", "")
        if way == "ascii":
            return _from_text(element.text or "", kind)
        if way == "binary":
            stored = "".join((element.text or "").split()).encode("ascii", "replace")
            content = self._content(_Base64(stored))
        elif way == "appended":
            offset = element.get("offset", "")
            if not offset.isdecimal() or int(offset[:19]) > len(self.appended):
                raise BrokenArrayError("an array begins beyond the end of the file")
            rest = self.appended[int(offset) :]
            content = self._content(_Base64(rest) if self.encoded else _Raw(rest))
        else:
            raise BrokenArrayError(f"an array of unknown format {way!r}")
        if len(content) % kind.itemsize:
            raise BrokenArrayError("an array is not a whole number of values")
        return np.frombuffer(content, kind)

    def _content(self, source: _Base64 | _Raw) -> bytes:
        """Return an array's bytes, expanded."""
        size = np.dtype(self.header).itemsize
        if not self.compressor:
            (length,) = self._sizes(source.peek(size), 1)
            self._require_room(length, source.room)
            return source.peek(size + length)[size:]
        if self.compressor not in _EXPANDERS:
            raise BrokenArrayError(
                f"compressed by {self.compressor}; write it with zlib or uncompressed"
            )
        n_blocks, block, last = self._sizes(source.peek(3 * size), 3)
        if n_blocks * size > source.room:
            raise BrokenArrayError("an array has more blocks than the file has bytes")
        if n_blocks == 0:
            return b""
        whole = n_blocks - (1 if last else 0)
        self._require_room(whole * block + last, self.room)
        head = source.take((3 + n_blocks) * size)
        packed = self._sizes(head[3 * size :], n_blocks)
        content = source.peek(sum(packed)) if sum(packed) <= source.room else b""
        return self._expanded(content, packed, [block] * whole + [last] * bool(last))

    def _expanded(self, content: bytes, packed: list[int], sizes: list[int]) -> bytes:
        """Return the bytes of all blocks."""
        expand = _EXPANDERS[self.compressor]
        parts, at = [], 0
        for stored, size in zip(packed, sizes, strict=True):
            try:
                part = expand(content[at : at + stored], size + 1)
            except (zlib.error, lzma.LZMAError, EOFError) as error:
                raise BrokenArrayError(
                    f"a compressed block is broken: {error}"
                ) from error
            if len(part) != size:
                raise BrokenArrayError("a compressed block has not the size it states")
            parts.append(part)
            at += stored
        return b"".join(parts)

    def _sizes(self, content: bytes, count: int) -> list[int]:
        """Return the sizes that a head of bytes states."""
        kind = np.dtype(self.order + self.header)
        if len(content) < count * kind.itemsize:
            raise BrokenArrayError("an array is cut short")
        return [int(n) for n in np.frombuffer(content, kind, count)]

    def _require_room(self, needed: int, room: int) -> None:
        """Refuse more bytes than there are, or than a file may expand to."""
        if needed > min(room, self.room):
            raise BrokenArrayError(
                f"an array states {needed} bytes, more than the file can hold"
            )


class _Raw:
    """Bytes as they are."""

    def __init__(self, content: bytes) -> None:
        self._content = content

    @property
    def room(self) -> int:
        """Bytes left."""
        return len(self._content)

    def peek(self, count: int) -> bytes:
        """Return the next bytes."""
        return self._content[:count]

    def take(self, count: int) -> bytes:
        """Return the next bytes and pass over them."""
        taken, self._content = self._content[:count], self._content[count:]
        return taken


class _Base64(_Raw):
    """Bytes in base64; each piece that is taken was encoded alone."""

    @property
    def room(self) -> int:
        """Bytes left, or a few more."""
        return len(self._content) * 3 // 4 + 3

    def peek(self, count: int) -> bytes:
        """Return the next bytes."""
        try:
            return base64.b64decode(self._content[: _encoded(count)])[:count]
        except binascii.Error as error:
            raise BrokenArrayError(f"an array is no base64: {error}") from error

    def take(self, count: int) -> bytes:
        """Return the next bytes and pass over them."""
        taken = self.peek(count)
        self._content = self._content[_encoded(count) :]
        return taken


def _encoded(count: int) -> int:
    """Return how many characters of base64 hold a number of bytes."""
    return 4 * -(-count // 3)


def _from_text(text: str, kind: np.dtype[Any]) -> NDArray[Any]:
    """Return numbers that are written as text."""
    try:
        return np.array(text.split(), dtype=kind)
    except (ValueError, OverflowError) as error:
        raise BrokenArrayError(f"an array of numbers holds none: {error}") from error


def _zlib(content: bytes, size: int) -> bytes:
    return zlib.decompressobj().decompress(content, size)


def _lzma(content: bytes, size: int) -> bytes:
    return lzma.LZMADecompressor(memlimit=_FREELY).decompress(content, size)


_EXPANDERS: dict[str, Callable[[bytes, int], bytes]] = {
    "vtkZLibDataCompressor": _zlib,
    "vtkLZMADataCompressor": _lzma,
}
