"""What the verbs have in common when they speak: progress, files, JSON."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinviz._files import whole_file
from skinviz.errors import SkinvizError

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID


class Steps:
    """The steps of a verb as they begin: a bar, or a line each, on standard error."""

    def __init__(self, n_steps: int) -> None:
        """Take the number of steps to come."""
        self._started = iter(range(1, n_steps + 1))
        self._n_steps = n_steps

    def __call__(self, name: str) -> None:
        """Begin the next step."""
        number = next(self._started, self._n_steps)
        sys.stderr.write(f"[{number}/{self._n_steps}] {name}\n")
        sys.stderr.flush()

    def counting(self, total: int) -> Callable[[int], None]:  # noqa: ARG002
        """Return what is told how many of a step's parts are done, of a total."""
        return lambda _: None


class _Bar(Steps):
    """Steps as a bar, under it a second one for the parts of a step."""

    def __init__(self, n_steps: int, bar: Progress) -> None:
        """Take the number of steps to come and what draws them."""
        super().__init__(n_steps)
        self._bar = bar
        self._steps = bar.add_task("", total=n_steps, completed=-1)
        self._parts: TaskID | None = None

    def __call__(self, name: str) -> None:
        """Begin the next step; that of the parts has ended."""
        self._end_parts()
        self._bar.update(self._steps, advance=1, description=name, refresh=True)

    def counting(self, total: int) -> Callable[[int], None]:
        """Return what is told how many of a step's parts are done, of a total."""
        self._end_parts()
        self._parts = parts = self._bar.add_task("", total=total)
        return lambda done: self._bar.update(parts, advance=done)

    def end(self) -> None:
        """Show that all is done."""
        self._end_parts()
        self._bar.update(self._steps, completed=self._n_steps, description="done")

    def _end_parts(self) -> None:
        """Take the bar of the parts away."""
        if self._parts is not None:
            self._bar.refresh()  # or a short step would end unseen
            self._bar.remove_task(self._parts)
            self._parts = None


@contextlib.contextmanager
def progress_bar(n_steps: int) -> Iterator[Steps]:
    """Show a bar on standard error; what it yields begins the next step.

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
        yield Steps(n_steps)
        return
    bar = Progress(
        TextColumn("{task.description:<28}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=console,
    )
    with bar:
        steps = _Bar(n_steps, bar)
        yield steps
        steps.end()


def require_folder(out: Path) -> None:
    """Refuse what can be no folder to write into, before there is anything to write.

    Raises
    ------
    SkinvizError
        If it is a file, or its name is none that a folder may have.
    """
    try:
        is_file = out.exists() and not out.is_dir()
    except OSError as error:  # a name longer than any file's, a closed folder
        raise SkinvizError(f"--out {out}: {error.strerror}; name another") from error
    if is_file:
        raise SkinvizError(f"--out {out} is a file; name a folder")


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
