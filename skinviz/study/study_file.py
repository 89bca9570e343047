"""The folder of a study: ``study.toml``, and the files that it names."""

from __future__ import annotations

import os
import tomllib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinviz._files import existing_file
from skinviz.errors import DataError, SkinvizError
from skinviz.spectra.measurement import as_specular
from skinviz.study import records as made
from skinviz.study.layers import with_layers
from skinviz.study.record_files import read_records
from skinviz.study.record_list import (
    TRAITS,
    Listing,
    listing_of,
    table_of,
    with_traits,
)
from skinviz.study.record_names import listing_of_names
from skinviz.study.study import LEFT_OUT, MISSING, Gap, Shape, Study

if TYPE_CHECKING:
    import xarray

STUDY_FILE = "study.toml"
"""What makes a folder a study."""

_KEYS: dict[str, Any] = {
    "title": str,
    "specular": (str, int, float),
    "geometry": str,
    "source": str,
    "licence": str,
    "scale": str,
    "records": str,
    "pattern": str,
    "labels": str,
    "record": list,
    "sites": dict,
    "subjects": dict,
}
_SUBJECT_KEYS = (*TRAITS, "mesh", "scan", "unit", "gonio")
_KEPT = ("source", "licence", "geometry")


def read_study(folder: str | os.PathLike[str], *, strict: bool = False) -> Study:
    """Read a study from its folder.

    Parameters
    ----------
    folder : str or path-like
        Has ``study.toml``, which says how the spectra were measured and lists them,
        and the files that it names; ``docs/compare.md`` has the layout.
    strict : bool
        Whether to stop at the first gap. Without it records that are missing or
        cannot be used are told of in ``gaps``, and the others are read.

    Returns
    -------
    study : Study
        At least one record.

    Raises
    ------
    DataError
        If the folder or ``study.toml`` is missing or wrong, no record can be used, or
        ``strict`` and there is a gap.
    """
    home = Path(folder)
    if home.is_file():
        raise DataError(f"{home}: is a file; name the folder that has {STUDY_FILE}")
    file = existing_file(home / STUDY_FILE, DataError)
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"{file}: not a TOML file: {error}") from error
    try:
        study = _study(content, home)
    except SkinvizError as error:
        told = str(error)
        raise DataError(told if str(home) in told else f"{file}: {told}") from error
    if strict:
        study.raise_for_gaps()
    return study


def _study(content: dict[str, Any], home: Path) -> Study:
    """Return the study that parsed TOML describes."""
    _require_known(content)
    title = " ".join(content.get("title", home.resolve().name).split())
    specular = as_specular(content["specular"])

    @cache
    def read(file: str) -> xarray.Dataset:
        try:
            return read_records(
                home / file, scale=content.get("scale"), specular=specular
            )
        except SkinvizError as error:
            raise SkinvizError(_without_path(str(error), home / file)) from error

    subjects = _subjects(content.get("subjects", {}))
    traits = {
        name: {key: str(table[key]) for key in TRAITS if key in table}
        for name, table in subjects.items()
    }
    listing = with_traits(_listing(content, home, read), traits)
    gaps = [made.gap(LEFT_OUT, entry, why) for entry, why in listing.passed]
    read_in, unreadable = made.read_entries(listing.entries, read)
    gridded, resampled = made.on_one_grid(read_in)
    gaps += [*unreadable, *resampled]
    if not gridded:
        first = f"; the first: {gaps[0]}" if gaps else ", it lists none"
        raise DataError(f"no record can be used{first}")
    attributes = {"source": title, "licence": "", "geometry": ""}
    attributes |= {key: content[key] for key in _KEPT if key in content}
    spectra = made.as_dataset(gridded, {**attributes, "specular": specular})
    spectra, layers, dropped = with_layers(spectra, content.get("sites", {}))
    spectra, doubtful = made.without_duplicates(spectra)
    gaps += [*dropped, *doubtful]
    explained = [(gap.subject, gap.site, gap.condition) for gap in gaps]
    gaps += made.missing_cells(made.cells_of(spectra), explained, subjects)
    shapes, gonio, lost = _files_of(subjects, home)
    return Study(title, spectra, layers, (*gaps, *lost), shapes, gonio)


