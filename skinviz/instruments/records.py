"""What the records of a session's log must have, whoever wrote them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from skinviz.errors import DataError

_WHOLE, _NUMBER = (int,), (int, float)
_TAKEN: dict[str, tuple[type, ...]] = {
    "t": _NUMBER,
    "segment": _WHOLE,
    "step": _WHOLE,
    "repeat": _WHOLE,
}
_KEYS: dict[str, dict[str, tuple[type, ...]]] = {
    "header": {
        "utc": (str,),
        "plan": (dict,),
        "certificate": (dict,),
        "meter": (dict,),
    },
    "grid": {"grid": _WHOLE, "wavelengths": (list,)},
    "reading": {**_TAKEN, "begun": _NUMBER, "grid": _WHOLE, "radiance": (list,)},
    "dark": _TAKEN,
    "resume": {"t": _NUMBER, "segment": _WHOLE, "torn": _WHOLE},
}
_METER = ("maker", "model", "serial")


def require_records(file: Path, records: Iterable[Mapping[str, Any]]) -> None:
    """Refuse records that lack what is read of them, or readings without their grid.

    Kinds that are not known here are none of our business.

    Raises
    ------
    DataError
        That names the line.
    """
    sizes: dict[int, int] = {}
    for at, record in enumerate(records, start=1):
        lack = _lack(record, sizes)
        if lack:
            raise DataError(
                f"{file} line {at}: {lack}; read the log with the version that wrote it"
            )
        if record["kind"] == "grid":
            sizes[record["grid"]] = len(record["wavelengths"])


def _lack(record: Mapping[str, Any], sizes: Mapping[int, int]) -> str:
    """Return what a record lacks after grids of these sizes, "" if nothing."""
    kind = record.get("kind")
    if not isinstance(kind, str):
        return "it says no kind"
    for key, types in _KEYS.get(kind, {}).items():
        if not isinstance(record.get(key), types):
            return f"its {kind} has no right {key!r}"
    if kind == "header":
        if not all(isinstance(record["meter"].get(key), str) for key in _METER):
            return f"its meter lacks {', '.join(_METER)}"
    elif kind == "reading" and sizes.get(record["grid"]) != len(record["radiance"]):
        return "its reading is on a grid that was not told before"
    return ""
