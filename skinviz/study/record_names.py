"""Which records a study has, told by the names of files and of spectra in them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinviz.errors import DataError, SkinvizError
from skinviz.study.record_files import SUFFIXES
from skinviz.study.record_list import FIELDS, Entry, Listing, listing_of

if TYPE_CHECKING:
    import xarray

Reader = Callable[[str], "xarray.Dataset"]
"""Returns the spectra of a file of the study's folder."""

CUBE = "is a cube; a study takes single spectra of it"
"""Why a file that has no list of spectra cannot be used."""

_FIELD = re.compile(r"\{(\w*)\}")


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
    if pattern.startswith("/"):
        raise DataError(f"pattern {pattern!r} must be a path in the study's folder")
    name = _Pattern(pattern, "pattern")
    inside = None if labels is None else _Pattern(labels, "labels")
    told = name.fields + (() if inside is None else inside.fields)
    for key in ("subject", "site"):
        if key not in told:
            raise DataError(f"pattern {pattern!r} must tell {{{key}}}, or labels must")
    rows: list[dict[str, str]] = []
    passed: list[tuple[Entry, str]] = []
    for own in _files_beside(folder, name.fixed, name.depth):
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


def _labelled(
    file: str, inside: _Pattern, read: Reader
) -> tuple[list[dict[str, str]], list[str]]:
    """Return what a file's labels tell, and why of some nothing is known."""
    try:
        coordinates = read(file).coords
    except SkinvizError as error:
        return [], [str(error)]
    if "label" not in coordinates:
        return [], [CUBE]
    rows, unclear = [], []
    for label in map(str, coordinates["label"].values):
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
        self.depth = text.count("/") - self.fixed.count("/") - bool(self.fixed)
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


def _files_beside(folder: Path, fixed: str, depth: int) -> list[str]:
    """Return the files of spectra some folders under a part of a folder, by name."""
    return sorted(
        path.relative_to(folder).as_posix()
        for path in (folder / fixed).glob("*/" * depth + "*")
        if path.suffix.lower() in SUFFIXES and path.is_file()
    )
