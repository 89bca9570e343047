"""How several hands share one picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GAP = 2
"""Pixels between tiles."""

_SMALLEST = 16


@dataclass(frozen=True)
class Tiles:
    """A picture cut into tiles of one size.

    Attributes
    ----------
    columns, rows : int
        Of tiles.
    size : (int, int)
        Width and height of a tile. [pixels]
    """

    columns: int
    rows: int
    size: tuple[int, int]

    @property
    def whole(self) -> tuple[int, int]:
        """Width and height of the picture. [pixels]"""
        width, height = self.size
        return (
            self.columns * (width + GAP) - GAP,
            self.rows * (height + GAP) - GAP,
        )

    def corner(self, tile: int) -> tuple[int, int]:
        """Return the left and top of a tile. [pixels]"""
        row, column = divmod(tile, self.columns)
        return column * (self.size[0] + GAP), row * (self.size[1] + GAP)

    def at(self, column: float, row: float) -> tuple[int, float, float] | None:
        """Return the tile at a place and where in it that is; None in a gap."""
        width, height = self.size
        across, x = divmod(column, width + GAP)
        along, y = divmod(row, height + GAP)
        inside = 0 <= across < self.columns and 0 <= along < self.rows
        if not inside or x >= width or y >= height:
            return None
        return int(along) * self.columns + int(across), x, y

    def joined(self, parts: list[NDArray[np.uint8]], gap: int) -> NDArray[np.uint8]:
        """Return the picture of tiles (h, w, 3), with a grey between them."""
        width, height = self.whole
        picture = np.full((height, width, 3), gap, np.uint8)
        for tile, part in enumerate(parts):
            left, top = self.corner(tile)
            picture[top : top + self.size[1], left : left + self.size[0]] = part
        return picture


def tiles_of(n: int, size: tuple[int, int]) -> Tiles:
    """Return n tiles that fill a picture: side by side, and four by two and two."""
    columns, rows = (2, 2) if n == 4 else (n, 1)
    width = max(_SMALLEST, (size[0] + GAP) // columns - GAP)
    height = max(_SMALLEST, (size[1] + GAP) // rows - GAP)
    return Tiles(columns, rows, (width, height))
