"""Steps of cleaning in a TOML file: one ``[[step]]`` each, in their order."""

from __future__ import annotations

import os
import tomllib
from typing import Any

import numpy as np

from skinviz._files import existing_file
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan.steps import KINDS, Step


def read_steps(path: str | os.PathLike[str]) -> tuple[Step, ...]:
    """Read what is to be done with a scan, and how.

    Parameters
    ----------
    path : str or path-like
        A TOML file with a table ``[[step]]`` for each step: its ``name`` and those
        of its parameters that are not to be the default. Lengths in mm, angles in
        degrees.

    Returns
    -------
    steps : tuple of Step
        In the file's order.

    Raises
    ------
    MeshError
        If the file cannot be read, is not TOML, or names a step or a parameter
        that there is not, or a value that it cannot have.
    """
    file = existing_file(path, MeshError)
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise MeshError(f"{file}: is not TOML: {error}") from error
    tables = content.pop("step", None)
    if content or not isinstance(tables, list) or not tables:
        unknown = f"; got {', '.join(content)}" if content else ""
        raise MeshError(
            f"{file}: expected a table [[step]] for each step of cleaning and nothing "
            f"else{unknown}"
        )
    return tuple(_step(table, f"{file}: step {i}") for i, table in enumerate(tables, 1))


def _step(table: Any, where: str) -> Step:
    """Return the step that a table says."""
    if not isinstance(table, dict) or not isinstance(table.get("name"), str):
        raise MeshError(f"{where} has no name; say one of {', '.join(KINDS)}")
    values = dict(table)
    name = values.pop("name")
    known = KINDS[name].parameters if name in KINDS else {}
    for key, value in values.items():
        if key in known and known[key].unit == "rad":
            if isinstance(value, bool | str) or not isinstance(value, int | float):
                raise MeshError(f"{where}: {key} must be an angle in degrees")
            values[key] = float(np.deg2rad(value))
    try:
        return Step(name, values)
    except ArgumentError as error:
        raise MeshError(f"{where}: {error}") from error
