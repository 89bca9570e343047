"""How a picture was made, as text that any picture file can hold."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from skinviz import __version__
from skinviz.errors import ArgumentError

KEY = "skinviz"
"""What the text is called where a format has names for its texts."""

SOFTWARE = f"skinviz {__version__}"
"""What formats name as the program that wrote them."""

_AT_MOST = 2**20  # characters; a scene has some thousands
_TITLE = "Skin rendered by skinviz"
_SHOWN = 200  # characters of a title; the JSON has all of it


def as_json(metadata: dict[str, Any], file: Path) -> str:
    """Return metadata as JSON in ASCII, on one line.

    Raises
    ------
    ArgumentError
        If it has what JSON cannot hold, NaN among it, or is longer than 1 MiB. The
        message names the entry.
    """
    for where, value in _unfit(metadata, "metadata"):
        raise ArgumentError(
            f"{file}: {where} is {str(value)[:40]} ({type(value).__name__}), which "
            "JSON cannot hold; give text, finite numbers, lists, or dicts with text as "
            "keys"
        )
    text = json.dumps(metadata, allow_nan=False)
    if len(text) > _AT_MOST:
        raise ArgumentError(
            f"{file}: the metadata are {len(text) / 2**20:.1f} MiB, at most of it in "
            f"{_heaviest(metadata)}; expected at most {_AT_MOST // 2**20} MiB: name a "
            "file instead of what is in it"
        )
    return text


def title(metadata: dict[str, Any]) -> str:
    """Return the title, on one line of characters that can be shown."""
    return _one_line(metadata.get("title")) or _TITLE


def caption(metadata: dict[str, Any]) -> str:
    """Return the title and what the spectra are, on one line."""
    units = metadata.get("units")
    unit = _one_line(units.get("radiance")) if isinstance(units, dict) else ""
    return f"{title(metadata)}; spectral radiance{f' [{unit}]' if unit else ''}"


def _one_line(value: object) -> str:
    """Return text without what cannot be shown, not too long; "" for none."""
    shown = (c if c.isprintable() else " " for c in str(value or ""))
    text = " ".join("".join(shown).split())
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"


def _unfit(value: object, where: str) -> Iterator[tuple[str, object]]:
    """Yield the entries that JSON cannot hold, and where they are."""
    if not _holds(value):
        yield where, value
    elif isinstance(value, dict):
        for key, item in value.items():
            if not isinstance(key, str):
                yield f"a key of {where}", key
            yield from _unfit(item, f"{where}.{key}")
    elif isinstance(value, list | tuple):
        for i, item in enumerate(value):
            yield from _unfit(item, f"{where}[{i}]")


def _holds(value: object) -> bool:
    """Return whether JSON has such values, whatever is in them."""
    if isinstance(value, float):
        return math.isfinite(value)
    return value is None or isinstance(value, str | int | dict | list | tuple)


def _heaviest(metadata: dict[str, Any]) -> str:
    """Return where most of the text is."""
    where, value = "metadata", metadata
    while isinstance(value, dict) and value:
        sizes = {key: len(json.dumps(item)) for key, item in value.items()}
        key = max(sizes, key=lambda name: sizes[name])
        where, value = f"{where}.{key}", value[key]
    return where
