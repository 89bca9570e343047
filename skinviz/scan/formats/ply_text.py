"""Rows of a PLY file in text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan.formats.content import Lines, is_number, shown, split_lines, table
from skinviz.scan.formats.ply_header import Element, Header, Lists, Property


def text_elements(body: bytes, header: Header, path: Path) -> dict[str, Element]:
    """Return the elements of a file in text: a line a row."""
    kept = [
        (number, line.strip())
        for number, line in enumerate(
            split_lines(body.decode("utf-8", errors="replace")), header.n_lines + 1
        )
        if line.strip()
    ]
    lines = Lines(path, [text for _, text in kept], [number for number, _ in kept])
    elements, at = {}, 0
    for declared in header.elements:
        if not declared.properties:
            continue
        if declared.count > len(lines) - at:
            raise MeshError(
                f"{path}: not a whole PLY file: the header says {declared.count} rows "
                f"of {declared.name!r}, the file has {len(lines) - at} lines left"
            )
        part = lines.part(at, at + declared.count)
        at += declared.count
        rows = _list_rows if declared.has_lists else _scalar_rows
        elements[declared.name] = rows(part, declared.properties)
    if at < len(lines):
        raise lines.fault(at, "more rows than the header says; its counts are wrong")
    return elements


def _scalar_rows(part: Lines, properties: tuple[Property, ...]) -> Element:
    """Return an element without lists."""
    values = table(part, columns=len(properties), finite=False)
    names = [p.name for p in properties]
    return Element(len(part), dict(zip(names, values.T, strict=True)), {})


def _list_rows(part: Lines, properties: tuple[Property, ...]) -> Element:
    """Return an element with lists."""
    found: list[list[str]] = [[] for _ in properties]
    counts: list[list[int]] = [[] for _ in properties]
    for i in range(len(part)):
        _take_row(part, i, properties, found, counts)
    scalars: dict[str, NDArray[Any]] = {}
    lists: dict[str, Lists] = {}
    for p, words, lengths in zip(properties, found, counts, strict=True):
        numbers = _numbers(words, p, part)
        if p.length_kind is None:
            scalars[p.name] = numbers
        else:
            lists[p.name] = Lists(np.array(lengths, dtype=np.int64), numbers)
    return Element(len(part), scalars, lists)


def _take_row(
    part: Lines,
    index: int,
    properties: tuple[Property, ...],
    found: list[list[str]],
    counts: list[list[int]],
) -> None:
    """Add a row's words, and how many each property has, to the lists of them."""
    text = part.texts[index]
    words = text.split()
    at = 0
    for p, values, lengths in zip(properties, found, counts, strict=True):
        length = 1
        if p.length_kind is not None:
            word = words[at] if at < len(words) else ""
            length = int(word) if word.isdecimal() and len(word) < 10 else -1
            at += 1
        if length < 0 or at + length > len(words):
            raise part.fault(index, f"not as long as it says: {shown(text)}")
        values.extend(words[at : at + length])
        lengths.append(length)
        at += length
    if at < len(words):
        raise part.fault(index, f"longer than it says: {shown(text)}")


def _numbers(words: list[str], p: Property, part: Lines) -> NDArray[Any]:
    """Return words as numbers of a property's kind."""
    whole = p.kind[0] != "f"
    try:
        return np.array(words, dtype=np.int64 if whole else np.float64)
    except (ValueError, OverflowError) as error:
        valid = _is_whole if whole else is_number
        bad = next((w for w in words if not valid(w)), words[0])
        wanted = "whole numbers" if whole else "numbers"
        raise MeshError(
            f"{part.path}: not a valid PLY file: {p.name} should be {wanted}; got "
            f"{shown(bad)}"
        ) from error


def _is_whole(word: str) -> bool:
    """Return whether a word is a whole number of few enough digits."""
    return word.removeprefix("-").isdecimal() and len(word) < 19
