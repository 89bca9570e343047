"""How hot loops are compiled: one set of options, a cache that is never stale."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba

_OPTIONS: dict[str, Any] = {
    "nogil": True,  # so that threads share the work
    "error_model": "numpy",  # a quotient by 0 is inf, and loops stay free of branches
    # Sums and products may be fused and signs of zero lost; nothing else may change.
    "fastmath": {"contract", "nsz"},
}


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into every loop that calls it, so that these vectorise."""
    return numba.njit(forceinline=True, **_OPTIONS)(function)


def summing(function: Callable[..., Any]) -> Any:
    """Compile for others to call, with sums in whatever order vectorises."""
    return _freely(function, "reassoc")


def comparing(function: Callable[..., Any]) -> Any:
    """Compile for others to call, as if no value were NaN, so that minima vectorise."""
    return _freely(function, "nnan")


def _freely(function: Callable[..., Any], licence: str) -> Any:
    """Return a function compiled with one more licence than usual."""
    free = {**_OPTIONS, "fastmath": {*_OPTIONS["fastmath"], licence}}
    return numba.njit(**free)(function)


def compiled(signature: Any = None) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function and keeps the result on disk.

    Without a signature it is compiled for the arguments of each first call; with one,
    when its module is imported. numba looks only at the function's own file to tell
    whether the kept result is still true, not at the files of what was inlined. The
    name under which it is kept therefore carries a stamp of the whole folder, and of
    what other folders have to inline.
    """

    def keep(function: Callable[..., Any]) -> Any:
        folder = Path(function.__code__.co_filename).parent
        function.__qualname__ += f"_{_folder_stamp(folder)}"
        try:
            return numba.njit(signature, cache=True, **_OPTIONS)(function)
        except RuntimeError:  # no folder to keep it in may be written
            return numba.njit(signature, **_OPTIONS)(function)

    return keep


@cache
def _folder_stamp(folder: Path) -> str:
    """Return a mark of a folder's sources, of all kernels and of how they compile."""
    digest = hashlib.sha1(usedforsecurity=False)
    package = Path(__file__).parent
    shared = (package / "_vector_math.py", *sorted(package.glob("*/kernels.py")))
    for file in (Path(__file__), *shared, *sorted(folder.glob("*.py"))):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:12]
