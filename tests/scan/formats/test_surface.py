"""Triangle meshes: round trips, units, and refusals of broken files."""

import struct

import numpy as np
import plyfile
import pytest
import pyvista as pv
import trimesh
from tolerances import ROUNDING

from meshes import cube, moved, pose, sphere, tetrahedron, toy_hand
from skinviz import hand_frame
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan import topology
from skinviz.scan.formats import read_mesh, read_scan, write_mesh

FLOAT32 = 2.0**-24
"""Relative rounding of coordinates that a file holds as float32."""


def exported(mesh, path, **options):
    """The file of a mesh as trimesh writes it: a program that is not ours."""
    points, faces = topology.arrays(mesh)
    trimesh.Trimesh(points, faces, process=False).export(path, **options)
    return path


def same_surface(mesh, expected, tolerance):
    """Whether two meshes have the same triangles at the same places, in order."""
    got, want = (np.asarray(m.points)[m.regular_faces] for m in (mesh, expected))
    np.testing.assert_allclose(got, want, rtol=0, atol=tolerance)


def ply_bytes(vertices, faces, name="vertex_indices"):
    """A mesh PLY file, byte by byte."""
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int {name}\nend_header\n"
    )
    rows = [struct.pack("<3d", *map(float, v)) for v in vertices]
    rows += [struct.pack(f"<B{len(f)}i", len(f), *f) for f in faces]
    return head.encode() + b"".join(rows)


def stl_bytes(mesh):
    """A binary STL file, byte by byte."""
    corners = np.asarray(mesh.points)[mesh.regular_faces].astype("<f4")
    rows = [bytes(12) + c.tobytes() + bytes(2) for c in corners]
    return bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows)


@pytest.mark.parametrize("suffix", [".ply", ".vtp"])
def test_write_then_read_gives_the_same_mesh(tmp_path, suffix):
    mesh = moved(toy_hand(), pose((0.5, 1, -2), (-524, 190, 296)))
    file = write_mesh(tmp_path / f"hand{suffix}", mesh)
    got = read_mesh(file)  # the file states its unit
    np.testing.assert_array_equal(got.regular_faces, mesh.regular_faces)
    tolerance = 0 if suffix == ".vtp" else FLOAT32 * np.abs(mesh.points).max()
    same_surface(got, mesh, tolerance)
    assert got.points.dtype == np.float64
    assert [f.name for f in tmp_path.iterdir()] == [f"hand{suffix}"]


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".off"])
def test_other_programs_files_give_the_same_surface(tmp_path, suffix):
    mesh = toy_hand()
    file = exported(mesh, tmp_path / f"hand{suffix}")
    # trimesh writes OBJ and OFF with 8 decimals, PLY and STL as float32.
    same_surface(read_mesh(file, "mm"), mesh, FLOAT32 * 200)


def test_an_stl_file_byte_by_byte_gives_the_same_surface(tmp_path):
    (tmp_path / "a.stl").write_bytes(stl_bytes(tetrahedron()))
    same_surface(read_mesh(tmp_path / "a.stl", "mm"), tetrahedron(), 0)


def test_a_ply_file_in_text_gives_the_same_surface(tmp_path):
    file = exported(tetrahedron(), tmp_path / "a.ply", encoding="ascii")
    assert file.read_bytes().startswith(b"ply\nformat ascii")
    same_surface(read_mesh(file, "mm"), tetrahedron(), 1e-7)


def test_an_stl_file_in_text_gives_the_same_surface(tmp_path):
    file = exported(tetrahedron(), tmp_path / "a.stl", file_type="stl_ascii")
    assert file.read_bytes().startswith(b"solid")
    same_surface(read_mesh(file, "mm"), tetrahedron(), FLOAT32)


def test_a_vtp_file_of_another_program_gives_the_same_surface(tmp_path):
    sphere(subdivisions=2).save(tmp_path / "a.vtp")
    same_surface(read_mesh(tmp_path / "a.vtp", "mm"), sphere(subdivisions=2), 0)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".off"])
