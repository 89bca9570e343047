"""Named points follow from a hand's shape, whichever hand it is and however it lies."""

import numpy as np
import pytest
from hands import coarse_hand, mirrored

from meshes import joined, moved, pose, sphere, toy_hand
from skinviz import hand_frame, landmarks, read_mesh
from skinviz.errors import MeshError
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scene.geodesics import surface_of
from skinviz.scene.landmarks import FINGERS, GROUPS, NAMES


@pytest.fixture(scope="module")
def found():
    return landmarks(coarse_hand())


def places(mesh, found):
    return {name: np.asarray(mesh.points)[vertex] for name, vertex in found.items()}


def test_every_name_has_a_vertex_of_its_own(found):
    assert set(found) == set(NAMES)
    assert len(set(found.values())) == len(NAMES) == 41


def test_groups_are_made_of_names():
    assert {name for members in GROUPS.values() for name in members} <= set(NAMES)
    assert GROUPS["knuckle"] == tuple(f"{finger}_knuckle" for finger in FINGERS)


def test_fingertips_are_where_their_fingers_end(found):
    # By straight lines in the hand's frame, which the search does not use.
    mesh = coarse_hand()
    frame, points = hand_frame(mesh), np.asarray(mesh.points)
    at = places(mesh, found)
    for finger in FINGERS[1:]:
        near = np.linalg.norm(points - at[f"{finger}_fingertip"], axis=1) < 12
        reach = points[near] @ frame.fingers
        assert at[f"{finger}_fingertip"] @ frame.fingers > reach.max() - 1.5


def test_fingers_are_in_their_order_from_the_thumb(found):
    at, frame = places(coarse_hand(), found), hand_frame(coarse_hand())
    across = [at[f"{finger}_knuckle"] @ frame.side for finger in FINGERS]
    assert (np.diff(across) > 5).all()  # a right hand's thumb is on the left


@pytest.mark.parametrize("name", ["nail_bed", "joint", "knuckle", "pad", "finger_palm"])
def test_points_face_the_side_that_their_names_say(found, name):
    mesh = coarse_hand()
    surface, frame = surface_of(mesh), hand_frame(mesh)
    behind = 1 if name in ("nail_bed", "joint", "knuckle") else -1
    for finger in FINGERS[1:]:
        assert behind * surface.normals[found[f"{finger}_{name}"]] @ frame.back > 0.3


def test_the_points_between_wrist_and_knuckles_lie_in_their_order(found):
    at, frame = places(coarse_hand(), found), hand_frame(coarse_hand())
    along = {name: place @ frame.fingers for name, place in at.items()}
    assert along["wrist"] < along["back"] < along["middle_knuckle"]
    assert along["inner_wrist"] < along["palm"] < along["middle_finger_root"]
    assert (at["back"] - at["palm"]) @ frame.back > 15  # mm through the hand
    assert at["thenar"] @ frame.side < at["hypothenar"] @ frame.side


def test_the_other_hand_has_the_same_points_mirrored(found):
    own, other = (
        places(coarse_hand(), found),
        places(mirrored(coarse_hand()), landmarks(mirrored(coarse_hand()))),
    )
    for name, place in own.items():
        assert np.linalg.norm(place * [-1, 1, 1] - other[name]) < 4, name


def test_a_moved_hand_has_the_same_points(found):
    there = moved(coarse_hand(), pose([0.4, -1.1, 2.0], [300, -20, 1e3]))
    own, other = places(there, found), places(there, landmarks(there))
    for name, place in own.items():
        assert np.linalg.norm(place - other[name]) < 4, name


def test_a_finer_mesh_has_them_at_the_same_places(found):
    fine = read_mesh(shipped_mesh(TRUE_SHAPE), "m")
    own, other = places(coarse_hand(), found), places(fine, landmarks(fine))
    for name, place in own.items():
        assert np.linalg.norm(place - other[name]) < 8, name


@pytest.mark.parametrize(
    ("mesh", "message"),
    [(sphere(40, 3), "no opening"), (toy_hand(n_around=36, n_along=45), "fingers")],
)
def test_what_is_no_hand_is_refused(mesh, message):
    with pytest.raises(MeshError, match=message):
        landmarks(mesh)


def test_an_island_beside_the_hand_changes_nothing(found):
    away = np.asarray(coarse_hand().points).mean(axis=0) + np.array([60, 0, 0])
    assert landmarks(joined(coarse_hand(), sphere(3.0, 2, away))) == found
