"""Tables of text that wrap their columns instead of running over the line's end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

_WIDTH, _GAP, _LABEL = 100, 2, 26  # letters: of a line, between columns, of a label


@dataclass(frozen=True)
class Column:
    """A column: its name, and for each row a cell and maybe one below it."""

    name: str
    cells: Sequence[str]
    below: Sequence[str] = ()

    @property
    def width(self) -> int:
        """Letters that it takes, with the gap before it."""
        return _GAP + max(map(len, (self.name, *self.cells, *self.below)))


def table(
    title: str, labels: Sequence[str], columns: Sequence[Column]
) -> Iterator[str]:
    """Yield the lines of a table; a label that is too long has a line of its own."""
    indent = min(_LABEL, max(map(len, (title, *labels))))
    groups = _groups(columns, _WIDTH - indent)
    for i, group in enumerate(groups):
        yield _line(title if i == 0 else "", indent, group, [c.name for c in group])
    for row, label in enumerate(labels):
        if len(label) > indent:
            yield label
        rest = label if len(label) <= indent else ""
        for group in groups:
            yield _line(rest, indent, group, [c.cells[row] for c in group])
            rest = ""
            below = [c.below[row] if c.below else "" for c in group]
            if any(below):
                yield _line("", indent, group, below)


def _groups(columns: Sequence[Column], room: int) -> list[list[Column]]:
    """Return the columns in groups that each fit into a line."""
    groups: list[list[Column]] = []
    left = 0
    for column in columns:
        if column.width > left:
            groups.append([])
            left = room
        groups[-1].append(column)
        left -= column.width
    return groups


def _line(label: str, indent: int, group: list[Column], cells: list[str]) -> str:
    """Return one line, numbers flush right."""
    row = zip(group, cells, strict=True)
    return (f"{label:<{indent}}" + "".join(f"{c:>{g.width}}" for g, c in row)).rstrip()