def test_triangles_that_share_points_are_connected_after_reading(tmp_path, suffix):
    # An STL file repeats each point in each triangle; the surface is one all the same.
    mesh = toy_hand()
    got = read_mesh(exported(mesh, tmp_path / f"hand{suffix}"), "mm")
    _, faces = topology.arrays(got)
    assert len(topology.boundary_loops(faces)) == 1
    np.testing.assert_allclose(
        hand_frame(got).fingers, hand_frame(mesh).fingers, atol=1e-5
    )


def test_an_obj_with_texture_seams_stays_connected(tmp_path):
    # A point used with two texture coordinates is one point of the surface.
    file = tmp_path / "seam.obj"
    file.write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        "vt 0.5 0.5\nvt 0.6 0.5\nf 1/1 2/2 3/3\nf 1/5 3/6 4/4\n"
    )
    _, faces = topology.arrays(read_mesh(file, "mm"))
    assert topology.edge_counts(faces)[1].max() == 2


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".off", ".vtp"])
def test_the_unit_is_required_and_scales(tmp_path, suffix):
    mesh = toy_hand()
    file = tmp_path / f"hand{suffix}"
    if suffix == ".vtp":
        mesh.save(file)
    else:
        exported(mesh, file)
    with pytest.raises(MeshError, match=rf"hand\{suffix}.*unit"):
        read_scan(file)
    with pytest.raises(ArgumentError, match=r"unknown unit.*mm, cm, m"):
        read_scan(file, "parsec")
    size = np.ptp(read_mesh(file, "mm").points, axis=0)
    for unit, scale in (("m", 1000.0), ("cm", 10.0), ("inch", 25.4), ("um", 1e-3)):
        got = np.ptp(read_mesh(file, unit).points, axis=0)
        np.testing.assert_allclose(got, scale * size, rtol=ROUNDING)


@pytest.mark.parametrize("suffix", [".ply", ".vtp"])
def test_normals_and_colours_ride_along(tmp_path, suffix):
    mesh = sphere(subdivisions=2)
    normals = topology.vertex_normals(*topology.arrays(mesh))
    mesh.point_data["Normals"] = normals
    rgb = np.random.default_rng(0).integers(0, 256, (mesh.n_points, 3), dtype=np.uint8)
    mesh.point_data["rgb"] = rgb
    file = write_mesh(tmp_path / f"a{suffix}", mesh)
    if suffix == ".vtp":
        got = read_mesh(file)
        np.testing.assert_array_equal(got.point_data["Normals"], normals)
        np.testing.assert_array_equal(got.point_data["rgb"], rgb)
    else:
        rows = plyfile.PlyData.read(file)["vertex"].data
        for k, name in enumerate(("red", "green", "blue")):
            np.testing.assert_array_equal(rows[name], rgb[:, k])
        for k, name in enumerate(("nx", "ny", "nz")):
            np.testing.assert_allclose(rows[name], normals[:, k], atol=1e-7)


def test_vtp_keeps_every_array_of_a_shaded_mesh(tmp_path):
    mesh = tetrahedron()
    mesh.point_data["radiance"] = np.arange(4 * 61, dtype=np.float32).reshape(4, 61)
    mesh.field_data["wavelengths"] = np.arange(400.0, 701, 5)
    got = read_mesh(write_mesh(tmp_path / "a.vtp", mesh))
    np.testing.assert_array_equal(
        got.point_data["radiance"], mesh.point_data["radiance"]
    )
    np.testing.assert_array_equal(
        got.field_data["wavelengths"], mesh.field_data["wavelengths"]
    )


def test_writing_leaves_the_mesh_as_it_was(tmp_path):
    mesh = tetrahedron()
    for suffix in (".ply", ".vtp"):
        write_mesh(tmp_path / f"a{suffix}", mesh)
    assert list(mesh.field_data.keys()) == []
    assert list(mesh.point_data.keys()) == []


def test_files_state_their_unit(tmp_path):
    write_mesh(tmp_path / "a.ply", tetrahedron())
    assert b"\ncomment unit mm\n" in (tmp_path / "a.ply").read_bytes()
    write_mesh(tmp_path / "a.vtp", tetrahedron())
    assert list(pv.read(tmp_path / "a.vtp").field_data["unit"]) == ["mm"]


