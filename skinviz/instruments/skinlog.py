"""The log of a session: raw readings, one line each, on the disk before the next.

A line is a JSON object whose last member is the CRC-32 of the bytes before it. Lines
are only appended; what follows from readings is never in the log.
"""

from __future__ import annotations

import errno
import json
import os
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from skinviz._files import existing_file
from skinviz.errors import DataError, SkinvizError
from skinviz.instruments.records import require_records

SCHEMA = "skinlog 1"
"""What the first line says of the format."""

SUFFIX = ".skinlog"
"""Of the files."""

_MARK = b',"crc":"'
_END = len(_MARK) + len('01234567"}')


@dataclass(frozen=True, eq=False)
class SkinLog:
    """What a log holds.

    Attributes
    ----------
    header : dict
        Its first record.
    records : tuple of dict
        The others, in order.
    torn : int
        Bytes of a last line that was not written to its end. [bytes]
    """

    header: dict[str, Any]
    records: tuple[dict[str, Any], ...]
    torn: int


def line_of(record: Mapping[str, Any]) -> bytes:
    """Return a record as a line with its checksum."""
    body = json.dumps(record, allow_nan=False, separators=(",", ":")).encode("utf-8")[
        :-1
    ]
    return body + _MARK + b'%08x"}\n' % zlib.crc32(body)


def record_of(line: bytes) -> dict[str, Any] | None:
    """Return the record of a line, None if it is not whole."""
    body, tail = line[: -_END - 1], line[-_END - 1 :]
    if not tail.startswith(_MARK) or tail != _MARK + b'%08x"}\n' % zlib.crc32(body):
        return None
    try:
        record = json.loads(body + b"}")
    except ValueError:
        return None
    return record if isinstance(record, dict) else None


def read_log(path: str | os.PathLike[str]) -> SkinLog:
    """Read a session's log, also of one that was interrupted.

    Parameters
    ----------
    path : path-like
        A ``.skinlog``.

    Returns
    -------
    log : SkinLog
        All whole lines; at most the last may be torn.

    Raises
    ------
    DataError
        If the file is missing or no log, or another line than the last is damaged or
        lacks what is read of it; the message names it.
    """
    file = existing_file(path, DataError)
    try:
        lines = file.read_bytes().splitlines(keepends=True)
    except OSError as error:
        raise DataError(f"{file}: cannot be read: {error.strerror}") from error
    records: list[dict[str, Any]] = []
    torn = 0
    for at, line in enumerate(lines, start=1):
        record = record_of(line)
        if record is not None:
            records.append(record)
        elif at == len(lines) and at > 1:
            torn = len(line)
        else:
            raise DataError(
                f"{file} line {at}: damaged, its checksum is wrong; take the file from "
                "a backup"
                if records
                else f"{file}: not a session's log of skinviz measure"
            )
    header = records[0]
    if header.get("kind") != "header" or header.get("schema") != SCHEMA:
        raise DataError(
            f"{file}: written as {header.get('schema')!r}; this version reads {SCHEMA}"
        )
    require_records(file, records)
    return SkinLog(header, tuple(records[1:]), torn)


class LogWriter:
    """A log that is open for more records; only one program may have it so.

    Every record is on the disk when :meth:`append` returns.
    """

    def __init__(self, handle: int, path: Path) -> None:
        """Take an open file; use :meth:`create` or :meth:`reopen`."""
        self.path = path
        self._handle = handle

    @classmethod
    def create(cls, path: str | os.PathLike[str], header: Mapping[str, Any]) -> Self:
        """Begin a log.

        Raises
        ------
        SkinvizError
            If there is one of that name, or it cannot be written.
        """
        file = Path(path)
        if file.suffix != SUFFIX:
            raise SkinvizError(f"{file}: a session's log ends in {SUFFIX}; rename it")
        # Under another name until the header is on the disk: a log always has one.
        partial = file.with_name(f".{file.name}-{os.getpid()}")
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_TRUNC
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            handle = os.open(partial, flags, 0o666)
        except OSError as error:
            raise _unwritable(file, error) from error
        log = cls(handle, file)
        try:
            log._lock()
            log.append({"kind": "header", "schema": SCHEMA, **header})
            _rename_new(partial, file)
            _keep_names(file.parent)
        except BaseException as error:
            log.close()
            if isinstance(error, FileExistsError):
                raise SkinvizError(
                    f"{file} exists; go on with --resume, or name another file"
                ) from error
            if isinstance(error, OSError):
                raise _unwritable(file, error) from error
            raise
        finally:
            partial.unlink(missing_ok=True)
        return log

    @classmethod
    def reopen(cls, path: str | os.PathLike[str]) -> tuple[Self, SkinLog]:
        """Open a log to go on with; a torn last line is cut off.

        Returns
        -------
        writer : LogWriter
        log : SkinLog
            What it holds.

        Raises
        ------
        DataError
            As for :func:`read_log`.
        SkinvizError
            If another program has it open, or it cannot be written.
        """
        file = existing_file(path, DataError)
        try:
            handle = os.open(file, os.O_WRONLY | os.O_APPEND)
        except OSError as error:
            raise _unwritable(file, error) from error
        writer = cls(handle, file)
        try:
            writer._lock()
            log = read_log(file)
            if log.torn:
                os.ftruncate(handle, file.stat().st_size - log.torn)
                os.fsync(handle)
        except BaseException:
            writer.close()
            raise
        return writer, log

    def append(self, record: Mapping[str, Any]) -> None:
        """Write a record and wait until it is on the disk.

        Raises
        ------
        SkinvizError
            If it cannot be written; the log then ends with the record before.
        """
        line = line_of(record)
        size = os.fstat(self._handle).st_size
        try:
            if os.write(self._handle, line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(self._handle)
        except OSError as error:
            os.ftruncate(self._handle, size)
            raise SkinvizError(
                f"cannot write {self.path}: {error.strerror}; free some space and go "
                "on with --resume"
            ) from error

    def close(self) -> None:
        """Close the file and let others write."""
        os.close(self._handle)

    def __enter__(self) -> Self:
        """Return the log, which is open."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()

    def _lock(self) -> None:
        """Keep other programs from writing."""
        try:
            import fcntl
        except ImportError as error:  # logs are read on any system
            raise SkinvizError(
                f"cannot write {self.path}: this system cannot keep other programs "
                "from it; measure on Linux or macOS"
            ) from error
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise SkinvizError(
                f"{self.path} is being written by another program; end that first"
            ) from error


def _unwritable(file: Path, error: OSError) -> SkinvizError:
    """Return the error of a log that cannot be written."""
    return SkinvizError(f"cannot write {file}: {error.strerror}; check its folder")


def _rename_new(partial: Path, file: Path) -> None:
    """Give a file its name, unless there is one of that name."""
    try:
        os.link(partial, file)
    except FileExistsError:
        raise
    except OSError:  # sticks and shares that have no second names
        os.close(os.open(file, os.O_CREAT | os.O_EXCL))
        partial.replace(file)


def _keep_names(folder: Path) -> None:
    """Wait until the names in a folder are on the disk."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
