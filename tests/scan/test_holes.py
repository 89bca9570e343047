"""Holes are closed, but neither the wrist nor the gap between two fingers."""

import numpy as np
import pytest
import pyvista as pv

from meshes import face_centres, plane, sphere, toy_hand, without_faces
from skinviz.scan import holes, topology
from skinviz.scan.holes import close_holes
from skinviz.scan.meshlab import NO_LIMITS
from skinviz.scan.workpiece import Surface

GAP = 0.3
"""Half the angle that is missing of the ring: two fingertips, face to face. [rad]"""


def ring():
    """A torus, and which of its faces lie in the gap."""
    shape = pv.ParametricTorus(ringradius=30, crosssectionradius=8).triangulate()
    points, faces = topology.arrays(shape.clean())
    angle = np.arctan2(*points[faces].mean(axis=1)[:, [1, 0]].T)
    return points, faces, np.abs(angle) < GAP


def cut(mesh, *where):
    """A mesh with holes about places, each (centre, radius)."""
    for centre, radius in where:
        near = np.linalg.norm(face_centres(mesh) - centre, axis=1) < radius
        mesh = without_faces(mesh, near)
    return Surface(*topology.compact(*topology.arrays(mesh)))


def strip_between(points, rims):
    """Faces that join each point of one rim to the nearest of the other."""
    first, second = rims
    gaps = np.linalg.norm(points[second][None] - points[first][:, None], axis=2)
    other = second[np.argmin(gaps, axis=1)]
    around = np.argsort(np.arctan2(*(points[first] - points[first].mean(0))[:, 1:].T))
    first, other = first[around], other[around]
    lower = np.stack([first[:-1], first[1:], other[:-1]], axis=1)
    upper = np.stack([first[1:], other[1:], other[:-1]], axis=1)
    faces = np.concatenate([lower, upper])
    return faces[(faces[:, 1] != faces[:, 2])]


@pytest.mark.parametrize("capped", [True, False])
def test_what_joins_two_fingertips_is_a_weld(capped):
    points, faces, gap = ring()
    old = faces[~gap]
    rims = topology.boundary_loops(old)
    assert len(rims) == 2
    strip = strip_between(points, rims)
    if capped:  # the ends look at each other, so that they need not be far apart
        surface = Surface(points, old)
        surface, _ = close_holes(surface, NO_LIMITS, max_width=1e3, cap_wrist=True)
        points, old = surface.points, surface.faces
    both = np.concatenate([old, strip])
    new = np.arange(len(both)) >= len(old)
    far = 1e4 if capped else 100.0
    np.testing.assert_array_equal(holes._welds(points, both, new, far), new)
    nowhere = holes._welds(points, both, np.zeros(len(both), dtype=bool), far)
    assert not nowhere.any()


def test_the_way_around_a_slit_does_not_make_it_a_weld():
    # 40 mm long and one row of faces wide: the way around it is many times its width.
    whole = plane(81, 80.0)
    centres = np.abs(face_centres(whole))
    slit = without_faces(whole, (centres[:, 0] < 20) & (centres[:, 1] < 1))
    closed, counts = close_holes(
        Surface(*topology.arrays(slit)), NO_LIMITS, max_width=50.0
    )
    assert (counts["holes"], counts["holes_left"], counts["welds_refused"]) == (1, 0, 0)
    area = topology.face_areas(closed.points, closed.faces).sum()
    assert area == pytest.approx(80.0**2, rel=1e-9)


def test_caps_of_two_fingertips_are_no_weld():
    points, faces, gap = ring()
    open_ring = Surface(*topology.compact(points, faces[~gap]))
    closed, counts = close_holes(open_ring, NO_LIMITS, max_width=1e3, cap_wrist=True)
    assert counts["welds_refused"] == 0
    assert topology.boundary_loops(closed.faces) == []
    edges, _ = topology.edge_counts(closed.faces)
    euler = len(np.unique(closed.faces)) - len(edges) + len(closed.faces)
    assert euler == 2  # a ball: the ends have not grown together, or it were a ring


def test_a_hole_beside_the_wrist_is_left_to_it():
    # A face that two rims share marks neither of them: the wrist stays open.
    surface = cut(toy_hand(), ((0, 16, 60), 9), ((0, -16, 8), 6))
    _, counts = close_holes(surface, NO_LIMITS, max_width=50.0)
    loops = topology.boundary_loops(surface.faces)
    assert counts["holes"] == len(loops) - 1
    assert counts["holes_left"] == 0


@pytest.mark.parametrize("radius", [4.0, 8.0, 14.0])
def test_holes_of_a_convex_shape_are_closed(radius):
    surface = cut(sphere(60, 4), ((0, 0, 60), 30.0), ((0, 60, 0), radius))
    closed, counts = close_holes(surface, NO_LIMITS, max_width=50.0)
    assert (counts["holes"], counts["holes_left"], counts["welds_refused"]) == (1, 0, 0)
    assert len(topology.boundary_loops(closed.faces)) == 1
    assert counts["faces_added"] == len(closed.faces) - len(surface.faces) > 0


@pytest.mark.parametrize(("most", "closed"), [(15.0, 0), (25.0, 1)])
def test_a_hole_that_is_wider_than_is_said_stays_open(most, closed):
    surface = cut(sphere(60, 5), ((0, 0, 60), 30.0), ((0, 60, 0), 9.5))
    _, counts = close_holes(surface, NO_LIMITS, max_width=most)
    assert counts["holes"] == 1
    assert counts["holes_left"] == 1 - closed