@pytest.mark.parametrize("name", ["a.stl", "a.obj", "a", "a.plyx"])
def test_only_formats_that_state_the_unit_are_written(tmp_path, name):
    with pytest.raises(ArgumentError, match=r"\.ply, \.vtp"):
        write_mesh(tmp_path / name, tetrahedron())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".ply", ".vtp"])
def test_a_failed_write_leaves_the_old_file_and_nothing_else(
    tmp_path, suffix, monkeypatch
):
    file = write_mesh(tmp_path / f"a{suffix}", tetrahedron())
    before = file.read_bytes()

    def fail(self, path, *args, **kwargs):
        with open(path, "wb") as partial:  # noqa: PTH123 - as the libraries do
            partial.write(b"half a fi")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("plyfile.PlyData.write", fail)
    monkeypatch.setattr("pyvista.PolyData.save", fail)
    with pytest.raises(Exception, match="No space left"):
        write_mesh(file, sphere())
    assert file.read_bytes() == before
    assert [f.name for f in tmp_path.iterdir()] == [file.name]


SQUARE = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (1, 2, 0)]


def test_polygons_are_cut_into_triangles(tmp_path):
    file = tmp_path / "a.ply"
    file.write_bytes(ply_bytes(SQUARE, [[0, 1, 2, 3], [3, 2, 4], [0, 1, 2, 4, 3]]))
    points, faces = topology.arrays(read_mesh(file, "mm"))
    assert len(faces) == 2 + 1 + 3
    assert topology.face_areas(points, faces).tolist() == [1, 1, 1, 1, 1.5, 0.5]
    assert (topology.face_vectors(points, faces)[:, 2] > 0).all()


