"""Which records a study's folder has: by a table, a pattern of names, or one by one."""

from __future__ import annotations

import csv
import dataclasses
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinviz._files import existing_file
from skinviz.errors import DataError, SkinvizError
from skinviz.spectra.formats import FORMATS
from skinviz.spectra.formats.raw import read_text

if TYPE_CHECKING:
    import xarray

Reader = Callable[[str], "xarray.Dataset"]

TRAITS = ("group", "sex", "age", "origin")
"""What is told of a subject, and is the same in all its records."""

FIELDS = ("subject", "site", "condition", "repeat", *TRAITS)
"""What names of files and labels can tell."""

COLUMNS = ("file", "label", *FIELDS)
"""What a table of records can tell."""

_AT_MOST = 2**26  # bytes of a table
_FIELD = re.compile(r"\{(\w*)\}")


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

    file: str
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


def listing_of_names(
    folder: Path, pattern: str, labels: str | None, read: Reader
) -> Listing:
    """Return the entries that names of files tell, and labels inside them.

    Parameters
    ----------
    folder : Path
        The study's.
    pattern : str
        Path in the folder with fields in braces, as ``spectra/{subject}_{site}.csv``;
        in a site's name hyphens are read as spaces.
    labels : str or None
        What the labels inside a file tell, with fields in braces; None if a file has
        one spectrum.
    read : callable
        Returns the spectra of a file of the folder.
    """
    name = _Pattern(pattern, "pattern")
    inside = None if labels is None else _Pattern(labels, "labels")
    told = name.fields + (() if inside is None else inside.fields)
    for key in ("subject", "site"):
        if key not in told:
            raise DataError(f"pattern {pattern!r} must tell {{{key}}}, or labels must")
    rows: list[dict[str, str]] = []
    passed: list[tuple[Entry, str]] = []
    for own in _files_beside(folder, name.fixed):
        found = name.match(own)
        if found is None:
            passed.append((Entry(own), f"its name does not follow {pattern!r}"))
        elif inside is None:
            rows.append({"file": own, **found})
        else:
            more, unclear = _labelled(own, inside, read)
            rows += [{"file": own, **found, **row} for row in more]
            known: dict[str, Any] = {k: v for k, v in found.items() if k != "repeat"}
            passed += [(Entry(own, **known), why) for why in unclear]
    listing = listing_of(rows)
    return Listing(listing.entries, (*listing.passed, *passed))


def with_traits(entry: Entry, traits: Mapping[str, str]) -> Entry:
    """Return an entry with what the study tells of its subject, or refuse two ways.

    Raises
    ------
    DataError
        If the entry tells another group, sex, age or origin.
    """
    for key, value in traits.items():
        own = getattr(entry, key)
        if own and value and own != value:
            raise DataError(f"{key} is {own!r} here and {value!r} elsewhere")
    told: dict[str, Any] = {key: value for key, value in traits.items() if value}
    return dataclasses.replace(entry, **told)


def _labelled(
    file: str, inside: _Pattern, read: Reader
) -> tuple[list[dict[str, str]], list[str]]:
    """Return what a file's labels tell, and why of some nothing is known."""
    try:
        labels = read(file).coords.get("label", ())
    except SkinvizError as error:
        return [], [str(error)]
    rows, unclear = [], []
    for label in map(str, getattr(labels, "values", labels)):
        found = inside.match(label)
        if found is None:
            unclear.append(f"the label {label!r} does not follow {inside.text!r}")
        else:
            rows.append({"label": label, **found})
    return rows, unclear


class _Pattern:
    """Text with fields in braces, which finds what stands in their place."""

    def __init__(self, text: str, name: str) -> None:
        """Take the text; refuse a field that is unknown or stands twice."""
        self.text, self.fields = text, tuple(_FIELD.findall(text))
        for field in self.fields:
            if field not in FIELDS or self.fields.count(field) > 1:
                raise DataError(
                    f"{name} {text!r}: fields are {', '.join(FIELDS)}, each once; got "
                    f"{{{field}}}"
                )
        parts = _FIELD.split(text)
        self.fixed = parts[0].rpartition("/")[0]
        expression = ""
        for i, part in enumerate(parts):
            kind = r"\d+" if part == "repeat" else r"[^/]+?"
            expression += f"(?P<{part}>{kind})" if i % 2 else re.escape(part)
        self._expression = re.compile(expression)

    def match(self, text: str) -> dict[str, str] | None:
        """Return what stands in the fields' places, None if the text is another."""
        found = self._expression.fullmatch(text)
        if found is None:
            return None
        told = found.groupdict()
        if "site" in told:  # names of files have hyphens for spaces
            told["site"] = told["site"].replace("-", " ")
        return told


def _files_beside(folder: Path, fixed: str) -> list[str]:
    """Return the files of spectra in a part of a folder, by name."""
    return sorted(
        path.relative_to(folder).as_posix()
        for path in (folder / fixed).rglob("*")
        if path.suffix.lower() in FORMATS and path.is_file()
    )
