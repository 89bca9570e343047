"""What a figure of the gallery is: where its numbers come from and how they are drawn.

A recipe is data in two functions: ``data`` makes tables, and pictures of hands, which
are all that ``draw`` is given. So what is drawn is what is written as CSV.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Advance = Callable[[int], None]

COLUMN, PAGE = 89 / 25.4, 183 / 25.4
"""Widths of one and of two columns in print. [inches]"""

PRINT = 300
"""Dots per inch of print."""


@dataclass(frozen=True)
class Source:
    """Something that figures are made from, and what must be said of it.

    Attributes
    ----------
    credit : str
        Its makers and licence, in a sentence.
    files : tuple of str
        Shipped files that hold it: below the package, or below ``meshes``.
    """

    credit: str
    files: tuple[str, ...]


ISSA = Source(
    "Spectra: International Skin Spectra Archive, a part; Lu et al., Sci. Data 12:487 "
    "(2025), CC BY 4.0.",
    ("spectra/data/issa_2025_part_360-740nm_10nm.csv.gz",),
)
EFFECTIVE = Source(
    "Coefficients: “effective”, fitted to NIST subjects (Cooksey et al. 2017, public "
    "domain), with blood of Bosschaart et al. 2014, CC BY.",
    ("skin/data/effective.csv", "skin/data/thickness.csv"),
)
TEXTBOOK = Source(
    "“Textbook”: Jacques 1998 and 2013, with the same blood.",
    ("skin/data/textbook.csv", "skin/data/thickness.csv"),
)
THICKNESS = Source(
    "Thickness: Yazawa 1933, as printed by Doi, Tanaka & Tominaga 2005.",
    ("skin/data/thickness.csv",),
)
COLOUR = Source(
    "", ("spectra/data/cie_cmfs_1nm.csv", "spectra/data/cie_illuminants_5nm.csv")
)
TRANSPORT = Source(
    "Transport: adding–doubling (iadpython), tissue of the “textbook” set; computed by "
    "scripts/benchmarks/transport.py of skinviz, docs/transport.md.",
    ("skin/data/transport.csv",),
)
HAND = Source("Hand: MakeHuman, CC0 1.0.", ("meshes/makehuman_male_right.ply",))


def unnoticed(_: int) -> Advance:
    """Return what takes no notice of how many parts are done."""
    return lambda _: None


@dataclass(frozen=True)
class Settings:
    """What may be asked of every figure.

    Attributes
    ----------
    width : float
        Of the figure. [inches]
    dots : int
        Of pictures, per inch.
    seed : int
        Of what is drawn by lot.
    counting : callable
        Given a number of parts, returns what is told how many of them are done.
    """

    width: float
    dots: int = PRINT
    seed: int = 0
    counting: Callable[[int], Advance] = field(default=unnoticed, compare=False)


@dataclass(frozen=True, eq=False)
class Material:
    """All that a figure is drawn from.

    Attributes
    ----------
    tables : mapping of str to DataFrame
        Written as CSV; "" is the figure's own, others have their name appended.
    caption : str
        What is shown, in sentences.
    pictures : mapping of str to (height, width, 3) ndarray of uint8
        Pictures of hands, by the name that a table has for them. sRGB
    """

    tables: Mapping[str, pd.DataFrame]
    caption: str
    pictures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)

    @property
    def table(self) -> pd.DataFrame:
        """The figure's own table."""
        return self.tables[""]


@dataclass(frozen=True)
class FigureRecipe:
    """How a figure or table of the gallery is made.

    Attributes
    ----------
    name : str
        As users call it: "7", "table-2", "population".
    title : str
        One line.
    sources : tuple of Source
        What ``data`` reads, and to whom thanks are due.
    data : callable
        From settings to material.
    draw : callable, optional
        From material and settings to a figure, within ``rc_context(STYLE)``.
    tell : callable, optional
        From material to text, of what is a table and has no figure.
    width : float
        Its own. [inches]
    suffixes : tuple of str
        Of the files of the figure. Pictures of hands are no plots: PNG only.
    """

    name: str
    title: str
    sources: tuple[Source, ...]
    data: Callable[[Settings], Material]
    draw: Callable[[Material, Settings], Figure] | None = None
    tell: Callable[[Material], str] | None = None
    width: float = PAGE
    suffixes: tuple[str, ...] = (".png", ".svg", ".pdf")

    @property
    def stem(self) -> str:
        """What the names of its files begin with: "fig_7"."""
        name = self.name.replace("-", "_")
        return f"fig_{name}" if name[0].isdigit() else name

    @property
    def credit(self) -> str:
        """What must be said of the sources."""
        return " ".join(dict.fromkeys(s.credit for s in self.sources if s.credit))

    @property
    def files(self) -> tuple[str, ...]:
        """The shipped files that it is made from."""
        return tuple(dict.fromkeys(f for s in self.sources for f in s.files))
