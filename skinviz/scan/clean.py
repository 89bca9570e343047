"""From a raw scan to a clean hand mesh, and a report of what was done.

The steps, in their order: views are made into patches, aligned and merged; what
welds fingers is cut and the wrist opened; the mesh is repaired, its islands go, its
holes are closed; it is remeshed, untangled and checked. A scan that is already a
mesh starts at the repair, oriented points at the merge. Other steps, or another
order, can be said; what there is, is in ``scan.steps``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from skinviz._validate import in_range
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checking import outwards
from skinviz.scan.meshlab import DEFAULT_TIMEOUT, Limits
from skinviz.scan.report import CleaningReport, Progress, Recorder
from skinviz.scan.scan import Scan
from skinviz.scan.steps import (
    KINDS,
    MESH_STEPS,
    POINT_STEPS,
    STEPS,
    Step,
    default_steps,
    require_order,
)
from skinviz.scan.workpiece import workpiece

if TYPE_CHECKING:
    import pyvista

__all__ = ["MESH_STEPS", "POINT_STEPS", "STEPS", "Step", "clean_scan"]


def clean_scan(
    scan: Scan,
    *,
    edge_length: float = 1.2,
    max_incidence: float = np.deg2rad(75),
    min_island: int = 200,
    steps: Sequence[Step | str] | None = None,
    timeout: float = DEFAULT_TIMEOUT,
    memory: float = 0.0,
    progress: Progress | None = None,
) -> tuple[pyvista.PolyData, CleaningReport]:
    """Make a manifold hand mesh, open only at the wrist, from a raw scan.

    Parameters
    ----------
    scan : Scan
        Range views, a mesh, or points with normals. [mm]
    edge_length : float
        Target length of the edges. [mm]
    max_incidence : float
        Triangles of a view seen at a larger angle are bridges. [rad]
    min_island : int
        Pieces of a view with fewer triangles are outliers.
    steps : sequence of Step or str, optional
        What is done, in this order; what a step says itself goes before the
        parameters above. By default :data:`STEPS`, for a mesh :data:`MESH_STEPS`,
        for points :data:`POINT_STEPS`.
    timeout : float
        Time after which a pymeshlab worker is stopped. [s]
    memory : float
        Most memory that a pymeshlab worker may hold; 0 for no bound. [GiB]
    progress : callable, optional
        Called with the name of each step as it begins.

    Returns
    -------
    mesh : pyvista.PolyData
        Triangles in mm, outward normals as point data ``Normals``. If ``"check"`` is
        the last step: one manifold component.
    report : CleaningReport
        Counts for each step.

    Raises
    ------
    ArgumentError
        If there is no such step or parameter, or a step lacks what it needs.
    MeshError
        If the scan is empty, not the size of a hand, or cannot be cleaned.

    Notes
    -----
    The first view's pose fixes the frame. The wrist is taken to be the largest
    opening; it is left open, cut plane where it was never measured, and every
    other hole is closed, unless that would join two fingers.
    """
    in_range(edge_length, 0.05, 20, "edge_length", "mm")
    given = {
        "max_incidence": in_range(
            max_incidence, 0.1, np.pi / 2, "max_incidence", "rad"
        ),
        "min_island": in_range(min_island, 0, 1e9, "min_island"),
    }
    limits = Limits(timeout, memory)
    piece = workpiece(scan)
    chosen = default_steps(scan) if steps is None else tuple(map(_step, steps))
    require_order(chosen, scan)
    recorder = Recorder(progress or (lambda _: None))
    for step in chosen:
        kind = KINDS[step.name]
        parameters = {
            **step.complete(edge_length),
            **{k: v for k, v in given.items() if k in kind.parameters},
            **step.parameters,
        }
        recorder.begin(step.name)
        piece, counts = kind.run(piece, limits, **parameters)
        recorder.end(step.name, **counts)
    if piece.surface is None or len(piece.surface.faces) == 0:
        raise MeshError(f"{piece.source}: the steps left no triangle")
    surface = outwards(piece.surface)
    mesh = topology.polydata(surface.points, surface.faces)
    mesh.point_data["Normals"] = topology.vertex_normals(surface.points, surface.faces)
    return mesh, CleaningReport(tuple(recorder.steps))


def _step(step: Step | str) -> Step:
    """Return a step, named or made."""
    return step if isinstance(step, Step) else Step(step)
