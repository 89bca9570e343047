"""A hand's directions follow from its shape alone."""

import numpy as np
import pytest
import pyvista as pv

from meshes import (
    face_centres,
    moved,
    plane,
    pose,
    sphere,
    tetrahedron,
    toy_hand,
    tube,
    wave,
    with_forearm,
    without_faces,
)
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.formats import read_mesh
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scan.topology import polydata
from skinviz.scene import HandFrame, hand_frame, measure_hand


@pytest.fixture(scope="module")
def male():
    return read_mesh(shipped_mesh(TRUE_SHAPE), "m")


def angle(a, b):
    """Angle between unit vectors. [degrees]"""
    return np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def mirrored(mesh):
    """The other hand: mirrored, its faces turned outwards again."""
    points, faces = topology.arrays(mesh)
    return polydata(points * [-1.0, 1, 1], faces[:, [0, 2, 1]])


@pytest.mark.parametrize("shape", ["male", "toy"])
def test_the_frame_is_right_handed_and_orthonormal(male, shape):
    frame = hand_frame(male if shape == "male" else toy_hand())
    axes = np.stack([frame.side, frame.fingers, frame.back])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(
        np.cross(frame.fingers, frame.back), frame.side, atol=1e-12
    )


def test_the_toy_hand_lies_as_it_was_made():
    frame = hand_frame(toy_hand())
    assert angle(frame.fingers, [0, 0, 1]) < 5
    assert angle(frame.back, [0, 1, 0]) < 8
    assert angle(frame.side, [-1, 0, 0]) < 8


def test_fingers_point_away_from_the_wrist(male):
    frame = hand_frame(male)
    points, faces = topology.arrays(male)
    wrist = points[topology.boundary_loops(faces)[0]].mean(axis=0)
    reach = (points - wrist) @ frame.fingers
    assert reach.max() > 150
    assert reach.min() > -20


def test_the_thumb_is_on_the_viewers_side_that_a_right_hand_has(male):
    # Seen from its back with fingers up, a right hand's thumb is on the left.
    frame = hand_frame(male)
    points, faces = topology.arrays(male)
    wrist = points[topology.boundary_loops(faces)[0]].mean(axis=0)
    reach = (points - wrist) @ frame.fingers
    middle = (reach > 30) & (reach < 0.7 * reach.max())
    across = (points[middle] - wrist) @ frame.side
    assert across.min() < -60
    assert across.max() < 0.8 * abs(across.min())


def test_the_back_is_the_mean_normal_of_the_back(male):
    # An independent count: most of the metacarpal surface faces to or fro.
    frame = hand_frame(male)
    points, faces = topology.arrays(male)
    vectors = topology.face_vectors(points, faces)
    wrist = points[topology.boundary_loops(faces)[0]].mean(axis=0)
    reach = (points[faces].mean(axis=1) - wrist) @ frame.fingers
    metacarpus = (reach > 0.2 * reach.max()) & (reach < 0.4 * reach.max())
    unit = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    back = metacarpus & (unit @ frame.back > np.cos(np.deg2rad(40)))
    mean = vectors[back].sum(axis=0)
    assert angle(mean / np.linalg.norm(mean), frame.back) < 12


@pytest.mark.parametrize("seed", range(4))
def test_the_frame_turns_with_the_hand(male, seed):
    rng = np.random.default_rng(seed)
    motion = pose(rng.uniform(-np.pi, np.pi, 3), rng.uniform(-900, 900, 3))
    here, there = hand_frame(male), hand_frame(moved(male, motion))
    for name in ("back", "fingers", "side"):
        np.testing.assert_allclose(
            getattr(there, name), motion[:3, :3] @ getattr(here, name), atol=1e-9
        )


@pytest.mark.parametrize("shape", ["male", "toy"])
def test_the_other_hand_has_the_mirrored_back_and_fingers(male, shape):
    mesh = male if shape == "male" else toy_hand()
    here, there = hand_frame(mesh), hand_frame(mirrored(mesh))
    mirror = np.array([-1.0, 1, 1])
    np.testing.assert_allclose(there.back, mirror * here.back, atol=1e-9)
    np.testing.assert_allclose(there.fingers, mirror * here.fingers, atol=1e-9)
    # A cross product of mirrored vectors is mirrored and reversed.
    np.testing.assert_allclose(there.side, -mirror * here.side, atol=1e-9)