@pytest.mark.parametrize("suffix", [".obj", ".off", ".vtp", ".ply"])
def test_a_cube_of_squares_has_its_volume(tmp_path, suffix):
    shape = cube(20.0)
    points, squares = np.asarray(shape.points), np.asarray(shape.regular_faces)
    file = tmp_path / f"cube{suffix}"
    if suffix == ".vtp":
        shape.save(file)
    elif suffix == ".ply":
        file.write_bytes(ply_bytes(points.tolist(), squares.tolist()))
    else:
        first = 1 if suffix == ".obj" else 0
        v, f = ("v ", "f ") if suffix == ".obj" else ("", "4 ")
        rows = [v + " ".join(map(str, p)) for p in points.tolist()]
        rows += [f + " ".join(map(str, q)) for q in (squares + first).tolist()]
        head = "" if suffix == ".obj" else "OFF\n8 6 0\n"
        file.write_text(head + "\n".join(rows) + "\n")
    got = read_mesh(file, "mm")
    assert got.is_all_triangles
    assert got.n_cells == 12
    assert topology.enclosed_volume(*topology.arrays(got)) == pytest.approx(8000)


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".off", ".vtp"])
def test_a_truncated_file_is_refused_wherever_it_ends(tmp_path, suffix):
    mesh = sphere(subdivisions=1)
    file = tmp_path / f"whole{suffix}"
    if suffix in (".ply", ".vtp"):
        write_mesh(file, mesh)
    else:
        exported(mesh, file)
    whole = file.read_bytes()
    # The last index of an OFF file can lose digits unnoticed, so cut before it.
    last = len(whole.rstrip()) - (5 if suffix == ".off" else 0)
    ends = {*range(0, last, max(last // 150, 1)), *range(last - 12, last)}
    cut = tmp_path / f"cut{suffix}"
    for end in sorted(ends):
        cut.write_bytes(whole[:end])
        with pytest.raises(MeshError, match=rf"cut\{suffix}"):
            read_scan(cut, "mm")


def test_a_truncated_stl_in_text_is_refused_wherever_it_ends(tmp_path):
    file = exported(tetrahedron(), tmp_path / "a.stl", file_type="stl_ascii")
    whole = file.read_bytes()
    cut = tmp_path / "cut.stl"
    for end in range(1, whole.rindex(b"endsolid"), 13):
        cut.write_bytes(whole[:end])
        with pytest.raises(MeshError, match=r"cut\.stl"):
            read_scan(cut, "mm")


NAN = {
    ".ply": ply_bytes([("nan", 0, 0), (1, 0, 0), (0, 1, 0)], [[0, 1, 2]]),
    ".obj": b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    ".off": b"OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
}


@pytest.mark.parametrize("suffix", [*NAN, ".stl", ".vtp"])
def test_points_that_are_not_finite_are_refused(tmp_path, suffix):
    file = tmp_path / f"bad{suffix}"
    broken = tetrahedron()
    broken.points[2] = [0.0, np.inf, 1.0]
    if suffix == ".vtp":
        broken.save(file)
    elif suffix == ".stl":
        file.write_bytes(stl_bytes(broken))
    else:
        file.write_bytes(NAN[suffix])
    with pytest.raises(MeshError, match=rf"bad\{suffix}"):
        read_scan(file, "mm")


NO_FACES = {
    ".ply": ply_bytes(SQUARE, []),
    ".obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    ".off": b"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n",
    ".stl": b"solid empty\nendsolid empty\n",
}


@pytest.mark.parametrize("suffix", [*NO_FACES, ".vtp"])
def test_points_without_faces_are_no_mesh(tmp_path, suffix):
    file = tmp_path / f"points{suffix}"
    if suffix == ".vtp":
        pv.PolyData(np.array(SQUARE, dtype=float)).save(file)
    else:
        file.write_bytes(NO_FACES[suffix])
    with pytest.raises(MeshError, match=rf"points\{suffix}.*face"):
        read_mesh(file, "mm")


OUT_OF_RANGE = {
    ".ply": ply_bytes(SQUARE, [[0, 1, 5]]),
    ".obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
    ".off": b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
}


@pytest.mark.parametrize("suffix", OUT_OF_RANGE)
def test_a_face_that_names_a_missing_point_is_refused(tmp_path, suffix):
    file = tmp_path / f"bad{suffix}"
    file.write_bytes(OUT_OF_RANGE[suffix])
    with pytest.raises(MeshError, match=rf"bad\{suffix}"):
        read_scan(file, "mm")


def test_a_vtp_face_that_names_a_missing_point_is_refused(tmp_path):
    tetrahedron().save(tmp_path / "good.vtp", binary=False)
    text = (tmp_path / "good.vtp").read_text()
    start = text.index(">", text.index('Name="connectivity"', text.index("<Polys"))) + 1
    end = text.index("<", start)
    numbers = ["77", *text[start:end].split()[1:]]
    bad = text[:start] + " ".join(numbers) + text[end:]
    (tmp_path / "bad.vtp").write_text(bad)
    with pytest.raises(MeshError, match=r"bad\.vtp"):
        read_scan(tmp_path / "bad.vtp", "mm")


@pytest.mark.parametrize("faces", [[[0, 1]], [[0]], [[]], [[0, 1, -1]]])
def test_a_face_of_too_few_points_or_a_negative_one_is_refused(tmp_path, faces):
    file = tmp_path / "bad.ply"
    file.write_bytes(ply_bytes(SQUARE, faces))
    with pytest.raises(MeshError, match=r"bad\.ply"):
        read_scan(file, "mm")


def test_faces_may_be_called_vertex_index_but_nothing_else(tmp_path):
    file = tmp_path / "a.ply"
    file.write_bytes(ply_bytes(SQUARE, [[0, 1, 2]], name="vertex_index"))
    assert read_mesh(file, "mm").n_cells == 1
    file.write_bytes(ply_bytes(SQUARE, [[0, 1, 2]], name="corners"))
    with pytest.raises(MeshError, match=r"a\.ply.*vertex_indices"):
        read_mesh(file, "mm")


def test_a_vtp_that_is_no_surface_is_refused(tmp_path):
    pv.ImageData(dimensions=(3, 3, 3)).save(tmp_path / "a.vti")
    (tmp_path / "a.vti").rename(tmp_path / "a.vtp")
    with pytest.raises(MeshError, match=r"a\.vtp"):
        read_scan(tmp_path / "a.vtp", "mm")


def test_an_off_file_may_have_comments_and_blank_lines(tmp_path):
    file = tmp_path / "a.off"
    file.write_text(
        "OFF # made by hand\n\n# counts\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    )
    assert read_mesh(file, "mm").n_cells == 1
