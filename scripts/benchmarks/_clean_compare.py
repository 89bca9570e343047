"""How far a cleaned hand lies from the true one, and what is wrong with it."""

from dataclasses import dataclass

import numpy as np
import pyvista as pv
from scipy.spatial import cKDTree

from skinviz.scan import topology
from skinviz.scan.checks import require_triangles
from skinviz.scan.wrist import wrist_loop

FAR = 1.0  # mm; surface this far from the true one is made up


@dataclass(frozen=True)
class Difference:
    """A cleaned mesh against the truth.

    Attributes
    ----------
    rms, most, nearly_all, largest : float
        Root mean square, 95 %, 99 % and maximum of the distance. [mm]
    normal : float
        Median angle between the normals. [deg]
    holes : int
        Boundaries beside the wrist.
    handles : int
        Welds that close a ring, as two fingers grown together do.
    made_up : float
        Area farther than 1 mm from the truth. [mm²]
    volume : float
        Relative error of the volume on the hand's side of the cleaned wrist. [1]
    covered : float
        Share of the truth, 5 mm from its wrist on, within 0.5 mm. [1]
    """

    rms: float
    most: float
    nearly_all: float
    largest: float
    normal: float
    holes: int
    handles: int
    made_up: float
    volume: float
    covered: float


def compare(mesh: pv.PolyData, truth: pv.PolyData) -> Difference:
    """Return the differences between a cleaned mesh and the shape it is of."""
    points, faces = topology.arrays(mesh)
    true_points, true_faces = require_triangles(truth, "truth")
    gap = distance(points, truth)
    cells, _ = truth.find_closest_cell(points, return_closest_point=True)
    vectors = topology.face_vectors(true_points, true_faces)[cells]
    cosine = np.einsum("ij,ij->i", vectors, topology.vertex_normals(points, faces))
    cosine /= np.linalg.norm(vectors, axis=1)
    far = distance(points[faces].mean(axis=1), truth) > FAR
    edges, _ = topology.edge_counts(faces)
    euler = len(points) - len(edges) + len(faces)
    loops = topology.boundary_loops(faces)
    rim = true_points[topology.boundary_loops(true_faces)[0]]
    inside = cKDTree(rim).query(true_points)[0] > 5
    covered = distance(true_points[inside], mesh) < 0.5
    return Difference(
        rms=float(np.sqrt((gap**2).mean())),
        most=float(np.percentile(gap, 95)),
        nearly_all=float(np.percentile(gap, 99)),
        largest=float(gap.max()),
        normal=float(np.rad2deg(np.median(np.arccos(np.clip(cosine, -1, 1))))),
        holes=max(len(loops) - 1, 0),
        handles=(2 - euler - len(loops)) // 2,
        made_up=float(topology.face_areas(points, faces)[far].sum()),
        volume=_volume_error(points, faces, truth),
        covered=float(covered.mean()),
    )


def distance(points: np.ndarray, surface: pv.PolyData) -> np.ndarray:
    """Return the distance of points to a surface, by VTK. [mm]"""
    bare = topology.polydata(*topology.arrays(surface))
    cloud = pv.PolyData(points).compute_implicit_distance(bare)
    return np.abs(np.asarray(cloud["implicit_distance"]))


def _volume_error(points: np.ndarray, faces: np.ndarray, truth: pv.PolyData) -> float:
    """Return the relative error of the volume beyond the cleaned wrist's plane."""
    loop = wrist_loop(points, faces)
    if loop is None:
        return float("nan")
    centre = points[loop].mean(axis=0)
    _, axes = np.linalg.eigh((points[loop] - centre).T @ (points[loop] - centre))
    normal = axes[:, 0] * np.sign((points.mean(axis=0) - centre) @ axes[:, 0])
    origin = centre + 3.0 * normal  # the rim is not quite plane
    volumes = []
    for mesh in (topology.polydata(points, faces), truth):
        half = mesh.clip(normal=-normal, origin=origin).triangulate()
        half_points, half_faces = topology.arrays(half)
        a, b, c = (half_points[half_faces[:, k]] - origin for k in range(3))
        # Seen from a point of the plane its own cut adds no volume.
        volumes.append(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    return float(volumes[0] / volumes[1] - 1)
