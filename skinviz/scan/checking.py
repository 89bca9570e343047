"""The last step: what is promised of a clean mesh, counted and insisted on."""

from __future__ import annotations

import numpy as np

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.mending import crossing_faces
from skinviz.scan.meshlab import Limits
from skinviz.scan.topology import Points
from skinviz.scan.workpiece import Counts, Surface


def check(surface: Surface, limits: Limits) -> tuple[Surface, Counts]:
    """Turn the faces outwards and refuse what is not one manifold piece, open once."""
    surface = outwards(surface)
    points, faces = surface.points, surface.faces
    bad = topology.n_non_manifold_edges(faces)
    n_components = int(topology.face_components(len(points), faces).max()) + 1
    n_loops = len(topology.boundary_loops(faces))
    if bad or n_components != 1 or n_loops > 1:
        raise MeshError(
            f"cleaning left {bad} non-manifold edges, {n_components} components and "
            f"{n_loops} boundaries (0, 1 and at most 1 expected); try a smaller edge "
            "length, inspect the raw views, or say steps that close longer holes"
        )
    counts: Counts = {
        "non_manifold_edges": bad,
        "components": n_components,
        "boundaries": n_loops,
        "crossing_faces": int(crossing_faces(surface, limits).sum()),
        "length_mm": round(float(np.ptp(_principal(points)[:, 0])), 1),
        "area_mm2": round(float(topology.face_areas(points, faces).sum()), 1),
    }
    return surface, counts


def outwards(surface: Surface) -> Surface:
    """Return the surface with its faces turned outwards."""
    if topology.enclosed_volume(surface.points, surface.faces) >= 0:
        return surface
    return Surface(surface.points, surface.faces[:, ::-1])


def _principal(points: Points) -> Points:
    """Return points in their principal frame, longest axis first."""
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    return np.asarray(centred @ axes[:, ::-1])