def test_scale_and_order_of_points_do_not_matter(male):
    points, faces = topology.arrays(male)
    order = np.random.default_rng(0).permutation(len(points))
    rank = np.argsort(order)
    shuffled = hand_frame(polydata(0.5 * points[order], rank[faces]))
    np.testing.assert_allclose(shuffled.back, hand_frame(male).back, atol=1e-9)
    np.testing.assert_allclose(shuffled.fingers, hand_frame(male).fingers, atol=1e-9)


def test_which_corner_of_a_triangle_comes_first_does_not_matter(male):
    points, faces = topology.arrays(male)
    rolled = hand_frame(polydata(points, np.roll(faces, 1, axis=1)))
    np.testing.assert_allclose(rolled.back, hand_frame(male).back, atol=1e-9)


def test_finer_triangles_at_the_fingertips_do_not_turn_the_frame(male):
    points, faces = topology.arrays(male)
    frame = hand_frame(male)
    for _ in range(2):  # each triangle near the tips becomes three, twice
        middles = points[faces].mean(axis=1)
        fine = middles @ frame.fingers > np.quantile(points @ frame.fingers, 0.6)
        new = len(points) + np.arange(fine.sum())
        a, b, c = faces[fine].T
        split = [np.stack(t, axis=1) for t in ((a, b, new), (b, c, new), (c, a, new))]
        points = np.concatenate([points, middles[fine]])
        faces = np.concatenate([faces[~fine], *split])
    other = hand_frame(polydata(points, faces))
    assert angle(other.fingers, frame.fingers) < 0.1
    assert angle(other.back, frame.back) < 0.1


def test_the_wrist_is_the_widest_opening_not_that_with_most_points():
    mesh = toy_hand()
    hole = np.linalg.norm(face_centres(mesh) - [0, 16, 120], axis=1) < 24
    holed = without_faces(mesh, hole)
    points, faces = topology.arrays(holed)
    first, second = topology.boundary_loops(faces)
    assert np.ptp(points[first], axis=0).max() < np.ptp(points[second], axis=0).max()
    assert angle(hand_frame(holed).fingers, [0, 0, 1]) < 8


def test_directions_lean_left_for_positive_angles():
    frame = HandFrame(*(np.array(v, dtype=float) for v in np.eye(3)[[2, 1, 0]]))
    np.testing.assert_allclose(frame.direction(0.0), frame.back)
    np.testing.assert_allclose(
        frame.direction(np.deg2rad(60)), [-np.sqrt(3) / 2, 0, 0.5], atol=1e-15
    )
    np.testing.assert_allclose(frame.direction(-np.pi / 2), frame.side, atol=1e-15)
    for degrees in (-80, -10, 25, 90):
        direction = frame.direction(np.deg2rad(degrees))
        assert angle(direction, frame.back) == pytest.approx(abs(degrees))
        assert np.linalg.norm(direction) == pytest.approx(1)


@pytest.mark.parametrize("make", [sphere, tetrahedron])
def test_a_closed_mesh_has_no_wrist(make):
    with pytest.raises(MeshError, match="no opening at the wrist"):
        hand_frame(make())


def test_a_tube_has_no_thumb():
    with pytest.raises(MeshError, match="no thumb"):
        hand_frame(tube(20, 160))


def test_a_thumbless_mitten_has_no_thumb():
    points, faces = topology.arrays(toy_hand())
    points[:, 0] = np.clip(points[:, 0], -42, 42)
    with pytest.raises(MeshError, match="no thumb"):
        hand_frame(polydata(points, faces))


def test_points_alone_are_no_hand():
    with pytest.raises(MeshError, match="no faces"):
        hand_frame(pv.PolyData(np.asarray(toy_hand().points)))


def test_the_shipped_hand_is_a_right_one_of_its_makers_length(male):
    hand = measure_hand(male)
    assert hand.side == "right"
    # Its maker's skeleton has 198 mm from the wrist's joint to the fingertip.
    assert hand.length == pytest.approx(198, abs=12)
    assert hand.length + hand.arm == pytest.approx(232.6, abs=1)
    assert 50 < hand.wrist_width < 60


