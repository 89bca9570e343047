"""Files written whole or not at all, and read with one clear refusal."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from skinviz.errors import SkinvizError


def existing_file(path: str | os.PathLike[str], error: type[SkinvizError]) -> Path:
    """Return the path of a readable, non-empty file or raise the given error."""
    file = Path(path)
    if not file.exists():
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
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent
        )
    except OSError as error:
        raise SkinvizError(f"cannot write {target}: {error.strerror}") from error
    os.close(handle)
    partial = Path(name)
    try:
        yield partial
        partial.chmod(0o666 & ~_umask())
        partial.replace(target)
    except OSError as error:
        raise SkinvizError(f"cannot write {target}: {error}") from error
    finally:
        partial.unlink(missing_ok=True)


def _umask() -> int:
    """Return the process's file mode mask, which mkstemp ignores."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
