"""The names of the gallery's figures, and the figure of a name."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from skinviz._files import whole_files
from skinviz._validate import in_range, one_of
from skinviz.view.gallery.recipe import PRINT, FigureRecipe, Material, Settings
from skinviz.view.gallery.text import as_csv

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    from matplotlib.figure import Figure

_MM = 25.4  # per inch

MODULES = {
    "1a": "fig_1a",
    "1b": "fig_1b",
    "5": "fig_5",
    "6": "fig_6",
    "7": "fig_7",
    "8": "fig_8",
    "9": "fig_9",
    "10": "fig_10",
    "table-1": "table_1",
    "table-2": "table_2",
    "table-3": "table_3",
    "transport": "transport",
    "uncertainty": "uncertainty",
    "population": "population",
    "metamerism": "metamerism",
    "metameric-lights": "metameric_lights",
}
"""The figures by name, and the module of each, loaded when asked for."""

NAMES = tuple(MODULES)
"""Names that :func:`figure` knows, in the order of the gallery."""

NARROWEST, WIDEST = 50.0, 1000.0
"""Widths that a figure may be given. [mm]"""


@dataclass(frozen=True, eq=False)
class GalleryFigure:
    """A figure or table with the numbers that it shows.

    Attributes
    ----------
    recipe : FigureRecipe
        What it is.
    settings : Settings
        What was asked of it.
    material : Material
        Its tables, pictures and caption.
    """

    recipe: FigureRecipe
    settings: Settings
    material: Material

    @property
    def tables(self) -> Mapping[str, pd.DataFrame]:
        """The numbers, as they are written to CSV."""
        return self.material.tables

    @property
    def caption(self) -> str:
        """Title, what is shown, and whose the data are."""
        parts = (f"{self.recipe.title}.", self.material.caption, self.recipe.credit)
        return "\n\n".join(part for part in parts if part) + "\n"

    def draw(self) -> Figure | None:
        """Return it as a Matplotlib figure; None of a table."""
        import matplotlib as mpl

        from skinviz.view.page import STYLE

        if self.recipe.draw is None:
            return None
        with mpl.rc_context(STYLE):
            return self.recipe.draw(self.material, self.settings)

    def save(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write all files of it into a folder, all or none; return their paths.

        The figure as PNG at print resolution and, of plots, SVG and PDF; each table as
        CSV; caption and credits as text.
        """
        import matplotlib as mpl

        from skinviz.view.figures import save_figure
        from skinviz.view.page import STYLE

        where, stem = Path(folder), self.recipe.stem
        texts = {
            f"{stem}{f'_{name}' if name else ''}.csv": as_csv(table)
            for name, table in self.tables.items()
        }
        texts[f"{stem}.txt"] = self._words()
        figure = self.draw()
        drawn = self.recipe.suffixes if figure is not None else ()
        names = [*(f"{stem}{suffix}" for suffix in drawn), *texts]
        with whole_files(*(where / name for name in names)) as partials:
            for name, partial in zip(names, partials, strict=True):
                if name in texts:
                    partial.write_text(texts[name], encoding="utf-8")
                elif figure is not None:
                    with mpl.rc_context(STYLE):
                        save_figure(figure, partial, dots=self.settings.dots)
        return [where / name for name in names]

    def _words(self) -> str:
        """Return the caption, under it the table if that is all there is."""
        if self.recipe.tell is None:
            return self.caption
        return f"{self.caption}\n{self.recipe.tell(self.material)}"


def figure(
    name: str | int,
    *,
    width: float | None = None,
    seed: int = 0,
    dots: int = PRINT,
) -> GalleryFigure:
    """Return a figure or table of the gallery, computed from the shipped data.

    Parameters
    ----------
    name : str
        "1a", "1b", "5" to "10", "table-1" to "table-3" are the paper's; "transport",
        "uncertainty", "population", "metamerism", "metameric-lights" go beyond it.
    width : float, optional
        Of the figure; its own if not said. [mm], 50 to 1000
    seed : int
        Of what is drawn by lot: the same seed gives the same numbers.
    dots : int
        Of pictures, per inch; 10 to 1200.

    Returns
    -------
    figure : GalleryFigure
        With ``tables``, ``caption``, ``draw()`` and ``save(folder)``.

    Raises
    ------
    ArgumentError
        If there is no such figure, the message naming the nearest, or a number is
        out of range.

    Examples
    --------
    >>> table = figure("table-1").tables[""]
    >>> table["epidermis_mm"].tolist()
    [0.027, 0.035, 0.036, 0.041]
    """
    recipe = recipe_of(name)
    settings = settings_for(recipe, width=width, seed=seed, dots=dots)
    return GalleryFigure(recipe, settings, recipe.data(settings))


def recipe_of(name: str | int) -> FigureRecipe:
    """Return the recipe of a figure, or say which there are."""
    module = MODULES[one_of(str(name), NAMES, "figure")]
    recipe: FigureRecipe = import_module(f"{__package__}.{module}").RECIPE
    return recipe


def settings_for(
    recipe: FigureRecipe, *, width: float | None, seed: int, dots: int
) -> Settings:
    """Return checked settings; the width is in mm."""
    if width is not None:
        in_range(width, NARROWEST, WIDEST, "the width of a figure", "mm")
    in_range(dots, 10, 1200, "dots", "per inch")
    in_range(seed, 0, 2**32, "seed")
    inches = recipe.width if width is None else width / _MM
    return Settings(inches, int(dots), int(seed))
