"""Lines that are told apart by colour, dashes and marker, each alone enough."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Line:
    """How a curve is drawn."""

    colour: str
    dashes: Any
    marker: str

    def __call__(self, n: int, shift: int = 0) -> dict[str, Any]:
        """Return the arguments of ``plot`` for a curve of n points, a few marked.

        ``shift`` moves the markers along, so that those of close curves do not meet.
        """
        step = max(n // 7, 1)
        return {
            "color": self.colour,
            "linestyle": self.dashes,
            "marker": self.marker,
            "markevery": (shift % step, step),
            "markersize": 3.5,
            "linewidth": 1.2,
        }


# Okabe and Ito's colours, yellow darkened: it is not seen on white.
LINES = (
    Line("#0072B2", "-", "o"),
    Line("#D55E00", (0, (5, 1.5)), "s"),
    Line("#009E73", (0, (5, 1.5, 1, 1.5)), "^"),
    Line("#CC79A7", (0, (1, 1.2)), "D"),
    Line("#000000", (0, (8, 2)), "v"),
    Line("#E69F00", (0, (3, 1.2, 1, 1.2, 1, 1.2)), "P"),
    Line("#56B4E9", (0, (2, 2)), "X"),
    Line("#8C6D00", (0, (8, 2, 1, 2)), "*"),
)
"""The first few are the most unlike each other."""


def line(k: int) -> Line:
    """Return the k-th line; after the last the colours come again, dashes shifted."""
    first = LINES[k % len(LINES)]
    again = LINES[(k + k // len(LINES)) % len(LINES)]
    return Line(first.colour, again.dashes, again.marker)
