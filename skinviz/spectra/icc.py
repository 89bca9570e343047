"""ICC profiles with primaries and curves, from their bytes.

Pillow's colour management works on 8-bit pictures; here the numbers are wanted. What
does not belong here: look-up tables, and what is done with the numbers.

References
----------
.. [1] ICC.1:2022, Image technology colour management (profile version 4.4).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.adaptation import BRADFORD, von_kries
from skinviz.spectra.curves import Curve, PowerCurve, TableCurve

Array = NDArray[np.float64]

LARGEST_PROFILE = 2**26
"""That is read. [bytes]"""

_MOST_TAGS = 1000
_D50 = np.array([0.9642, 1.0, 0.8249])  # of the connection space
_WHITE_TO = 0.1  # by which primaries may add to another Y than 1
_NEEDED = ("rXYZ", "gXYZ", "bXYZ", "rTRC", "gTRC", "bTRC")
_TABLES = ("A2B0", "A2B1", "A2B2", "D2B0", "D2B1")
# How many numbers each function type of a parametric curve has.
_PARAMETERS = (1, 3, 4, 5, 7)


@dataclass(frozen=True, eq=False)
class Profile:
    """What a profile says of a display.

    Attributes
    ----------
    name : str
        Its description, or "".
    primaries : (3, 3) ndarray
        XYZ that it shows, in columns of red, green and blue, white at about Y = 1.
    curves : tuple of 3 Curve
        Encoded value to light.
    """

    name: str
    primaries: Array
    curves: tuple[Curve, Curve, Curve]


def parse_profile(content: bytes, where: str) -> Profile:
    """Return what a profile's bytes say, or raise ``DataError`` that names the file."""
    try:
        _require_rgb(content)
        tags = _tags(content)
        missing = [tag for tag in _NEEDED if tag not in tags]
        if missing:
            tables = any(tag in tags for tag in _TABLES)
            raise DataError(
                f"has no {', '.join(missing)}"
                + (" but look-up tables" if tables else "")
                + "; a profile with primaries and curves (matrix/TRC) is expected"
            )
        primaries = np.stack([_xyz(tags[tag], tag) for tag in _NEEDED[:3]], axis=1)
        _require_white(primaries)
        red, green, blue = (_curve(tags[tag], tag) for tag in _NEEDED[3:])
        undone = np.asarray(np.linalg.inv(_to_d50(content, tags)) @ primaries)
        return Profile(_name(tags.get("desc", b"")), undone, (red, green, blue))
    except (DataError, ArgumentError) as error:
        raise DataError(f"{where}: the ICC profile {error}") from error


def _require_rgb(content: bytes) -> None:
    """Refuse what is no whole profile of an RGB device with XYZ behind it."""
    if len(content) < 132 or content[36:40] != b"acsp":
        raise DataError("is none: it has no header with the mark 'acsp'")
    (size,) = struct.unpack_from(">I", content)
    if size > len(content):
        raise DataError(f"is cut off: {len(content)} bytes of {size}")
    for at, expected, what in (
        (12, (b"mntr", b"scnr", b"spac"), "class"),
        (16, (b"RGB ",), "colour space"),
        (20, (b"XYZ ",), "connection space"),
    ):
        found = content[at : at + 4]
        if found not in expected:
            known = " or ".join(_text(word) for word in expected)
            raise DataError(f"has the {what} {_text(found)!r}; expected {known}")


def _tags(content: bytes) -> dict[str, bytes]:
    """Return the data of each tag, of a repeated one the first."""
    (count,) = struct.unpack_from(">I", content, 128)
    if count > _MOST_TAGS or 132 + 12 * count > len(content):
        raise DataError(f"declares {count} tags, which do not fit; it is broken")
    tags: dict[str, bytes] = {}
    for i in range(count):
        name, offset, size = struct.unpack_from(">4sII", content, 132 + 12 * i)
        if offset + size > len(content):
            raise DataError(f"has the tag {_text(name)!r} beyond its end; it is broken")
        tags.setdefault(_text(name), content[offset : offset + size])
    return tags


def _fixed(data: bytes, kind: bytes, count: int, tag: str) -> Array:
    """Return the numbers, in 1/65536, of a tag that must be of a kind."""
    if data[:4] != kind or len(data) < 8 + 4 * count:
        raise DataError(
            f"has in {tag} {_text(data[:4])!r} of {len(data)} bytes; expected "
            f"{_text(kind)!r} with {count} numbers"
        )
    return np.frombuffer(data, ">i4", count, 8) / 65536.0


