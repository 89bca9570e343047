"""pymeshlab behind one function, in a process of its own.

pymeshlab can crash on bad input and is GPL: the worker process keeps both out
of ours. A crash, a time-out or an error comes back as a ``MeshError``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._system import require_system_libraries
from skinviz._validate import in_range
from skinviz.errors import MeshError
from skinviz.scan.topology import Faces, Points

DEFAULT_TIMEOUT = 600.0
"""Time after which a worker is stopped. [s]"""


@dataclass(frozen=True)
class Limits:
    """What one worker may take.

    Attributes
    ----------
    timeout : float
        Time after which it is stopped. [s]
    memory : float
        Most memory that it may hold; 0 for no bound. [GiB]
    """

    timeout: float = DEFAULT_TIMEOUT
    memory: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no time or no amount of memory."""
        in_range(self.timeout, 1e-3, 1e6, "timeout", "s")
        in_range(self.memory, 0, 1e6, "memory", "GiB")


_NO_PLACE = "no place for a temporary file ({}); free some, or set TMPDIR to another"

_NO_MEMORY = ("bad_alloc", "memory", "bad allocation")

NO_LIMITS = Limits()
"""No bound of memory, and the usual time."""


@dataclass(frozen=True)
class Filter:
    """One pymeshlab filter and its parameters.

    Attributes
    ----------
    name : str
        The filter's name in pymeshlab.
    parameters : dict
        Its parameters; a value ``{"length": x}`` is an absolute length. [mm]
    """

    name: str
    parameters: dict[str, Any]


@dataclass(frozen=True)
class FilterResult:
    """The current mesh after the filters, and which of its faces are selected."""

    points: Points
    faces: Faces
    selected: NDArray[np.bool_]


def run_filters(
    points: Points,
    faces: Faces,
    filters: Sequence[Filter],
    *,
    normals: NDArray[np.float64] | None = None,
    face_scalars: NDArray[np.float64] | None = None,
    limits: Limits = NO_LIMITS,
) -> FilterResult:
    """Run pymeshlab filters on one mesh in a worker process.

    Parameters
    ----------
    points, faces : (n, 3), (m, 3) ndarray
        The mesh; ``faces`` may be empty for a point cloud. [mm]
    filters : sequence of Filter
        Applied in turn to the current mesh.
    normals : (n, 3) ndarray, optional
        Point normals.
    face_scalars : (m,) ndarray, optional
        A number per face that filters can select by (``fq``).
    limits : Limits
        What the worker may take.

    Returns
    -------
    result : FilterResult
        The current mesh at the end.

    Raises
    ------
    MeshError
        If the worker fails, crashes or takes too long or too much.
    SystemLibraryError
        If a system library that pymeshlab loads is missing.
    """
    require_system_libraries("pymeshlab")
    names = ", ".join(f.name for f in filters)
    steps = [{"name": f.name, "parameters": f.parameters} for f in filters]
    job: dict[str, NDArray[Any]] = {
        "points": points,
        "faces": faces.astype(np.int32),
        "filters": np.frombuffer(json.dumps(steps).encode(), dtype=np.uint8),
    }
    if normals is not None:
        job["normals"] = normals
    if face_scalars is not None:
        job["face_scalars"] = face_scalars
    with _scratch() as question, _scratch() as answer:
        _write(question, job)
        _work(question, answer, names, limits)
        with np.load(answer) as result:
            return FilterResult(
                result["points"].astype(np.float64),
                result["faces"].astype(np.int64).reshape(-1, 3),
                result["selected"].astype(bool),
            )


def _scratch() -> IO[bytes]:
    """Return a file without a name, gone when closed: pipes take several times as long.

    Raises
    ------
    MeshError
        If there is no place for it.
    """
    try:
        return tempfile.TemporaryFile()
    except OSError as error:
        raise MeshError(_NO_PLACE.format(error)) from error


def _write(file: IO[bytes], arrays: dict[str, NDArray[Any]]) -> None:
    """Write arrays as an .npz file and go back to its start."""
    try:
        np.savez(file, **arrays)  # type: ignore[arg-type]
        file.seek(0)
    except OSError as error:
        raise MeshError(_NO_PLACE.format(error)) from error


def _work(question: IO[bytes], answer: IO[bytes], names: str, limits: Limits) -> None:
    """Have a worker answer a question; it ends before this returns."""
    worker = Path(__file__).with_name("_meshlab_worker.py")
    most = int(limits.memory * 2**30)
    try:
        done = subprocess.run(
            [sys.executable, str(worker), str(most)],
            stdin=question,
            stdout=answer,
            stderr=subprocess.PIPE,
            # Its threads would spin while they wait, which on shared cores
            # costs several times the work.
            env={"OMP_WAIT_POLICY": "passive", **os.environ},
            timeout=limits.timeout,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise MeshError(
            f"pymeshlab ({names}) took longer than {limits.timeout:g} s and was "
            "stopped; give it a coarser edge length or more time"
        ) from error
    # Both wrote at one place of the file: the worker moved it for us too.
    if done.returncode != 0 or answer.tell() == 0:
        raise MeshError(_failure(names, done.returncode, done.stderr, limits))
    answer.seek(0)


def _failure(names: str, code: int, stderr: bytes, limits: Limits) -> str:
    """Return one line that says how the worker ended."""
    lines = stderr.decode(errors="replace").strip().splitlines()
    said = lines[-1] if lines else "nothing said"
    if limits.memory and any(word in said.lower() for word in _NO_MEMORY):
        return (
            f"pymeshlab ({names}) needs more than the {limits.memory:g} GiB that it "
            "may take; give it a coarser edge length or more memory"
        )
    how = f"crashed with signal {-code}" if code < 0 else "failed"
    return (
        f"pymeshlab ({names}) {how}: {said}; the mesh is likely degenerate there: "
        "check it in MeshLab or leave out the view"
    )