def _require_known(content: dict[str, Any]) -> None:
    """Refuse misspelt keys, wrong kinds, and a study that does not say its way."""
    for key, value in content.items():
        if key not in _KEYS:
            raise DataError(f"unknown key {key!r}; known are {', '.join(_KEYS)}")
        if not isinstance(value, _KEYS[key]) or isinstance(value, bool):
            raise DataError(f"{key} is of the wrong kind: {value!r}")
    if "specular" not in content:
        raise DataError(
            'say how the surface reflection was measured: specular = "excluded", '
            '"included" or a number'
        )
    tables = [
        (k, n, t) for k in ("sites", "subjects") for n, t in content.get(k, {}).items()
    ]
    for key, name, table in tables:
        if not isinstance(table, dict):
            raise DataError(f"write [{key}.{name}] as a table")
    _require_listed(content)


def _require_listed(content: dict[str, Any]) -> None:
    """Refuse a study that lists its records in no way, or in two."""
    listed = [key for key in ("records", "pattern", "record") if key in content]
    if len(listed) != 1:
        raise DataError(
            'list the records in one way: records = "table.csv", pattern = '
            '"spectra/{subject}_{site}.csv" or [[record]] tables; got '
            f"{' and '.join(listed) or 'none'}"
        )
    if "labels" in content and "pattern" not in content:
        raise DataError("labels goes with pattern; a table has the column label")
    if not all(isinstance(row, dict) for row in content.get("record", ())):
        raise DataError("write [[record]], once for each")


def _listing(content: dict[str, Any], home: Path, read: Any) -> Listing:
    """Return what the study lists, in whichever way it does."""
    if "records" in content:
        return listing_of(table_of(home / content["records"]))
    if "pattern" in content:
        return listing_of_names(home, content["pattern"], content.get("labels"), read)
    return listing_of(content["record"])


def _subjects(told: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return what is told of each subject, its keys known."""
    for name, table in told.items():
        for key, value in table.items():
            if key not in _SUBJECT_KEYS:
                raise DataError(
                    f"unknown key {key!r} in [subjects.{name}]; known are "
                    f"{', '.join(_SUBJECT_KEYS)}"
                )
            if isinstance(value, dict | list | bool) and key != "gonio":
                raise DataError(f"{key} in [subjects.{name}] must be text")
        if {"mesh", "scan"} <= table.keys():
            raise DataError(f"[subjects.{name}] has both mesh and scan; give one")
    return told


def _files_of(
    subjects: dict[str, dict[str, Any]], home: Path
) -> tuple[dict[str, Shape], dict[tuple[str, str], Path], list[Gap]]:
    """Return the hands and goniometer readings of subjects, and what is not there."""
    shapes: dict[str, Shape] = {}
    gonio: dict[tuple[str, str], Path] = {}
    lost = []

    def there(name: str, site: str, told: Any) -> bool:
        if (home / str(told)).is_file():
            return True
        lost.append(Gap(MISSING, name, site, "", 0, str(told), "no such file"))
        return False

    for name, table in subjects.items():
        for key in ("mesh", "scan"):
            if key in table and there(name, "", table[key]):
                path = home / str(table[key])
                unit = None if "unit" not in table else str(table["unit"])
                shapes[name] = Shape(path, unit, key == "scan")
        own = table.get("gonio", {})
        for site, path in (own if isinstance(own, dict) else {"": own}).items():
            if there(name, site, path):
                gonio[name, site] = home / str(path)
    return shapes, gonio, lost


def _without_path(text: str, path: Path) -> str:
    """Return an error's text less the path, which a gap names itself."""
    return text.removeprefix(f"{path}: ").removeprefix(f"{path} ")
