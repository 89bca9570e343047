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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._system import require_system_libraries
from skinviz.errors import MeshError
from skinviz.scan.topology import Faces, Points

DEFAULT_TIMEOUT = 600.0
"""Time after which a worker is stopped. [s]"""


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
    """The current mesh after the filters."""

    points: Points
    faces: Faces


def run_filters(
    points: Points,
    faces: Faces,
    filters: Sequence[Filter],
    *,
    normals: NDArray[np.float64] | None = None,
    face_scalars: NDArray[np.float64] | None = None,
    timeout: float = DEFAULT_TIMEOUT,
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
    timeout : float
        Time after which the worker is stopped. [s]

    Returns
    -------
    result : FilterResult
        The current mesh at the end.

    Raises
    ------
    MeshError
        If the worker fails, crashes or takes too long.
    SystemLibraryError
        If a system library that pymeshlab loads is missing.
    """
    require_system_libraries("pymeshlab")
    names = ", ".join(f.name for f in filters)
    # The folder goes with the block, whatever happens to the worker.
    with tempfile.TemporaryDirectory(prefix="skinviz-") as folder:
        job = Path(folder)
        inputs = {"points": points, "faces": faces}
        if normals is not None:
            inputs["normals"] = normals
        if face_scalars is not None:
            inputs["face_scalars"] = face_scalars
        np.savez(job / "input.npz", **inputs)  # type: ignore[arg-type]
        steps = [{"name": f.name, "parameters": f.parameters} for f in filters]
        (job / "filters.json").write_text(json.dumps(steps), encoding="utf-8")
        worker = Path(__file__).with_name("_meshlab_worker.py")
        try:
            done = subprocess.run(
                [sys.executable, str(worker), str(job)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                # Its threads would spin while they wait, which on shared cores
                # costs several times the work.
                env={"OMP_WAIT_POLICY": "passive", **os.environ},
                timeout=timeout,
                check=False,
            )
        except subprocess.TimeoutExpired as error:
            raise MeshError(
                f"pymeshlab ({names}) took longer than {timeout:g} s and was "
                "stopped; give it a coarser edge length or more time"
            ) from error
        if done.returncode != 0 or not (job / "output.npz").exists():
            raise MeshError(_failure(names, done.returncode, done.stderr))
        with np.load(job / "output.npz") as result:
            out_points = result["points"].astype(np.float64)
            out_faces = result["faces"].astype(np.int64).reshape(-1, 3)
    return FilterResult(out_points, out_faces)


def _failure(names: str, code: int, stderr: bytes) -> str:
    """Return one line that says how the worker ended."""
    lines = stderr.decode(errors="replace").strip().splitlines()
    said = lines[-1] if lines else "nothing said"
    how = f"crashed with signal {-code}" if code < 0 else "failed"
    return (
        f"pymeshlab ({names}) {how}: {said}; the mesh is likely degenerate there: "
        "check it in MeshLab or leave out the view"
    )
