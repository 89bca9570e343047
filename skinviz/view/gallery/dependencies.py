"""Which source files and shipped files of skinviz a module depends on."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

from skinviz.errors import DataError

_PACKAGE = Path(__file__).parents[2]


def modules_behind(module: str) -> list[Path]:
    """Return the files of a module and of all of skinviz that it imports, sorted.

    Imports count wherever they stand, in functions too; what only type checkers read
    does not. skinviz's own ``__init__`` does not count.
    """
    found: set[str] = set()
    to_do = [module]
    while to_do:
        name = to_do.pop()
        if name not in found:
            found.add(name)
            to_do += _imports(name)
    paths = (_file_of(name) for name in found - {"skinviz"})
    return sorted(path for path in paths if path is not None)


def data_path(name: str) -> Path:
    """Return the path of a shipped file: below the package, or below ``meshes``.

    Raises
    ------
    DataError
        If it is not there.
    """
    for root in (_PACKAGE, _PACKAGE.parent):
        if (root / name).is_file():
            return root / name
    raise DataError(f"the shipped file {name} is missing; install skinviz anew")


@cache
def _imports(module: str) -> tuple[str, ...]:
    """Return the modules of skinviz that a module names in its imports."""
    path = _file_of(module)
    if path is None or module == "skinviz":  # which names everything
        return ()
    names: set[str] = set()
    for node in _run(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return tuple(sorted(name for name in names if name.split(".")[0] == "skinviz"))


def _run(node: ast.AST) -> list[ast.AST]:
    """Return a node and those within it, without what only type checkers read."""
    found = [node]
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
            continue
        found += _run(child)
    return found


def _file_of(module: str) -> Path | None:
    """Return the source of a module; None if the name is no module's."""
    path = _PACKAGE.parent.joinpath(*module.split("."))
    for file in (path.with_suffix(".py"), path / "__init__.py"):
        if file.is_file():
            return file
    return None
