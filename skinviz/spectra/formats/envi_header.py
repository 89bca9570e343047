"""The text header of ENVI files: its fields, and numbers in them."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

from skinviz.errors import DataError
from skinviz.spectra.formats.raw import number, read_text

_AT_MOST = 2**24  # bytes


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
