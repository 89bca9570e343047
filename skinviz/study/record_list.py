"""Which records a study has, told one by one or in a table, and what of its people."""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skinviz._files import existing_file
from skinviz.errors import DataError
from skinviz.spectra.formats.raw import read_text

TRAITS = ("group", "sex", "age", "origin")
"""What is told of a subject, and is the same in all its records."""

FIELDS = ("subject", "site", "condition", "repeat", *TRAITS)
"""What names of files and labels can tell."""

COLUMNS = ("file", "label", *FIELDS)
"""What a table of records can tell."""

_AT_MOST = 2**26  # bytes of a table


@dataclass(frozen=True)
class Entry:
    """One record as the study lists it, before its file is read.

    Attributes
    ----------
    file : str
        In the study's folder.
    label : str
        Which spectrum of a file with several; "" if it has but one.
    subject, site, condition : str
        Whose, where, when; no condition is "".
    repeat : int
        1, 2, ...
    group, sex, age, origin : str
        Of the subject, "" where not told.
    """

    file: str = ""
    label: str = ""
    subject: str = ""
    site: str = ""
    condition: str = ""
    repeat: int = 1
    group: str = ""
    sex: str = ""
    age: str = ""
    origin: str = ""

    @property
    def key(self) -> tuple[str, str, str, int]:
        """What no other record may share."""
        return (self.subject, self.site, self.condition, self.repeat)


@dataclass(frozen=True)
class Listing:
    """The entries that a study lists, and those that tell too little, with the why."""

    entries: tuple[Entry, ...]
    passed: tuple[tuple[Entry, str], ...]


def listing_of(rows: Iterable[Mapping[str, Any]]) -> Listing:
    """Return the entries of records that are told by column.

    Parameters
    ----------
    rows : iterable of mapping
        Values by the names of ``COLUMNS``. A row without file, subject or site, or
        with a repeat that is no whole number, is passed over.

    Raises
    ------
    DataError
        If a column is unknown.
    """
    entries: list[Entry] = []
    passed: list[tuple[Entry, str]] = []
    for row in rows:
        for key in row:
            if key not in COLUMNS:
                raise DataError(
                    f"unknown column {key!r}; known are {', '.join(COLUMNS)}"
                )
        words: dict[str, Any] = {k: " ".join(str(v).split()) for k, v in row.items()}
        number = words.pop("repeat", "") or "1"
        entry = Entry(**words)
        lacking = [k for k in ("file", "subject", "site") if not getattr(entry, k)]
        if lacking:
            passed.append((entry, f"its {' and '.join(lacking)} is not told"))
        elif not (number.isascii() and number.isdigit() and int(number) > 0):
            passed.append((entry, f"its repeat must be 1, 2, ...; got {number!r}"))
        else:
            entries.append(dataclasses.replace(entry, repeat=int(number)))
    return Listing(tuple(entries), tuple(passed))


def table_of(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV or TSV table by the names in its first line.

    Raises
    ------
    DataError
        If the table cannot be read or is no table.
    """
    file = existing_file(path, DataError)
    text = read_text(file, "a table of records as CSV", at_most=_AT_MOST)
    lines = [
        (at, line)
        for at, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    if len(lines) < 2:
        raise DataError(f"{file}: a header and a line for each record are expected")
    mark = max("\t;,", key=lines[0][1].count)
    try:
        rows = list(csv.reader((line for _, line in lines), delimiter=mark))
    except csv.Error as error:
        raise DataError(f"{file}: not a CSV table: {error}") from error
    header = [cell.strip().lower() for cell in rows[0]]
    if len(set(header)) < len(header):
        raise DataError(f"{file}: two columns have the same name")
    for (at, _), cells in zip(lines, rows, strict=False):
        if len(cells) != len(header):
            raise DataError(
                f"{file} line {at}: {len(cells)} cells where the first line has "
                f"{len(header)}"
            )
    return [dict(zip(header, cells, strict=True)) for cells in rows[1:]]


def with_traits(listing: Listing, told: Mapping[str, Mapping[str, str]]) -> Listing:
    """Return a listing in which every entry has all that is told of its subject.

    Parameters
    ----------
    listing : Listing
        Entries may tell traits, or leave them "".
    told : mapping of str to mapping
        Traits of subjects that are told elsewhere; they come first.

    Returns
    -------
    listing : Listing
        An entry that contradicts what was told before is passed over.
    """
    known = {name: dict(traits) for name, traits in told.items()}
    for entry in listing.entries:
        own = known.setdefault(entry.subject, {})
        for key in TRAITS:
            if getattr(entry, key):
                own.setdefault(key, getattr(entry, key))
    entries, passed = [], list(listing.passed)
    for entry in listing.entries:
        traits: dict[str, Any] = known[entry.subject]
        differs = [k for k, v in traits.items() if getattr(entry, k) not in ("", v)]
        if differs:
            key = differs[0]
            passed.append(
                (
                    entry,
                    f"its {key} is {getattr(entry, key)!r}, and {traits[key]!r} "
                    f"elsewhere for {entry.subject!r}: do two people have one name?",
                )
            )
        else:
            entries.append(dataclasses.replace(entry, **traits))
    return Listing(tuple(entries), tuple(passed))
