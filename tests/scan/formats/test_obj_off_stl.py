"""OBJ, OFF and STL: their own ways to say a mesh, and their own faults."""

import numpy as np
import pytest

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.formats import read_mesh

POINTS = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n"
SAME_SQUARE = {
    "triangles": "f 1 2 3\nf 1 3 4\n",
    "a polygon": "f 1 2 3 4\n",
    "counted back": "f -4 -3 -2 -1\n",
    "with texture": "vt 0 0\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1\n",
    "with normals": "vn 0 0 1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n",
    "mixed": "f 1 2 3\nf 1/1/1 3 4//2\n",
    "over two lines": "f 1 2 \\\n3 4\n",
    "with groups": "g hand\nusemtl skin\ns 1\nf 1 2 3 4 # the palm\n",
    "by tabs": "f\t1\t2\t3\t4\n",
}


@pytest.mark.parametrize("way", SAME_SQUARE)
def test_obj_faces_may_be_said_in_many_ways(tmp_path, way):
    (tmp_path / "a.obj").write_text("# unit cm\n" + POINTS + SAME_SQUARE[way])
    points, faces = topology.arrays(read_mesh(tmp_path / "a.obj"))
    assert len(faces) == 2
    np.testing.assert_allclose(topology.face_areas(points, faces), [100, 100])
    assert (topology.face_vectors(points, faces)[:, 2] > 0).all()


def test_obj_points_may_have_colours_and_tabs(tmp_path):
    text = "v\t0 0 0 0.5 0.5 0.5\nv\t1 0 0\nv 0 1 0 1\nf 1 2 3\n"
    (tmp_path / "a.obj").write_text(text)
    points, _ = topology.arrays(read_mesh(tmp_path / "a.obj", "mm"))
    assert np.ptp(points, axis=0).tolist() == [1, 1, 0]


def test_a_negative_number_counts_from_its_own_line(tmp_path):
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n"
    )
    points, faces = topology.arrays(read_mesh(tmp_path / "a.obj", "mm"))
    np.testing.assert_array_equal(points[faces][..., 2], [[0, 0, 0], [5, 5, 5]])


FAULTS = {
    "another line": ("obj", POINTS + "fce 1 2 3\n", "line 5.*'fce' begins no line"),
    "a word": ("obj", POINTS + "f 1 two 3\n", "line 5.*whole numbers"),
    "half": ("obj", POINTS + "f 1 2 3.5\n", "line 5.*whole numbers"),
    "zero": ("obj", POINTS + "f 0 1 2\n", "names point 0"),
    "before the first": ("obj", POINTS + "f -5 -1 -2\n", "names point -1 of 4"),
    "two corners": ("obj", POINTS + "f 1 2\n", "line 5.*fewer than three"),
    "no corner": ("obj", POINTS + "f 1 2 3\nf\n", "line 6.*fewer than three"),
    "a short point": ("obj", POINTS + "v 1 2\nf 1 2 3\n", "line 5.*expected 3 numbers"),
    "an empty point": ("obj", POINTS + "v\nf 1 2 3\n", "line 5.*expected 3 numbers"),
    "huge": ("obj", POINTS + f"f 1 2 {'9' * 30}\n", "line 5.*whole numbers"),
    "endless": ("obj", POINTS + f"f 1 2 {'9' * 9000}\n", "line 5.*whole numbers"),
    "open end": ("obj", POINTS + "f 1 2 \\\n", "backslash"),
    "more points": ("off", "OFF\n9 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "9 points"),
    "huge counts": ("off", f"OFF\n1{'0' * 18} 1 0\n0 0 0\n3 0 0 0\n", "10000"),
    "endless counts": ("off", f"OFF\n{'9' * 9000} 1 0\n0 0 0\n3 0 0 0\n", "99999"),
    "more faces": ("off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "2 faces"),
    "more lines": ("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n1 1\n", "5 lines"),
    "four dimensions": ("off", "4OFF\n3 1 0\n", "line 1.*begins with one of OFF"),
    "no counts": ("off", "OFF\n", "line 1.*numbers of points"),
    "a short face": ("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n",
                     "line 6.*face of 4 points names 3"),
    "a line's face": ("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "fewer than"),
    "no end": ("stl", "solid a\nfacet normal 0 0 1\n", "line 2.*end with 'endsolid'"),
    "two begins": ("stl", "solid a\nsolid b\nendsolid\n", "do not alternate"),
    "half a facet": ("stl", "solid a\nfacet normal 0 0 1\nouter loop\nendsolid a\n",
                     "line 3.*of a facet"),
    "a bad point": ("stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                    "vertex 1 0 O\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
                    "line 5.*'O' is no number"),
    "an empty point ": ("stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                        "vertex\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
                        "line 5.*expected 3 numbers"),
    "wrong count": ("stl", bytes(80) + b"\2\0\0\0" + bytes(50), "2 triangles.*for 1"),
    "huge count": ("stl", bytes(80) + b"\xff" * 4 + bytes(50), "4294967295 triangles"),
    "shorter than a head": ("stl", b"\1" * 40, "not a whole STL"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_mesh_is_refused(tmp_path, fault):
    suffix, content, message = FAULTS[fault]
    file = tmp_path / f"a.{suffix}"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(MeshError, match=rf"a\.{suffix}.*{message}"):
        read_mesh(file, "mm")


@pytest.mark.parametrize("kind", ["OFF", "COFF", "NOFF"])
def test_off_files_may_say_more_of_points_and_faces(tmp_path, kind):
    more = {"OFF": "", "COFF": " 255 0 0 255", "NOFF": " 0 0 1"}[kind]
    points = "".join(f"{p}{more}\n" for p in ("0 0 0", "2 0 0", "2 1 0", "0 1 0"))
    text = f"{kind} 4 2 0 # counts here\n{points}3 0 1 2 9 9 9\n3 0 2 3\n"
    (tmp_path / "a.off").write_text(text)
    points, faces = topology.arrays(read_mesh(tmp_path / "a.off", "mm"))
    np.testing.assert_allclose(topology.face_areas(points, faces), [1, 1])


def test_an_stl_file_in_text_may_hold_several_solids(tmp_path):
    solid = (
        "SOLID a b c\n  facet normal 0 0 1\n outer loop\n\tvertex 0 0 {0}\n"
        "vertex 1 0 {0}\nvertex 0 1 {0}\nendloop\nendfacet\nendsolid\n"
    )
    (tmp_path / "a.stl").write_text(solid.format(0) + "\n" + solid.format("1e1"))
    points, faces = topology.arrays(read_mesh(tmp_path / "a.stl", "mm"))
    np.testing.assert_array_equal(points[faces][:, 0, 2], [0, 10])


def test_a_binary_stl_file_may_begin_with_solid(tmp_path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4").tobytes()
    head = b"solid made by a program that knows no better".ljust(80)
    (tmp_path / "a.stl").write_bytes(
        head + b"\1\0\0\0" + bytes(12) + corners + bytes(2)
    )
    assert read_mesh(tmp_path / "a.stl", "mm").n_cells == 1
