"""A folder of figures, of which only those are made anew that would be different.

``figures.json`` in the folder holds, of each figure, a digest of all that it depends
on, and of the files that were written.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from skinviz import __version__
from skinviz._files import whole_file
from skinviz.errors import DataError
from skinviz.view.gallery.catalogue import MODULES, GalleryFigure
from skinviz.view.gallery.dependencies import data_path, modules_behind
from skinviz.view.gallery.recipe import Advance, FigureRecipe, Settings, unnoticed

MANIFEST = "figures.json"
"""Name of the file that says what the folder's figures were made from."""

_FORMAT = "skinviz figures 1"
_LIBRARIES = ("numpy", "scipy", "pandas", "matplotlib", "embreex")


@dataclass(frozen=True)
class Made:
    """A figure in a folder.

    Attributes
    ----------
    name : str
        Of the figure.
    files : tuple of Path
        What it consists of.
    seconds : float
        That making it took; 0 if it was there.
    fresh : bool
        Whether it was made now.
    """

    name: str
    files: tuple[Path, ...]
    seconds: float
    fresh: bool


def make_figures(
    asked: Sequence[tuple[FigureRecipe, Settings]],
    folder: str | os.PathLike[str],
    *,
    force: bool = False,
    begin: Callable[[str], None] = lambda _: None,
    counting: Callable[[int], Advance] = unnoticed,
) -> Iterator[Made]:
    """Yield figures as they stand in a folder, each made if it is not there already.

    Parameters
    ----------
    asked : sequence of (FigureRecipe, Settings)
        What is wanted.
    folder : path
        Made if it does not exist. Of each figure all files are written or none.
    force : bool
        Make also what is there.
    begin : callable, optional
        Told the name of each figure as its turn comes.
    counting : callable, optional
        As in :class:`Settings`.

    Raises
    ------
    DataError
        If the folder's ``figures.json`` is not one.
    """
    where = Path(folder)
    entries = _read(where / MANIFEST)
    for recipe, settings in asked:
        begin(recipe.name)
        digest = digest_of(recipe, settings)
        entry = entries.get(recipe.name)
        if not force and entry is not None and _stands(entry, digest, where):
            files = tuple(where / name for name in entry["files"])
            yield Made(recipe.name, files, 0.0, fresh=False)
            continue
        start = time.perf_counter()
        counted = replace(settings, counting=counting)
        made = GalleryFigure(recipe, counted, recipe.data(counted))
        files = tuple(made.save(where))
        seconds = time.perf_counter() - start
        entries[recipe.name] = {
            "digest": digest,
            "width_mm": round(25.4 * settings.width, 3),
            "dots": settings.dots,
            "seed": settings.seed,
            "seconds": round(seconds, 2),
            "files": {file.name: _digest_of_file(file) for file in files},
        }
        _write(where / MANIFEST, entries)
        yield Made(recipe.name, files, seconds, fresh=True)


def digest_of(recipe: FigureRecipe, settings: Settings) -> str:
    """Return a digest of all that a figure depends on.

    That is: the source of its module and of all of skinviz that this imports, the
    shipped files it reads, its settings, and the versions of libraries.
    """
    own = hashlib.sha256()
    versions = [f"{name} {version(name)}" for name in _LIBRARIES]
    said = (_FORMAT, __version__, settings.width, settings.dots, settings.seed)
    own.update("\n".join(map(str, (*said, *versions))).encode())
    module = f"skinviz.view.gallery.{MODULES[recipe.name]}"
    paths = [*modules_behind(module), *(data_path(name) for name in recipe.files)]
    for path in paths:
        own.update(path.name.encode() + _digest_of_file(path).encode())
    return own.hexdigest()


def _stands(entry: dict[str, Any], digest: str, folder: Path) -> bool:
    """Return whether a figure is there, unchanged and made from the same."""
    return entry["digest"] == digest and all(
        (folder / name).is_file() and _digest_of_file(folder / name) == own
        for name, own in entry["files"].items()
    )


def _digest_of_file(path: Path) -> str:
    """Return a digest of what a file holds."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _read(path: Path) -> dict[str, dict[str, Any]]:
    """Return what a folder says of its figures; nothing if it does not say."""
    if not path.exists():
        return {}
    try:
        content = json.loads(path.read_text("utf-8"))
        if content["format"] != _FORMAT:
            raise KeyError(content["format"])
        return {name: dict(own) for name, own in content["figures"].items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DataError(
            f"{path} does not say what figures the folder has; remove it to have all "
            "of them made anew"
        ) from error


def _write(path: Path, entries: dict[str, dict[str, Any]]) -> None:
    """Write what a folder's figures were made from."""
    content = {"format": _FORMAT, "figures": entries}
    with whole_file(path) as partial:
        partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
