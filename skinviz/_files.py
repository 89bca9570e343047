"""Files written whole or not at all, and read with one clear refusal."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from skinviz.errors import SkinvizError

_NAMED = 2  # files that one error names
_FULL = "free some space there or write to another disk"
_FORBIDDEN = "write to a folder that you may write to"
_ADVICE = {
    errno.ENOSPC: _FULL,
    errno.EDQUOT: _FULL,
    errno.EFBIG: "write to a disk that holds larger files, or raise the limit (ulimit)",
    errno.EACCES: _FORBIDDEN,
    errno.EPERM: _FORBIDDEN,
    errno.EROFS: _FORBIDDEN,
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.EISDIR: "give the name of a file",
}


def existing_file(path: str | os.PathLike[str], error: type[SkinvizError]) -> Path:
    """Return the path of a readable, non-empty file or raise the given error."""
    file = Path(path)
    try:
        found = file.exists()
    except OSError as fault:  # a name longer than any file's, a folder that is closed
        raise error(f"{file}: {fault.strerror}; check the path") from fault
    if not found:
        raise error(f"{file}: no such file; check the path")
    if not file.is_file():
        raise error(f"{file}: is a folder, a file is expected")
    if file.stat().st_size == 0:
        raise error(f"{file}: the file is empty")
    if not os.access(file, os.R_OK):
        raise error(f"{file}: may not be read; check its permissions")
    return file


@contextlib.contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside ``path``; on success it takes its name.

    The suffix is kept, because libraries choose the format by it. On any error
    the temporary file is removed and ``path`` is left as it was.
    """
    with whole_files(path) as (partial,):
        yield partial


@contextlib.contextmanager
def whole_files(*paths: str | os.PathLike[str]) -> Iterator[tuple[Path, ...]]:
    """Yield temporary paths of files that belong together, as :func:`whole_file` does.

    On success they take their names in the order given. On any error, also one
    while the names are taken, all of ``paths`` are left as they were.
    """
    targets = [Path(path) for path in paths]
    partials: list[Path] = []
    try:
        for target in targets:
            partials.append(_partial(target))  # noqa: PERF401, what is made is removed
        yield tuple(partials)
        _take_names(partials, targets)
    except OSError as error:
        names = " and ".join(map(str, targets[:_NAMED]))
        if len(targets) > _NAMED:
            names += f" and {len(targets) - _NAMED} more"
        raise SkinvizError(f"cannot write {names}: {_told(error)}") from error
    finally:
        for partial in partials:
            partial.unlink(missing_ok=True)


def _partial(target: Path) -> Path:
    """Return a new file beside a target that may become a file."""
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, "it is a folder")
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(
        prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent
    )
    os.close(handle)
    return Path(name)


def _take_names(partials: Sequence[Path], targets: Sequence[Path]) -> None:
    """Give every file its name or, where one cannot have it, none."""
    last = targets[-1]
    former: list[tuple[Path, Path | None]] = []
    try:
        for partial, target in zip(partials, targets, strict=True):
            partial.chmod(0o666 & ~_umask())
            if target is not last:  # after the last there is nothing to fail
                former.append((target, _set_aside(target, partial)))
            partial.replace(target)
    except BaseException:
        for target, kept in reversed(former):
            if kept is not None:
                kept.replace(target)
            else:
                target.unlink(missing_ok=True)
        raise
    for _, kept in former:
        if kept is not None:
            kept.unlink()


def _set_aside(target: Path, partial: Path) -> Path | None:
    """Return the name that an existing file is kept under meanwhile."""
    if not target.exists():
        return None
    return target.replace(partial.with_name(f"{partial.name}~"))


def _told(error: OSError) -> str:
    """Return what went wrong and what to do about it."""
    what = error.strerror or str(error)
    advice = _ADVICE.get(error.errno or 0, "check the folder and its free space")
    return f"{what}; {advice}"


def _umask() -> int:
    """Return the process's file mode mask, which mkstemp ignores."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
