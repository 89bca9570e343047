"""VTP files: whatever VTK's writer makes is read as VTK's reader reads it."""

import base64
import re
import resource
import zlib

import numpy as np
import pytest
import pyvista as pv
from scan_files import VTP, save_vtp, with_data

from meshes import cube, wave
from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.formats import read_mesh


@pytest.mark.parametrize("way", VTP)
def test_every_encoding_gives_what_vtk_reads(tmp_path, way):
    file = save_vtp(tmp_path / "a.vtp", with_data(wave(9)), **VTP[way])
    mesh, expected = read_mesh(file), pv.read(file)
    np.testing.assert_array_equal(mesh.points, expected.points)
    np.testing.assert_array_equal(mesh.regular_faces, expected.regular_faces)
    for data in ("point_data", "cell_data", "field_data"):
        got, wanted = getattr(mesh, data), getattr(expected, data)
        assert set(got.keys()) == set(wanted.keys())
        for name in wanted:
            np.testing.assert_array_equal(got[name], wanted[name])
            assert got[name].dtype == wanted[name].dtype


def test_an_array_of_many_compressed_blocks_is_whole(tmp_path):
    mesh = wave(81)  # its points are 157 kB, in blocks of 32 kB
    file = save_vtp(tmp_path / "a.vtp", mesh)
    np.testing.assert_array_equal(read_mesh(file, "mm").points, mesh.points)


def test_bytes_of_the_other_order_are_turned(tmp_path):
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(tmp_path / "a.vtp"))
    writer.SetInputData(wave(5))
    writer.SetByteOrderToBigEndian()
    writer.Write()
    assert b"BigEndian" in (tmp_path / "a.vtp").read_bytes()
    got = read_mesh(tmp_path / "a.vtp", "mm")
    np.testing.assert_array_equal(got.points, wave(5).points)
    np.testing.assert_array_equal(got.regular_faces, wave(5).regular_faces)


def test_strips_are_taken_apart_with_their_sides_kept(tmp_path):
    mesh = wave(9)
    stripped = mesh.strip()
    assert stripped.n_strips
    stripped.save(tmp_path / "a.vtp")
    got = read_mesh(tmp_path / "a.vtp", "mm")
    assert got.n_cells == mesh.n_cells
    assert (topology.face_vectors(*topology.arrays(got))[:, 2] > 0).all()
    area = topology.face_areas(*topology.arrays(got)).sum()
    assert area == pytest.approx(topology.face_areas(*topology.arrays(mesh)).sum())


def test_arrays_on_cells_go_where_polygons_are_split(tmp_path):
    shape = cube(20.0)
    shape.cell_data["side"] = np.arange(6)
    shape.point_data["corner"] = np.arange(8)
    shape.save(tmp_path / "a.vtp")
    got = read_mesh(tmp_path / "a.vtp", "mm")
    assert got.cell_data.keys() == []
    np.testing.assert_array_equal(got.point_data["corner"], np.arange(8))


def text_of(tmp_path, **options):
    file = save_vtp(tmp_path / "good.vtp", with_data(wave(5)), **options)
    return file.read_text()


def refused(tmp_path, content, message, unit=None):
    file = tmp_path / "bad.vtp"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(MeshError, match=rf"bad\.vtp.*{message}"):
        read_mesh(file, unit)


