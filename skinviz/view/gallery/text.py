"""Tables as CSV, as aligned text and as Markdown."""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


def as_csv(table: pd.DataFrame) -> str:
    """Return a table as CSV, numbers to six digits."""
    text = io.StringIO()
    table.to_csv(text, index=False, float_format="%.6g", lineterminator="\n")
    return text.getvalue()


def as_text(table: pd.DataFrame, digits: int = 4) -> str:
    """Return a table in aligned columns."""
    rows = _cells(table, digits)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    )
    return "\n".join(line.rstrip() for line in lines) + "\n"


def as_markdown(table: pd.DataFrame, digits: int = 3) -> str:
    """Return a table as Markdown."""
    lines = [f"| {' | '.join(row)} |" for row in _cells(table, digits)]
    return "\n".join([lines[0], "|---" * table.shape[1] + "|", *lines[1:]]) + "\n"


def _cells(table: pd.DataFrame, digits: int) -> list[list[str]]:
    """Return head and rows as text; "" for what is missing."""

    def told(value: object) -> str:
        if isinstance(value, float):
            return "" if math.isnan(value) else f"{value:.{digits}g}"
        return "" if value is None else str(value)

    rows = [[told(v) for v in row] for row in table.itertuples(index=False)]
    return [[str(name) for name in table.columns], *rows]
