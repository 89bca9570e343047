"""The text header of ENVI files: its fields, numbers in them, and its writing."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Collection, Mapping
from pathlib import Path

from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.formats.raw import number, read_text

PICTURE_FIELD = "skinviz picture"
"""Field of a header in which a computed picture says how it was made."""

_AT_MOST = 2**24  # bytes
_LINE = 88  # characters; some readers take no more than 10,000


def read_header(file: Path) -> dict[str, str]:
    """Return the fields of the header, names in lower case, braces taken off."""
    text = read_text(file, "an ENVI header", at_most=_AT_MOST, fallback="latin-1")
    lines = iter(text.splitlines())
    if not next(lines, "").strip().startswith("ENVI"):
        raise DataError(f"{file}: the first line is not ENVI, so it is no ENVI header")
    fields = {}
    for line in lines:
        key, mark, value = line.partition("=")
        if not mark or line.startswith(";"):
            continue
        parts = [value.strip()]
        if parts[0].startswith("{"):
            while "}" not in parts[-1]:
                if (more := next(lines, None)) is None:
                    raise DataError(
                        f"{file}: the brace after '{key.strip()[:40]}' is open"
                    )
                parts.append(more)
        name = " ".join(key.lower().split())
        fields[name] = "\n".join(parts).partition("}")[0].removeprefix("{").strip()
    return fields


def field(header: dict[str, str], name: str, file: Path) -> str:
    """Return a field that the header must have."""
    if name not in header:
        raise DataError(f"{file}: the header has no {name!r}")
    return header[name]


def choice(
    header: dict[str, str], name: str, choices: Collection[str], file: Path
) -> str:
    """Return a field that is one of some words."""
    value = field(header, name, file).lower()
    if value not in choices:
        raise DataError(
            f"{file}: '{name}' is {value[:40]!r}; expected one of {', '.join(choices)}"
        )
    return value


def count(header: dict[str, str], name: str, file: Path) -> int:
    """Return a field that is a whole number."""
    value = field(header, name, file)
    if not re.fullmatch(r"[0-9]{1,18}", value):
        raise DataError(f"{file}: '{name}' is {value[:40]!r}; expected a whole number")
    return int(value)


def numbers(header: dict[str, str], name: str, bands: int, file: Path) -> list[float]:
    """Return a list with one number a band."""
    cells = header[name].split(",")
    if len(cells) != bands:
        raise DataError(
            f"{file}: {name!r} has {len(cells)} values for {bands} bands; expected one "
            "each"
        )
    return [number(cell.strip(), f"{file}, {name!r}") for cell in cells]


def header_text(
    shape: tuple[int, int, int],
    interleave: str,
    fields: Mapping[str, object],
    file: Path,
) -> str:
    """Return the header of a float32 file, least significant byte first.

    Parameters
    ----------
    shape : tuple of int
        Lines, samples and bands.
    interleave : str
        The stored order, such as ``bip``.
    fields : mapping
        What else it says; lists, and ``description``, are put in braces.
    file : Path
        The header's name, for messages.

    Raises
    ------
    ArgumentError
        If a field has a brace, by which a list would end too early.
    """
    lines, samples, bands = shape
    layout = {
        "description": "",
        "samples": samples,
        "lines": lines,
        "bands": bands,
        "header offset": 0,
        "file type": "ENVI Standard",
        "data type": 4,
        "interleave": interleave,
        "byte order": 0,
    }
    told = {
        key: _shown(key, value, file) for key, value in {**layout, **fields}.items()
    }
    return "ENVI\n" + "".join(f"{key} = {value}\n" for key, value in told.items())


def _shown(key: str, value: object, file: Path) -> str:
    """Return a field's value as it is written."""
    several = isinstance(value, list)
    text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    if "{" in text or "}" in text:
        raise ArgumentError(f"{file}: {key!r} has a brace, which .hdr cannot hold")
    if key == "description":
        return f"{{{text}}}"
    if not several:
        return text
    return f"{{{textwrap.fill(text, _LINE, break_on_hyphens=False)}}}"