FAULTS = {
    "more points": ('NumberOfPoints="25"', 'NumberOfPoints="26"', "states 26 points"),
    "huge": ('NumberOfPoints="25"', f'NumberOfPoints="1{"0" * 18}"', "states 10000"),
    "more faces": ('NumberOfPolys="32"', 'NumberOfPolys="33"', "not the 33"),
    "no faces": ('NumberOfPolys="32"', 'NumberOfPolys="0"', "no faces"),
    "negative": ('NumberOfPolys="32"', 'NumberOfPolys="-32"', "NumberOfPolys is"),
    "another type": ('"Float64" Name="Points"', '"F" Name="Points"', "unknown type"),
    "columns": ('"3" format', '"4" format', "states 25 points|whole number"),
    "no columns": ('"3" format', '"0" format', "NumberOfComponents"),
    "a grid": ('type="PolyData"', 'type="ImageData"', "not a surface but 'ImageData'"),
    "another order": ("LittleEndian", "MiddleEndian", "byte_order"),
    "cut XML": ("</Points>", "", "mismatched tag"),
    "entities": ("<PolyData>", "<!DOCTYPE a><PolyData>", "entities"),
    "no format": ('format="ascii"', 'format="morse"', "unknown format 'morse'"),
    "two pieces": ("</Piece>", '</Piece><Piece NumberOfPoints="0"/>', "one piece"),
    "a short array": ('"depth" format', '"depth" NumberOfComponents="5" format',
                      "'depth' has 5 rows for 25"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_what_contradicts_itself_is_refused(tmp_path, fault):
    old, new, message = FAULTS[fault]
    text = text_of(tmp_path, mode="ascii")
    assert old in text
    refused(tmp_path, text.replace(old, new), message)


def test_an_offset_beyond_the_end_is_refused(tmp_path):
    text = text_of(tmp_path)
    refused(
        tmp_path, re.sub(r'offset="\d+"', 'offset="99999999"', text), "beyond the end"
    )


def points_array(content):
    """A file of three points in one array, its bytes given in base64."""
    return (
        '<VTKFile type="PolyData" byte_order="LittleEndian" header_type="UInt64" '
        'compressor="vtkZLibDataCompressor"><PolyData><Piece NumberOfPoints="3" '
        'NumberOfPolys="1"><Points><DataArray type="Float64" NumberOfComponents="3" '
        f'format="binary">{content}</DataArray></Points></Piece></PolyData></VTKFile>'
    )


def packed(sizes, blocks):
    head = np.array(sizes, dtype="<u8").tobytes()
    return (base64.b64encode(head) + base64.b64encode(b"".join(blocks))).decode()


def zeros(n_mib):
    """Many zeros, compressed without ever having been in memory at once."""
    packer = zlib.compressobj(9)
    parts = [packer.compress(bytes(2**20)) for _ in range(n_mib)]
    return b"".join(parts) + packer.flush()


ZEROS = zeros(100)

BOMBS = {
    "blocks without end": packed([2**60, 2**15, 0, 9], [b"x" * 9]),
    "a block without end": packed([1, 2**60, 0, 9], [b"x" * 9]),
    "a last block without end": packed([1, 9, 2**62, 9], [b"x" * 9]),
    "a stored block without end": packed([1, 72, 0, 2**60], [b"x" * 9]),
    "sizes that wrap": packed([2**63, 2, 0, 9], [b"x" * 9]),
    "bytes that expand": packed([1, 2**40, 0, len(ZEROS)], [ZEROS]),
    "more than they state": packed([1, 72, 0, len(ZEROS)], [ZEROS]),
    "fewer than they state": packed([1, 80, 0, 12], [zlib.compress(bytes(72))]),
    "no blocks": packed([0, 0, 0], []),
    "nothing": "",
    "no base64": "%%%%" * 20,
}


@pytest.mark.parametrize("bomb", BOMBS)
def test_stated_sizes_ask_for_no_memory(tmp_path, bomb):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    refused(tmp_path, points_array(BOMBS[bomb]), "not a whole VTP file")
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 50_000  # kB


def test_arrays_that_share_their_bytes_do_not_add_up_without_bound(tmp_path):
    # 300 arrays of 4 MB each from the same 4 kB.
    mesh = pv.PolyData.from_regular_faces(np.zeros((520_000, 3)), [[0, 1, 2]])
    mesh.point_data["a"] = np.zeros(520_000)
    file = save_vtp(tmp_path / "good.vtp", mesh)
    text = file.read_text()
    (array,) = re.findall(r'<DataArray type="Float64" Name="a".*?/>', text, re.DOTALL)
    many = "".join(array.replace('"a"', f'"a{i}"') for i in range(300))
    refused(tmp_path, text.replace(array, many), "more than the file can", "mm")
