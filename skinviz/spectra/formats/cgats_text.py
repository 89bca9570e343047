"""The text of CGATS: its lines, words and tables, whatever the fields mean."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from skinviz.errors import DataError
from skinviz.spectra.formats.raw import read_text

_AT_MOST = 2**26  # bytes
_TOKEN = re.compile(r'(?:"((?:[^"]|"")*)"|([^\s"]+))\s*')

_Row = tuple[int, list[str]]


@dataclass(frozen=True)
class Table:
    """A table of the file: what stood above it, its fields and its rows."""

    keywords: dict[str, str]
    fields: list[str]
    rows: list[_Row]


def read_lines(file: Path) -> list[str]:
    """Return the lines of a file, ended as on any system."""
    text = read_text(file, "CGATS text", at_most=_AT_MOST, fallback="cp1252")
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _tokens(line: str, where: str) -> list[str]:
    """Return the words and quoted texts of a line, up to a comment."""
    words: list[str] = []
    line, at = line.strip(), 0
    while at < len(line) and line[at] != "#":
        found = _TOKEN.match(line, at)
        if found is None:
            raise DataError(f"{where}: a quotation mark is not closed")
        quoted, bare = found.groups()
        words.append(bare if quoted is None else quoted.replace('""', '"'))
        at = found.end()
    return words


def tables_of(lines: list[str], file: Path) -> list[Table]:
    """Return the tables of the file in their order."""
    if not any(line.split() == ["BEGIN_DATA"] for line in lines):
        raise DataError(
            f"{file}: no line BEGIN_DATA, so it is no CGATS text; if it is a plain "
            "table of columns name it .csv"
        )
    rows = iter(
        [
            (at, cells)
            for at, line in enumerate(lines, start=1)
            if (cells := _tokens(line, f"{file} line {at}"))
        ]
    )
    keywords: dict[str, str] = {}
    fields: list[str] = []
    tables = []
    for _, (word, *values) in rows:
        if word == "BEGIN_DATA_FORMAT":
            fields = [c for _, r in _until("END_DATA_FORMAT", rows, file) for c in r]
        elif word == "BEGIN_DATA":
            body = list(_until("END_DATA", rows, file))
            tables.append(Table(dict(keywords), fields, body))
        elif values:
            keywords[word.upper()] = " ".join(values).strip()
    return tables


def _until(end: str, rows: Iterator[_Row], file: Path) -> Iterator[_Row]:
    """Yield the rows before the word that ends the block."""
    for at, cells in rows:
        if cells[0] == end:
            return
        yield at, cells
    raise DataError(f"{file}: {end} is missing; the file is cut off")
