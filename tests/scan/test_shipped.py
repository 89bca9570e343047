"""What comes with skinviz is there and is what it is said to be."""

import numpy as np
import pytest

from meshes import distance_to
from skinviz.cli.main import main
from skinviz.errors import MeshError
from skinviz.scan import shipped, topology
from skinviz.scan.formats import read_mesh, read_scan
from skinviz.scan.shipped import CLEAN_HANDS, DEMO_SCAN, TRUE_SHAPE, shipped_mesh
from skinviz.scene import measure_hand


def test_the_raw_scan_has_eight_views_of_one_hand():
    scan = read_scan(shipped_mesh(DEMO_SCAN))  # states its unit
    assert len(scan.views) == 8
    for view in scan.views:
        assert view.valid.sum() > 10_000
        heights = view.points[..., 2][view.valid]
        assert np.ptp(heights) < 250
        rotation = view.pose[:3, :3]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-8)


def test_the_true_shape_is_a_hand_open_at_the_wrist(true_hand):
    points, faces = topology.arrays(true_hand)
    assert len(topology.boundary_loops(faces)) == 1
    assert topology.n_non_manifold_edges(faces) == 0
    assert topology.face_components(len(points), faces).max() == 0
    assert topology.enclosed_volume(points, faces) > 200e3  # mm³, outward faces


def test_the_raw_scan_is_what_its_command_makes(tmp_path):
    # The command in meshes/README.md.
    made = tmp_path / "hand.conf"
    arguments = [shipped_mesh(TRUE_SHAPE), "--unit", "m", "-o", made, "--seed", "2005"]
    assert main(["simulate-scan", *map(str, arguments)]) == 0
    for here, there in zip(
        read_scan(shipped_mesh(DEMO_SCAN)).views, read_scan(made).views, strict=True
    ):
        np.testing.assert_allclose(here.pose, there.pose, atol=1e-6)
        # Another processor may round a ray to the other side of an edge.
        same = np.isclose(here.points, there.points, atol=0.011, equal_nan=True)
        assert same.all(axis=-1).mean() > 0.999


@pytest.mark.parametrize("side", CLEAN_HANDS)
def test_the_cleaned_hands_are_ready_for_use(side, true_hand):
    path = shipped_mesh(CLEAN_HANDS[side])
    assert path.stat().st_size < 1e6
    mesh = read_mesh(path)  # states its unit
    points, faces = topology.arrays(mesh)
    assert topology.n_non_manifold_edges(faces) == 0
    assert topology.face_components(len(points), faces).max() == 0
    assert len(topology.boundary_loops(faces)) == 1
    assert topology.enclosed_volume(points, faces) > 200e3  # mm³, outward faces
    hand = measure_hand(mesh)
    assert hand.side == side
    assert 190 < hand.length < 225
    assert 45 < hand.wrist_width < 65
    truth = true_hand
    if side == "left":
        truth = true_hand.reflect((1, 0, 0)).flip_faces()
    assert np.sqrt((distance_to(truth, points) ** 2).mean()) < 0.15


def test_a_mesh_in_the_package_comes_before_one_in_the_checkout(tmp_path, monkeypatch):
    module = tmp_path / "skinviz" / "scan" / "shipped.py"
    monkeypatch.setattr(shipped, "__file__", str(module))
    beside, inside = tmp_path / "meshes", tmp_path / "skinviz" / "meshes"
    for folder in (beside, inside):
        folder.mkdir(parents=True)
    (beside / "a.ply").write_text("x")
    assert shipped_mesh("a.ply") == beside / "a.ply"
    (inside / "a.ply").write_text("x")
    assert shipped_mesh("a.ply") == inside / "a.ply"


def test_a_mesh_that_is_not_shipped_is_named():
    with pytest.raises(MeshError, match=r"nobody\.ply is missing"):
        shipped_mesh("nobody.ply")
