"""What comes with skinviz is there and is what it is said to be."""

import numpy as np
import pytest

from skinviz.errors import MeshError
from skinviz.scan import shipped, topology
from skinviz.scan.formats import read_scan
from skinviz.scan.shipped import DEMO_SCAN, shipped_mesh


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
