"""What ``skinviz info`` says of a scan or a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.checks import HAND_LENGTH, wrong_size
from skinviz.scan.scan import RangeView, Scan, transform

if TYPE_CHECKING:
    import pyvista


def scan_facts(scan: Scan) -> dict[str, Any]:
    """Return what a scan holds, by name, each as a line or a list of lines."""
    if scan.cloud is not None:
        points = scan.cloud.points
        normals = "without" if scan.cloud.normals is None else "with"
        told = "no grid or faces join them"
        return {"points": f"{len(points)}, {normals} normals; {told}", **_size(points)}
    if scan.mesh is not None:
        return _mesh(scan.mesh)
    placed = [transform(view.pose, view.points[view.valid]) for view in scan.views]
    return {
        "views": [_view(view) for view in scan.views],
        **_size(np.concatenate(placed)),
    }


def _view(view: RangeView) -> str:
    """Return a view's grid, and how its rays run."""
    rows, columns = view.valid.shape
    rays = "parallel rays" if view.eye is None else "rays from a point"
    returns = int(view.valid.sum())
    return f"{view.name}: {rows} x {columns} cells, {returns} returns, {rays}"


def _size(points: NDArray[np.float64]) -> dict[str, str]:
    """Return the extent of points, with a warning if it can be no hand's."""
    extent = " x ".join(f"{length:.1f}" for length in np.ptp(points, axis=0))
    told = wrong_size(points)
    warning = {} if told is None else {"size": f"it {told}; check the unit"}
    return {"extent": f"{extent} mm", **warning}


def _mesh(mesh: pyvista.PolyData) -> dict[str, Any]:
    """Return what a mesh is made of, and what is found of a hand in it."""
    points, faces = topology.arrays(mesh)
    return {
        "mesh": f"{len(points)} vertices, {len(faces)} triangles",
        **_size(points),
        "pieces": f"{int(topology.face_components(len(points), faces).max()) + 1}",
        "boundaries": f"{len(topology.boundary_loops(faces))}",
        "non-manifold edges": f"{topology.n_non_manifold_edges(faces)}",
        "hand": _hand(mesh),
    }


def _hand(mesh: pyvista.PolyData) -> str | list[str]:
    """Return which hand it is, its length, its wrist and how it lies."""
    from skinviz.scene.hand import measure_hand

    try:
        hand = measure_hand(mesh)
    except MeshError as error:
        return f"not recognised: {str(error).partition(';')[0]}"
    low, high = HAND_LENGTH
    usual = low <= hand.length <= high
    told = "" if usual else "; is it an adult's, is the unit right?"
    return [
        f"{hand.side}, {hand.length:.0f} mm from wrist to fingertip (adults: {low:g} "
        f"to {high:g}){told}",
        f"wrist: opening of {len(hand.wrist)} points, {hand.wrist_width:.1f} mm wide, "
        f"about {_rounded(hand.wrist_centre, 1)} mm, {hand.arm:.0f} mm up the arm",
        f"back: mean normal {_rounded(hand.frame.back, 3)}, the direction 0/0; "
        f"fingers towards {_rounded(hand.frame.fingers, 3)}",
    ]


def _rounded(vector: NDArray[np.float64], digits: int) -> list[float]:
    """Return a vector as it is printed."""
    return [float(x) + 0.0 for x in np.round(vector, digits)]
