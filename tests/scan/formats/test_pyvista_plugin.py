"""``pyvista.read`` opens range views, in whichever order the packages load."""

import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from scan_files import grid_view, ptx_text

import skinviz
from meshes import pose, wave
from skinviz.scan import topology
from skinviz.scan.formats import write_mesh, write_scan
from skinviz.scan.formats.pyvista_plugin import register
from skinviz.scan.scan import Scan, transform

ROOT = Path(__file__).parents[3]
DECLARED = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"][
    "entry-points"
]


@pytest.fixture(autouse=True)
def registered():
    register()


def test_a_conf_opens_as_its_views_in_their_places(tmp_path):
    where = pose((0.1, 0.2, 0.3), (100, 20, 30))
    views = (grid_view("a"), grid_view("b", where=where))
    write_scan(tmp_path / "hand.conf", Scan(views=views))
    blocks = pv.read(tmp_path / "hand.conf")
    assert blocks.keys() == ["a", "b"]
    for view, block in zip(views, blocks, strict=True):
        placed = transform(view.pose, view.points[view.valid])
        np.testing.assert_allclose(block.points, placed, atol=1e-4)
        assert block.is_all_triangles


def test_a_range_grid_opens_as_a_surface_without_bridges(tmp_path):
    points = grid_view(rows=12, columns=12).points
    points[:, 6:, 2] += 300.0
    view = grid_view()
    write_scan(tmp_path / "a.conf", Scan(views=(type(view)("a", points, view.pose),)))
    mesh = pv.read(tmp_path / "a.ply")
    assert mesh.n_cells > 100
    edges, _ = topology.edge_counts(topology.arrays(mesh)[1])
    length = np.linalg.norm(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]], axis=1)
    assert length.max() < 20


def test_any_other_ply_file_opens_as_before(tmp_path):
    mesh = wave(5)
    mesh.point_data["rgb"] = np.full((25, 3), 7, dtype=np.uint8)
    write_mesh(tmp_path / "a.ply", mesh)
    got, expected = pv.read(tmp_path / "a.ply"), pv.PLYReader(tmp_path / "a.ply").read()
    assert got == expected
    assert got.n_cells == 32


def test_a_ptx_opens_in_its_own_numbers_unless_the_unit_is_said(tmp_path):
    points = grid_view().points - [0, 0, 400]
    file = tmp_path / "a.ptx"
    file.write_text(ptx_text([(points, np.eye(4), np.zeros(3))]))
    plain, scaled = pv.read(file)[0], pv.read(file, unit="cm")[0]
    np.testing.assert_allclose(plain.points, points[np.isfinite(points[..., 0])])
    np.testing.assert_allclose(scaled.points, 10 * plain.points)


@pytest.mark.parametrize("group", ["pyvista.readers", "pyvista.readers.override"])
def test_the_package_declares_readers_that_exist(group):
    for suffix, value in DECLARED[group].items():
        assert callable(EntryPoint(suffix, value, group).load())


def test_pyvista_finds_the_installed_package_by_itself(tmp_path):
    # A package that is installed has this folder; a checkout need not have it.
    info = tmp_path / "site" / "skinviz_declared-1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: skinviz-declared\n")
    lines = [
        line
        for group, readers in DECLARED.items()
        for line in (f"[{group}]", *(f"{k} = {v}" for k, v in readers.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines))
    write_scan(tmp_path / "a.conf", Scan(views=(grid_view("a"),)))
    code = (
        f"import sys; sys.path[:0] = {[str(tmp_path / 'site'), _root()]}; "
        "import pyvista as pv; assert 'skinviz' not in sys.modules; "
        f"print(pv.read({str(tmp_path / 'a.ply')!r}).n_cells, "
        f"pv.read({str(tmp_path / 'a.conf')!r})[0].n_cells)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    n_cells = str(pv.read(tmp_path / "a.ply").n_cells)
    assert done.stdout.split() == [n_cells, n_cells]


def test_the_readers_load_no_heavy_library_until_they_read():
    code = (
        f"import sys; sys.path[:0] = [{_root()!r}]; import skinviz.scan.formats; "
        "print(*{'pyvista', 'vtkmodules', 'trimesh', 'plyfile', 'scipy'} "
        "& set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == []


def _root():
    return str(Path(skinviz.__file__).parents[1])
