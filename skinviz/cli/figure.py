"""``skinviz figure``: figures and tables of the paper, and some beyond it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.arguments import Whole
from skinviz.cli.output import progress_bar, say, say_files, say_json

if TYPE_CHECKING:
    from skinviz.view.gallery.book import Made
    from skinviz.view.gallery.recipe import FigureRecipe, Settings

ALL = "all"
"""Stands for every figure."""


def figure(
    *names: str,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    size: float | None = None,
    dots: Whole = 300,
    seed: Whole = 0,
    force: bool = False,
    list: bool = False,
    json: bool = False,
) -> None:
    """Make figures and tables from the shipped data, with the numbers they show.

    Each becomes PNG at print resolution and, if it is a plot, SVG and PDF; its tables
    as CSV; its caption and whose data it shows as text. What the folder already has
    from the same data and program is left as it is.

    Example: skinviz figure 7 table-2 --out figures

    Parameters
    ----------
    names
        1a, 1b, 5 to 10, table-1 to table-3, transport, uncertainty, population,
        metamerism, metameric-lights; or all.
    out
        Folder to write into; made if it does not exist.
    size
        Width in mm, 50 to 1000; each figure's own if not said, 89 or 183.
    dots
        Per inch, of pictures.
    seed
        Of what is drawn by lot.
    force
        Make also what the folder already has.
    list
        Say which figures there are, and make none.
    json
        Print what was made as JSON.
    """
    from skinviz.errors import ArgumentError, SkinvizError
    from skinviz.view.gallery.catalogue import NAMES, recipe_of, settings_for

    named = [recipe_of(name) for name in dict.fromkeys(names) if name != ALL]
    every = ALL in names or (list and not names)
    recipes = [recipe_of(name) for name in NAMES] if every else named
    if list:
        _say_list(recipes, json=json)
        return
    if not recipes:
        raise ArgumentError(
            f"name a figure, or {ALL}; there are {', '.join(NAMES)}; --list tells what "
            "they show"
        )
    if out is None:
        raise ArgumentError("say with --out which folder to write into")
    if out.exists() and not out.is_dir():
        raise SkinvizError(f"--out {out} is a file; name a folder")
    asked = [
        (recipe, settings_for(recipe, width=size, seed=seed, dots=dots))
        for recipe in recipes
    ]
    made = _make(asked, out, force=force)
    if json:
        say_json({"figures": [_row(own) for own in made]})
        return
    for own in made:
        how = f"{own.seconds:.1f} s" if own.fresh else "up to date"
        say(f"{own.name:<18}{how}")
    say_files(file for own in made for file in own.files if own.fresh)


def _make(
    asked: list[tuple[FigureRecipe, Settings]], out: Path, *, force: bool
) -> list[Made]:
    """Make the figures under a progress bar."""
    from skinviz.view.gallery.book import make_figures

    with progress_bar(len(asked)) as begin:
        return [
            *make_figures(asked, out, force=force, begin=begin, counting=begin.counting)
        ]


def _say_list(recipes: list[FigureRecipe], *, json: bool) -> None:
    """Say which figures there are, a line each."""
    if json:
        rows = [
            {
                "name": recipe.name,
                "title": recipe.title,
                "width_mm": round(25.4 * recipe.width, 1),
                "formats": [*recipe.suffixes] if recipe.draw else [],
                "credit": recipe.credit,
            }
            for recipe in recipes
        ]
        say_json({"figures": rows})
        return
    for recipe in recipes:
        say(f"{recipe.name:<18}{recipe.title}")


def _row(own: Made) -> dict[str, Any]:
    """Return what was made as plain data."""
    return {
        "name": own.name,
        "made": own.fresh,
        "seconds": round(own.seconds, 2),
        "files": [str(file) for file in own.files],
    }
