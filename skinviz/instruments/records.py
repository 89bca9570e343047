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
        kind = record.get("kind")
        for key, types in _KEYS.get(kind, {}).items() if isinstance(kind, str) else ():
            if not isinstance(record.get(key), types):
                raise _other(file, at, f"its {kind} has no right {key!r}")
        if kind == "header":
            if not all(isinstance(record["meter"].get(key), str) for key in _METER):
                raise _other(file, at, f"its meter lacks {', '.join(_METER)}")
        elif kind == "grid":
            sizes[record["grid"]] = len(record["wavelengths"])
        elif kind == "reading" and sizes.get(record["grid"]) != len(record["radiance"]):
            raise _other(file, at, "its reading is on a grid that was not told before")
        elif not isinstance(kind, str):
            raise _other(file, at, "it says no kind")


def _other(file: Path, at: int, what: str) -> DataError:
    """Return the error of a line that another program must have written."""
    return DataError(
        f"{file} line {at}: {what}; read the log with the version that wrote it"
    )
