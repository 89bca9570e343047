"""What passes through itself is cut out, and what is as asked is left alone."""

import numpy as np
import pytest
import trimesh

from meshes import distance_to, joined, sphere, toy_hand
from skinviz.scan import topology
from skinviz.scan.mending import crossing_faces, drop_islands, remesh, untangle
from skinviz.scan.meshlab import NO_LIMITS
from skinviz.scan.topology import polydata
from skinviz.scan.workpiece import Surface


def surface_of(mesh):
    return Surface(*topology.arrays(mesh))


def pierced():
    """The toy hand with a point of its back drawn through the palm."""
    surface = surface_of(toy_hand())
    points = surface.points.copy()
    back = np.argmin(np.linalg.norm(points - (0, 16, 100), axis=1))
    points[back, 1] = -25.0
    return Surface(points, surface.faces)


def crossing_pairs(surface):
    """Faces near the spike that a brute-force edge-through-triangle test finds."""
    shape = trimesh.Trimesh(surface.points, surface.faces, process=False)
    edges, _ = topology.edge_counts(surface.faces)
    start, end = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
    corners = surface.points[surface.faces]
    found = set()
    spiky = np.flatnonzero(np.linalg.norm(end - start, axis=1) > 20)
    for i in spiky:
        a, b = start[i], end[i]
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        h = np.cross(b - a, v)
        det = np.einsum("ij,ij->i", u, h)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (a - corners[:, 0]) / det[:, None]
            x = np.einsum("ij,ij->i", s, h)
            q = np.cross(s, u)
            y, t = q @ (b - a), np.einsum("ij,ij->i", v, q)
            hit = (x > 0) & (y > 0) & (x + y < 1) & (t > 0) & (t < 1)
        hit &= ~np.isin(surface.faces, edges[i]).any(axis=1)
        found |= set(np.flatnonzero(hit))
    assert len(shape.faces) == len(surface.faces)
    return found


def test_faces_that_an_edge_passes_through_are_found():
    surface = pierced()
    through = crossing_pairs(surface)
    assert len(through) >= 1
    assert through <= set(np.flatnonzero(crossing_faces(surface, NO_LIMITS)))


def test_a_plain_shape_has_no_crossing_faces():
    assert not crossing_faces(surface_of(toy_hand()), NO_LIMITS).any()


def test_a_spike_through_the_palm_is_cut_out():
    cut, counts = untangle(pierced(), NO_LIMITS, max_width=50.0)
    assert counts["crossing_faces"] > 0
    assert counts["crossing_left"] == 0
    assert not crossing_faces(cut, NO_LIMITS).any()
    assert len(topology.boundary_loops(cut.faces)) == 1  # the wrist
    assert topology.n_non_manifold_edges(cut.faces) == 0
    assert distance_to(toy_hand(), cut.points).max() < 1.0


def test_a_fin_is_cut_out_and_the_surface_closed():
    points, faces = topology.arrays(toy_hand())
    back = np.argmin(np.linalg.norm(points[faces].mean(axis=1) - (0, 16, 100), axis=1))
    fin = [*faces[back, :2], len(points)]
    finned = Surface(
        np.vstack([points, points[faces[back, 0]] + (0, 3, 0)]), np.vstack([faces, fin])
    )
    cut, counts = untangle(finned, NO_LIMITS, max_width=50.0)
    assert counts["non_manifold_faces"] == 3
    assert topology.n_non_manifold_edges(cut.faces) == 0
    assert len(topology.boundary_loops(cut.faces)) == 1
    assert distance_to(toy_hand(), cut.points).max() < 1e-6


def test_untangling_a_plain_shape_changes_nothing():
    surface = surface_of(toy_hand())
    same, counts = untangle(surface, NO_LIMITS, max_width=50.0)
    assert set(counts.values()) == {0}
    assert same is surface


def test_the_piece_with_most_faces_is_kept():
    small, large = sphere(30, 2), sphere(10, 3, centre=(60, 0, 0))
    kept, counts = drop_islands(surface_of(joined(small, large)), NO_LIMITS)
    assert counts == {"islands": 1, "island_faces": small.n_cells}
    np.testing.assert_array_equal(kept.points, large.points)


@pytest.mark.parametrize("stretch", [0.7, 1.4])
def test_edges_of_another_length_are_remeshed(stretch):
    once, _ = remesh(surface_of(toy_hand()), NO_LIMITS, edge_length=5.0)
    again, counts = remesh(once, NO_LIMITS, edge_length=5.0)
    assert counts["as_asked_already"] == 1
    assert again is once
    _, other = remesh(once, NO_LIMITS, edge_length=5.0 * stretch)
    assert other["as_asked_already"] == 0
    assert other["mean_edge_mm"] == pytest.approx(5 * stretch, rel=0.15)


def test_long_thin_triangles_of_the_right_mean_are_remeshed():
    points, faces = topology.arrays(sphere(40, 3))
    squeezed = polydata(points * (1, 1, 0.15), faces)
    length = topology.edge_lengths(*topology.arrays(squeezed))
    _, counts = remesh(
        surface_of(squeezed), NO_LIMITS, edge_length=float(length.mean())
    )
    assert counts["as_asked_already"] == 0
