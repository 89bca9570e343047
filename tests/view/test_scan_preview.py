"""Before and after: what is marked is what is wrong, and where it can be seen."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb

from meshes import face_centres, moved, pose, toy_hand, without_faces
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.scan import PointCloud, Scan
from skinviz.scan.simulate import Scanner, directions_around, simulate_scan
from skinviz.view import scan_preview as module
from skinviz.view.scan_preview import scan_preview

HOLE, WRIST, BAD = (to_rgb(c) for c in (module._HOLE, module._WRIST, module._BAD))


def marks(ax, colour):
    """How many edges of a colour a panel shows, and their middles."""
    found = [
        np.asarray(c.get_segments()).reshape(-1, 2, 2)
        for c in ax.collections
        if isinstance(c, LineCollection) and np.allclose(c.get_colors()[0][:3], colour)
    ]
    return np.concatenate([*found, np.zeros((0, 2, 2))]).mean(axis=1)


def texts(figure):
    return [text.get_text() for text in figure.texts]


@pytest.fixture(scope="module")
def broken():
    """The toy hand with a hole in its back and a fin on its palm."""
    near = np.linalg.norm(face_centres(toy_hand()) - (0, 16, 90), axis=1) < 9
    points, faces = topology.arrays(without_faces(toy_hand(), near))
    palm = np.argmin(np.linalg.norm(points[faces].mean(axis=1) - (0, -16, 60), axis=1))
    tip = points[faces[palm, 0]] + (0, -4, 0)
    fin = [faces[palm, 0], faces[palm, 1], len(points)]
    return topology.polydata(np.vstack([points, tip]), np.vstack([faces, fin]))


@pytest.mark.parametrize("where", [np.eye(4), pose((0.4, -1.0, 2.0), (300, -50, 9))])
def test_marks_are_where_the_faults_are(broken, where):
    figure = scan_preview(Scan(mesh=moved(broken, where)), moved(toy_hand(), where))
    back, palm, after_back, after_palm = figure.axes
    hole = marks(back, HOLE)
    assert len(hole) > 8
    assert np.ptp(hole, axis=0).max() < 25
    assert len(marks(back, BAD)) == 0
    assert len(marks(palm, BAD)) == 1
    for ax in (after_back, after_palm):
        assert len(marks(ax, HOLE)) == len(marks(ax, BAD)) == 0
        assert len(marks(ax, WRIST)) > 5
    loops = topology.boundary_loops(topology.arrays(broken)[1])
    told = f"{len(loops) - 1} holes, 1 non-manifold edges"
    assert any(text.startswith(told) for text in texts(figure))
    assert any(text.startswith("0 holes") for text in texts(figure))


def test_the_back_is_left_of_the_palm_and_both_show_the_same_hand(broken):
    figure = scan_preview(Scan(mesh=broken), toy_hand())
    assert [ax.get_xlabel() for ax in figure.axes] == ["back", "palm"] * 2
    back, palm = figure.axes[2].images[0], figure.axes[3].images[0]
    seen = [np.asarray(i.get_array()).min(axis=2) < 1 for i in (back, palm)]
    # The palm's outline is the back's, mirrored, to a pixel at its rim.
    rows = min(s.shape[0] for s in seen)
    columns = min(s.shape[1] for s in seen)
    differing = seen[0][:rows, :columns] ^ seen[1][:rows, ::-1][:, :columns]
    assert differing.mean() < 0.02
    assert 0.2 < seen[0].mean() < 0.9


def test_rims_that_another_view_covers_are_no_holes():
    scanner = Scanner(pitch=2.5, noise=0.0, pose_shift=0.0, pose_tilt=0.0,
                      spike_fraction=0.0, outlier_fraction=0.0)  # fmt: skip
    around = directions_around(6, (0, 0, 1), (0, 1, 0))
    scan = simulate_scan(toy_hand(), around, scanner, np.random.default_rng(0))
    alone, together = (
        module._before(Scan(views=views)).holes
        for views in (scan.views[:1], scan.views)
    )
    assert len(together) > 0
    per_view = len(together) / 6
    assert per_view < 0.5 * len(alone)
    figure = scan_preview(scan, toy_hand())
    assert any("6 raw views" in text for text in texts(figure))


def test_bare_points_have_no_preview():
    cloud = PointCloud(np.asarray(toy_hand().points))
    with pytest.raises(MeshError, match="no surface"):
        scan_preview(Scan(cloud=cloud), toy_hand())
