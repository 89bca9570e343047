"""What a file holds: its bytes, or its lines with their numbers.

Every reader begins here, so that all of them meet the same faults alike: binary
bytes in a text, endings of lines of other systems, a byte order mark, a number that
is none. What the numbers mean belongs in the reader of the format.
"""

from __future__ import annotations

import codecs
import itertools
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError

UNIT_COMMENT = "unit "
"""Comment by which our files state their unit of length: ``unit mm``."""

_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)

_LARGEST = 2**62


@dataclass(frozen=True)
class Lines:
    """Lines of a text file that say something, and where they stand in it.

    Attributes
    ----------
    path : Path
        The file.
    texts : sequence of str
        Lines without the blanks around them; none is empty.
    numbers : sequence of int
        The number of each in the file, from 1.
    comments : tuple of str
        What the comments say.
    """

    path: Path
    texts: Sequence[str]
    numbers: Sequence[int]
    comments: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return how many lines there are."""
        return len(self.texts)

    def part(self, start: int, stop: int | None = None) -> Lines:
        """Return the lines from one to another."""
        span = slice(start, stop)
        return Lines(self.path, self.texts[span], self.numbers[span])

    def fault(self, index: int, what: str) -> MeshError:
        """Return the error that is told of one of the lines."""
        if not self.texts:
            return MeshError(f"{self.path}: {what}")
        return MeshError(f"{self.path} line {self.numbers[index]}: {what}")


def read_bytes(path: Path) -> bytes:
    """Return all bytes of a file or say why it cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise MeshError(f"{path}: cannot be read: {error.strerror or error}") from error


def split_lines(text: str) -> list[str]:
    """Return a text's lines, whichever system's endings they have."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def read_lines(path: Path, comment: tuple[str, ...] = ("#",)) -> Lines:
    """Return the lines of a text file, without comments and blank ones.

    A comment begins with one of the marks and ends with its line.
    """
    said: list[str] = []
    texts, numbers = [], []
    for number, line in enumerate(split_lines(_decoded(path)), start=1):
        body = line
        for mark in comment:
            body, found, rest = body.partition(mark)
            if found:
                said.append(rest.strip())
        body = body.strip()
        if body:
            texts.append(body)
            numbers.append(number)
    if not texts:
        raise MeshError(f"{path}: holds no line but blank ones and comments")
    return Lines(path, texts, numbers, tuple(said))


def stated_unit(comments: Iterable[str]) -> str | None:
    """Return the unit of length that a file's comments state, if any."""
    for comment in comments:
        words = comment.split()
        if comment.startswith(UNIT_COMMENT) and len(words) == 2:
            return words[1]
    return None


def table(
    lines: Lines,
    *,
    separator: str | None = None,
    first: int | None = None,
    columns: int | None = None,
    finite: bool = True,
) -> NDArray[np.float64]:
    """Return lines of numbers as an array (lines, columns), by default of finite ones.

    All lines have as many columns as is said or as the first one has; or, with
    ``first``, at least that many, of which the rest is passed over. Without a
    separator, columns are parted by blanks or tabs.
    """
    if len(lines) == 0:
        return np.zeros((0, first or columns or 0))
    try:
        if not all(map(str.strip, lines.texts)):  # NumPy would pass over such lines
            raise ValueError("a line is empty")
        values = np.loadtxt(
            lines.texts,
            delimiter=separator,
            comments=None,
            ndmin=2,
            usecols=None if first is None else range(first),
        )
        if columns not in (None, values.shape[1]):
            raise ValueError(f"{columns} columns expected")
    except (ValueError, OverflowError) as error:
        raise _first_fault(lines, separator, first, columns, str(error)) from error
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if finite and bad.size:
        i = int(bad[0])
        raise lines.fault(
            i, f"a number is not finite ({bad.size} such lines); remove such points"
        )
    return values


def integers(lines: Lines, words: Sequence[str], index: int) -> list[int]:
    """Return the words of a line as integers."""
    try:
        values = [int(word) for word in words]
        if values and max(map(abs, values)) > _LARGEST:
            raise ValueError("too large")
    except ValueError as error:
        raise lines.fault(
            index, f"expected whole numbers, got {shown(' '.join(words))}"
        ) from error
    return values


def uniform_integers(texts: Sequence[str]) -> NDArray[np.int64] | None:
    """Return lines of equally many whole numbers as an array; None of any other.

    A quick way for what most files hold; the slow one says what is wrong.
    """
    try:
        with warnings.catch_warnings(action="error"):  # of numbers with a point
            values = np.loadtxt(texts, dtype=np.int64, comments=None, ndmin=2)
    except (ValueError, OverflowError, Warning):
        return None
    return values if len(values) == len(texts) else None


def flat_lists(lists: Sequence[Sequence[int]]) -> NDArray[np.int64]:
    """Return the numbers of all lists, one list after the other."""
    total = sum(map(len, lists))
    return np.fromiter(itertools.chain.from_iterable(lists), np.int64, total)


def as_indices(values: NDArray[Any], where: str) -> NDArray[np.int64]:
    """Return numbers of points as int64, or say that they are none."""
    if values.dtype.kind == "f" or (values.size and values.max() > _LARGEST):
        raise MeshError(f"{where}: points are named by what are no whole numbers")
    return values.astype(np.int64)


def shown(text: str) -> str:
    """Return a text as it fits into a message."""
    return repr(text if len(text) <= 40 else text[:37] + "...")


def _decoded(path: Path) -> str:
    """Return a file's text, or say that it holds none."""
    content = read_bytes(path)
    encoding = "utf-8"
    for mark, name in _MARKS:
        if content.startswith(mark):
            content, encoding = content[len(mark) :], name
            break
    # Names and comments may be in any encoding; numbers are in none but this.
    text = content.decode(encoding, errors="replace")
    if "\0" in text:
        number = text[: text.index("\0")].count("\n") + 1
        raise MeshError(
            f"{path} line {number}: binary bytes in what should be a text file; it is "
            "broken or of another kind"
        )
    return text


def _first_fault(
    lines: Lines,
    separator: str | None,
    first: int | None,
    columns: int | None,
    otherwise: str,
) -> MeshError:
    """Return the error of the first line that is no row of the table."""
    wanted = first or columns or len(lines.texts[0].split(separator))
    for i, text in enumerate(lines.texts):
        words = text.split(separator)
        if len(words) < wanted or (first is None and len(words) > wanted):
            return lines.fault(
                i, f"expected {wanted} numbers, got {len(words)}: {shown(text)}"
            )
        for word in words[:wanted]:
            if not is_number(word):
                return lines.fault(i, f"{shown(word.strip())} is no number")
    return lines.fault(0, f"no table of numbers: {otherwise}")


def is_number(word: str) -> bool:
    """Return whether a word is a number as files write them."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word and word.isascii()