@pytest.mark.parametrize("shape", ["male", "toy"])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("outwards", [True, False])
def test_a_mirror_makes_the_other_hand(male, shape, axis, outwards):
    mesh = male if shape == "male" else toy_hand()
    points, faces = topology.arrays(mesh)
    mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
    here = measure_hand(mesh)
    faces = faces[:, ::-1] if outwards else faces
    there = measure_hand(polydata(points * mirror, faces))
    assert {here.side, there.side} == {"left", "right"}
    assert there.length == pytest.approx(here.length, rel=0.05)
    assert there.wrist_width == pytest.approx(here.wrist_width)


@pytest.mark.parametrize("seed", range(3))
def test_how_a_hand_lies_does_not_change_which_it_is(male, seed):
    rng = np.random.default_rng(seed)
    motion = pose(rng.uniform(-np.pi, np.pi, 3), rng.uniform(-900, 900, 3))
    here, there = measure_hand(male), measure_hand(moved(male, motion))
    assert there.side == "right"
    assert there.length == pytest.approx(here.length)
    np.testing.assert_allclose(
        there.wrist_centre, motion[:3, :3] @ here.wrist_centre + motion[:3, 3]
    )


def test_the_toy_hand_has_the_length_and_wrist_it_was_made_with():
    # Back +y, fingers +z, thumb at +x: to the left of who looks at the back.
    hand = measure_hand(toy_hand(length=190.0))
    assert hand.side == "right"
    assert hand.length + hand.arm == pytest.approx(190, abs=1)
    assert hand.arm < 0.4 * 190  # where its thumb begins
    assert hand.wrist_width == pytest.approx(84, abs=0.5)
    np.testing.assert_allclose(hand.wrist_centre[2], 0, atol=1e-12)
    assert len(hand.wrist) == 72


@pytest.mark.parametrize(
    ("length", "bend"), [(5, 0.0), (20, 0.3), (80, -0.3), (150, 0.0), (150, 0.3)]
)
def test_a_forearm_changes_nothing_of_the_hand(male, length, bend):
    here, there = (
        measure_hand(male),
        measure_hand(with_forearm(male, length, bend=bend)),
    )
    assert there.side == "right"
    assert there.length == pytest.approx(here.length, abs=8)
    # The arm counts along the fingers, so that a bent one is shorter.
    assert there.arm == pytest.approx(
        here.arm + length * np.cos(bend), abs=0.1 * length + 8
    )
    assert angle(there.frame.back, here.frame.back) < 3
    assert angle(there.frame.fingers, here.frame.fingers) < 4


@pytest.mark.parametrize(("length", "seed"), [(0.1, 0), (60, 1), (150, 2)])
def test_a_left_hand_with_a_forearm_is_found_however_it_lies(male, length, seed):
    rng = np.random.default_rng(seed)
    motion = pose(rng.uniform(-np.pi, np.pi, 3), rng.uniform(-900, 900, 3))
    left = moved(with_forearm(mirrored(male), length), motion)
    here, there = measure_hand(mirrored(male)), measure_hand(left)
    assert there.side == "left"
    for name in ("back", "fingers", "side"):
        turned = motion[:3, :3] @ getattr(here.frame, name)
        assert angle(getattr(there.frame, name), turned) < 5


@pytest.mark.parametrize("reduction", [0.5, 0.95])
def test_coarser_triangles_hardly_turn_the_frame(male, reduction):
    armed = with_forearm(male, 120)
    coarse = armed.decimate(reduction)
    here, there = measure_hand(armed), measure_hand(coarse)
    assert there.side == "right"
    assert there.length == pytest.approx(here.length, abs=8)
    assert angle(there.frame.back, here.frame.back) < 3
    assert angle(there.frame.fingers, here.frame.fingers) < 2


def test_a_forearm_without_its_hand_has_no_thumb():
    arm = with_forearm(tube(25, 50), 150)
    with pytest.raises(MeshError, match="no thumb"):
        hand_frame(arm)


@pytest.mark.parametrize("make", [plane, wave, lambda: tube(50, 20)])
def test_a_sheet_is_no_hand(make):
    with pytest.raises(MeshError, match="no hand"):
        measure_hand(make())


def test_a_mesh_without_area_is_no_hand():
    points, faces = topology.arrays(toy_hand())
    points[:, :2] = 0
    with pytest.raises(MeshError, match="no area"):
        hand_frame(polydata(points, faces))