def _xyz(data: bytes, tag: str) -> Array:
    """Return a tag's XYZ (3,)."""
    return _fixed(data, b"XYZ ", 3, tag)


def _require_white(primaries: Array) -> None:
    """Refuse primaries that do not add to a white of Y = 1."""
    white = float(primaries[1].sum())
    if abs(white - 1) > _WHITE_TO:
        raise DataError(f"has primaries that add to Y = {white:g}; expected 1")


def _to_d50(content: bytes, tags: dict[str, bytes]) -> Array:
    """Return the matrix (3, 3) by which colours were taken to white D50.

    A display's of version 2 may keep its own white instead, adapted as Bradford does.
    """
    if "chad" in tags:
        matrix = _fixed(tags["chad"], b"sf32", 9, "chad").reshape(3, 3)
        if abs(np.linalg.det(matrix)) < 1e-3:
            raise DataError("has in chad a matrix that cannot be undone")
        return matrix
    if content[8] < 4 and content[12:16] == b"mntr" and "wtpt" in tags:
        white = _xyz(tags["wtpt"], "wtpt")
        if white.min() <= 0.01:
            raise DataError(f"has the white {white.tolist()}, which is none")
        return von_kries(white, _D50, BRADFORD)
    return np.eye(3)


def _curve(data: bytes, tag: str) -> Curve:
    """Return a tag's curve."""
    try:
        if data[:4] == b"curv" and len(data) >= 12:
            return _table_curve(data, tag)
        if data[:4] == b"para" and len(data) >= 12:
            return _parametric_curve(data, tag)
    except ArgumentError as error:
        raise DataError(f"has in {tag} no curve of a display: {error}") from error
    raise DataError(
        f"has in {tag} {_text(data[:4])!r} of {len(data)} bytes; expected 'curv' or "
        "'para'"
    )


def _table_curve(data: bytes, tag: str) -> Curve:
    """Return a curve of equidistant points, or of one gamma, or none."""
    (count,) = struct.unpack_from(">I", data, 8)
    if 12 + 2 * count > len(data):
        raise DataError(f"has in {tag} {len(data)} bytes for {count} points")
    points = np.frombuffer(data, ">u2", count, 12)
    if count == 0:
        return PowerCurve(1.0)
    if count == 1:
        return PowerCurve(points[0] / 256.0)
    return TableCurve(np.linspace(0.0, 1.0, count), points / 65535.0)


def _parametric_curve(data: bytes, tag: str) -> Curve:
    """Return a curve given by a function of few numbers."""
    (kind,) = struct.unpack_from(">H", data, 8)
    if kind >= len(_PARAMETERS):
        raise DataError(f"has in {tag} a function of type {kind}; 0 to 4 are known")
    count = _PARAMETERS[kind]
    if len(data) < 12 + 4 * count:
        raise DataError(f"has in {tag} {len(data)} bytes for {count} numbers")
    numbers = np.frombuffer(data, ">i4", count, 12) / 65536.0
    g, a, b, c, d, e, f = (float(x) for x in np.pad(numbers, (0, 7 - count)))
    if kind == 0:
        return PowerCurve(g)
    if kind in (1, 2):  # flat below the point at which the power begins
        if a == 0:
            raise DataError(f"has in {tag} a function that divides by 0")
        return PowerCurve(g, a, b, 0.0, -b / a, c, c)
    return PowerCurve(g, a, b, c, d, e, f)


def _name(data: bytes) -> str:
    """Return a description, of either version, or "" if it cannot be read."""
    text = ""
    if data[:4] == b"desc" and len(data) >= 12:
        (count,) = struct.unpack_from(">I", data, 8)
        text = data[12 : 12 + count].decode("latin-1")
    elif data[:4] == b"mluc" and len(data) >= 28:
        size, offset = struct.unpack_from(">II", data, 20)
        text = data[offset : offset + size].decode("utf-16-be", "replace")
    return "".join(c for c in text.split("\0")[0] if c.isprintable()).strip()[:100]


def _text(word: bytes) -> str:
    """Return four bytes as text."""
    return word.decode("latin-1")
