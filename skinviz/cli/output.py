"""What the verbs have in common when they speak: progress, files, JSON."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from skinviz._files import whole_file

Advance = Callable[[str], None]


@contextlib.contextmanager
def progress_bar(n_steps: int) -> Iterator[Advance]:
    """Show a bar on standard error; the function it yields begins the next step.

    Where standard error is no terminal, each step is one line.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
    )

    console = Console(stderr=True)
    if not console.is_terminal:
        started = iter(range(1, n_steps + 1))

        def write_line(name: str) -> None:
            sys.stderr.write(f"[{next(started, n_steps)}/{n_steps}] {name}\n")
            sys.stderr.flush()

        yield write_line
        return
    bar = Progress(
        TextColumn("{task.description:<28}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=console,
    )
    with bar:
        task = bar.add_task("", total=n_steps, completed=-1)

        def begin(name: str) -> None:
            bar.update(task, advance=1, description=name, refresh=True)

        yield begin
        bar.update(task, completed=n_steps, description="done")


def say(text: str) -> None:
    """Write one line to standard output."""
    sys.stdout.write(f"{text}\n")


def say_files(files: Iterable[Path]) -> None:
    """Write one line a file: its path and size."""
    for file in files:
        say(f"{file}  ({_size(file.stat().st_size)})")


def say_json(data: Any) -> None:
    """Write data as JSON to standard output."""
    say(json.dumps(data, indent=2, allow_nan=False))


def write_json(path: str | os.PathLike[str], data: Any) -> Path:
    """Write data as JSON, whole or not at all."""
    file = Path(path)
    with whole_file(file) as partial:
        partial.write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", "utf-8")
    return file


def versions() -> dict[str, str]:
    """Return the versions of skinviz and of what its numbers depend on."""
    import platform
    from importlib.metadata import version

    from skinviz import __version__

    names = ("numpy", "scipy", "vtk", "pyvista", "pymeshlab", "matplotlib")
    return {
        "skinviz": __version__,
        "python": platform.python_version(),
        **{name: version(name) for name in names},
    }


def _size(n_bytes: int) -> str:
    """Return a file size in words."""
    return f"{n_bytes / 1e6:.1f} MB" if n_bytes >= 1e6 else f"{n_bytes / 1e3:.1f} kB"
