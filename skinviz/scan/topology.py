"""Connectivity of triangle meshes: edges, boundary loops, components, normals.

Pure functions over ``(n, 3)`` points and ``(m, 3)`` faces; nothing here moves a
point or reads a file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyvista

Points = NDArray[np.float64]
Faces = NDArray[np.int64]
FaceMask = NDArray[np.bool_]

_FEW = 1000  # points tell how wide a loop is


def arrays(mesh: pyvista.PolyData) -> tuple[Points, Faces]:
    """Return a triangle mesh's points and faces as float64 and int64."""
    return (
        np.asarray(mesh.points, dtype=np.float64),
        np.asarray(mesh.regular_faces, dtype=np.int64).reshape(-1, 3),
    )


def polydata(points: Points, faces: Faces) -> pyvista.PolyData:
    """Return points and faces as a PolyData that keeps float64."""
    import pyvista as pv

    return pv.PolyData.from_regular_faces(
        np.ascontiguousarray(points, dtype=np.float64), faces
    )


def edge_counts(faces: Faces) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the undirected edges (k, 2) and how many faces share each."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    if len(edges) == 0:
        return edges, np.zeros(0, dtype=np.int64)
    # One integer per edge sorts an order of magnitude faster than rows do.
    base = int(edges.max()) + 1
    keys, counts = np.unique(edges[:, 0] * base + edges[:, 1], return_counts=True)
    return np.stack(np.divmod(keys, base), axis=1), counts


def edge_lengths(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return the length of each undirected edge, in the order of ``edge_counts``."""
    edges, _ = edge_counts(faces)
    return np.asarray(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1))


def boundary_edges(faces: Faces) -> NDArray[np.int64]:
    """Return the edges (k, 2) that only one face has."""
    edges, counts = edge_counts(faces)
    return np.asarray(edges[counts == 1])


def n_non_manifold_edges(faces: Faces) -> int:
    """Return how many edges more than two faces share."""
    return int((edge_counts(faces)[1] > 2).sum())


def components(n_points: int, edges: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return each point's component label, from the edges (k, 2) that join them."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(edges), dtype=bool)
    graph = coo_matrix((ones, (edges[:, 0], edges[:, 1])), (n_points, n_points))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def face_components(n_points: int, faces: Faces) -> NDArray[np.int64]:
    """Return each face's component label, numbered from 0."""
    labels = components(n_points, faces[:, [0, 1, 1, 2]].reshape(-1, 2))[faces[:, 0]]
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def largest_piece(n_points: int, faces: Faces) -> Faces:
    """Return the faces of the connected piece with the most triangles."""
    labels = face_components(n_points, faces)
    return np.asarray(faces[labels == np.bincount(labels).argmax()])


def boundary_loops(faces: Faces) -> list[NDArray[np.int64]]:
    """Return the points of each connected boundary, largest first (unordered)."""
    edges = boundary_edges(faces)
    if len(edges) == 0:
        return []
    used, local = np.unique(edges, return_inverse=True)
    labels = components(used.size, local.reshape(-1, 2))
    loops = [used[labels == label] for label in range(labels.max() + 1)]
    return sorted(loops, key=len, reverse=True)


def widest(points: Points) -> float:
    """Return the largest distance between two points of a loop."""
    few = points[:: max(1, len(points) // _FEW)]
    return float(np.linalg.norm(few[:, None] - few, axis=-1).max())


def compact(points: Points, faces: Faces) -> tuple[Points, Faces]:
    """Drop points that no face uses."""
    used, inverse = np.unique(faces, return_inverse=True)
    return points[used], inverse.reshape(-1, 3).astype(np.int64)


def face_vectors(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return each face's normal (m, 3), its length twice the face's area."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a))


def face_areas(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return each face's area, shape (m,)."""
    length = np.linalg.norm(face_vectors(points, faces), axis=1)
    return np.asarray(length / 2)


def vertex_normals(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return area-weighted unit normals (n, 3); zero where no face has area."""
    vectors = face_vectors(points, faces)
    summed = np.zeros_like(points)
    for axis in range(3):
        for corner in range(3):
            summed[:, axis] += np.bincount(
                faces[:, corner], vectors[:, axis], minlength=len(points)
            )
    length = np.linalg.norm(summed, axis=1, keepdims=True)
    zero = np.zeros_like(summed)
    return np.asarray(np.divide(summed, length, out=zero, where=length > 0))


def enclosed_volume(points: Points, faces: Faces) -> float:
    """Return the signed volume, a boundary closed by a cone to the centroid."""
    a, b, c = (points[faces[:, k]] - points.mean(axis=0) for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
