"""Embree's nearest-hit queries on one mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from skinviz.scan import topology

Array = NDArray[np.float64]


class Caster:
    """What rays meet on a triangle mesh.

    Attributes
    ----------
    origin : (3,) ndarray
        The mean of the points. [mm]
    radius : float
        Distance of the farthest point from it. [mm]
    faces : (m, 3) ndarray
        Corners of the triangles.
    normals : (m, 3) ndarray
        Unit normals of the faces; zero where a face has no area.
    """

    def __init__(self, vertices: Array, faces: topology.Faces) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        # Near the origin float32 keeps a micrometre on a hand.
        self.origin = vertices.mean(axis=0)
        self.vertices = vertices - self.origin
        self.faces = faces
        self.radius = float(np.linalg.norm(self.vertices, axis=1).max())
        self._scene = EmbreeScene()
        TriangleMesh(
            self._scene,
            self.vertices.astype(np.float32),
            np.ascontiguousarray(faces, dtype=np.int32),
        )
        vectors = topology.face_vectors(self.vertices, faces)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        zero = np.zeros_like(vectors)
        self.normals = np.divide(vectors, length, out=zero, where=length > 0)

    def hits(self, origins: Array, directions: Array) -> tuple[Array, NDArray[np.int_]]:
        """Return distance (inf for none) and face index (-1) of nearest hits."""
        start = np.ascontiguousarray(origins - self.origin, dtype=np.float32)
        along = np.broadcast_to(directions.astype(np.float32), start.shape)
        result = self._scene.run(start, np.ascontiguousarray(along), output=True)
        face = result["primID"].astype(np.int_)
        distance = np.where(face >= 0, result["tfar"], np.inf)
        return distance.astype(np.float64), face

    def weights(self, places: Array, face: NDArray[np.int_]) -> Array:
        """Return the barycentric weights (n, 3) of places on faces."""
        a, b, c = (self.vertices[self.faces[face, k]] for k in range(3))
        at = places - self.origin
        whole = np.cross(b - a, c - a)
        area = np.einsum("ij,ij->i", whole, whole)
        area = np.where(area > 0, area, 1)
        second = np.einsum("ij,ij->i", np.cross(at - a, c - a), whole) / area
        third = np.einsum("ij,ij->i", np.cross(b - a, at - a), whole) / area
        return np.stack([1 - second - third, second, third], axis=1)
