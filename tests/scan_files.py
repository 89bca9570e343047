"""A small file of every kind that the readers know, and ways to break one."""

import re

import numpy as np
import pyvista as pv
import trimesh

from meshes import plane, pose, wave
from skinviz.scan import topology
from skinviz.scan.checks import require_triangles
from skinviz.scan.formats import write_mesh, write_scan
from skinviz.scan.scan import RangeView, Scan

NUMBERS = (
    *(b"1000000000000000000", b"99999999999999999999999", b"4294967295", b"2147483648"),
    *(b"-1", b"0", b"1", b"nan", b"inf", b"-inf", b"1e400", b"1e308", b"-1e308"),
    *(b"1e-320", b"1,5", b"1.5", b"abc", b"", b"0x10", b"1_0", b"\xd9\xa3"),
)
"""What stands where a number should."""


def grid_view(name="view", rows=9, columns=7, where=None):
    """A curved sheet as a view of a range grid, with cells that had no return."""
    y, x = np.mgrid[0:rows, 0:columns] * 10.0
    points = np.stack([x, -y, 5 * np.sin(x / 20) + 0.1 * y], axis=-1)
    points[(np.arange(rows * columns).reshape(rows, columns) % 11) == 3] = np.nan
    return RangeView(name, points, np.eye(4) if where is None else where)


def ptx_text(scans, colour=""):
    """A PTX file: (points (rows, columns, 3), pose, place of the scanner) a scan."""
    lines = []
    for points, where, seat in scans:
        rows, columns = points.shape[:2]
        lines += [str(columns), str(rows)]
        turn = where[:3, :3].T
        lines += [" ".join(f"{x:.17g}" for x in row) for row in (seat, *turn)]
        lines += [" ".join(f"{x:.17g}" for x in row) for row in where.T]
        cells = np.nan_to_num(points).transpose(1, 0, 2).reshape(-1, 3)
        lines += [" ".join(f"{x:.17g}" for x in p) + " 0.5" + colour for p in cells]
    return "\n".join(lines) + "\n"


def _ply(path):
    write_mesh(path, wave(5))


def _ply_text(path):
    trimesh.Trimesh(*topology.arrays(wave(5)), process=False).export(
        path, encoding="ascii"
    )


def _ply_polygons(path):
    path.write_bytes(
        b"ply\nformat ascii 1.0\ncomment unit mm\nelement vertex 5\nproperty float x\n"
        b"property float y\nproperty float z\nproperty uchar red\nelement face 2\n"
        b"property uchar flag\nproperty list uchar int vertex_indices\nend_header\n"
        b"0 0 0 9\n2 0 0 9\n2 1 0 9\n0 1 0 9\n1 2 0 9\n7 4 0 1 2 3\n7 3 3 2 4\n"
    )


def _ply_points(path):
    pv.PolyData(np.asarray(wave(5).points, dtype=np.float32)).save(path)


def _grid(path):
    write_scan(path.with_suffix(".conf"), Scan(views=(grid_view(path.stem),)))


def _conf(path):
    where = pose((0.1, 0.2, 0.3), (1, 2, 3))
    write_scan(path, Scan(views=(grid_view(), grid_view("other", where=where))))


def _by_trimesh(path):
    trimesh.Trimesh(*topology.arrays(wave(5)), process=False).export(path)


def _stl_text(path):
    trimesh.Trimesh(*topology.arrays(plane(3)), process=False).export(
        path, file_type="stl_ascii"
    )


def _xyz(path):
    points = np.asarray(wave(5).points)
    normals = topology.vertex_normals(*topology.arrays(wave(5)))
    rows = np.hstack([points, normals])
    text = "\n".join(";".join(f"{x:.6f}" for x in row) for row in rows)
    path.write_text(f"# unit mm\nx;y;z;nx;ny;nz\n{text}\n")


def _asc(path):
    rows = np.asarray(wave(5).points)
    path.write_text("\n".join("\t".join(f"{x:.4f}" for x in row) for row in rows))


def _asc_grid(path):
    heights = grid_view().points[..., 2]
    text = "\n".join(
        " ".join(f"{h:.3f}" for h in row) for row in np.nan_to_num(heights, nan=-9999)
    )
    path.write_text(
        f"ncols {heights.shape[1]}\nnrows {heights.shape[0]}\nxllcorner -5\n"
        f"yllcorner 20\ncellsize 10\nNODATA_value -9999\n{text}\n"
    )


def _pts(path):
    rows = [f"{x:.5f} {y:.5f} {z:.5f} -1000 9 8 7" for x, y, z in wave(5).points]
    path.write_text(f"{len(rows)}\n" + "\n".join(rows) + f"\n1\n{rows[0]}\n")


def _ptx(path):
    where = pose((0.1, 0.2, 0.3), (1, 2, 3))
    points = grid_view(rows=4, columns=5).points - [0, 0, 400]
    path.write_text(
        ptx_text(
            [(points, where, where[:3, 3]), (points, np.eye(4), np.zeros(3))],
            colour=" 1 2 3",
        )
    )


def save_vtp(
    path, mesh, *, mode="appended", encode=True, compressor="ZLib", wide=False
):
    """A VTP file as VTK's own writer makes it."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(mesh)
    getattr(writer, f"SetDataModeTo{mode.capitalize()}")()
    writer.SetEncodeAppendedData(encode)
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    if wide:
        writer.SetHeaderTypeToUInt64()
    assert writer.Write()
    return path


def with_data(mesh):
    """A mesh with arrays on its points, its cells and itself."""
    rng = np.random.default_rng(0)
    mesh.point_data["rgb"] = rng.integers(0, 256, (mesh.n_points, 3), dtype=np.uint8)
    mesh.point_data["depth"] = rng.random(mesh.n_points)
    mesh.cell_data["label"] = np.arange(mesh.n_cells)
    mesh.field_data["wavelengths"] = np.arange(400.0, 701, 5)
    mesh.field_data["unit"] = ["mm"]
    return mesh


VTP = {
    "vtp, text": {"mode": "ascii"},
    "vtp, base64": {"mode": "binary"},
    "vtp, base64 uncompressed": {"mode": "binary", "compressor": "None"},
    "vtp, appended": {},
    "vtp, appended raw": {"encode": False, "wide": True},
    "vtp, raw uncompressed": {"encode": False, "compressor": "None"},
    "vtp, lzma": {"compressor": "LZMA"},
}
"""VTK's ways to write its XML files."""


def _vtp(options):
    def write(path):
        save_vtp(path, with_data(wave(5)), **options)

    return write


KINDS = {
    "ply": (".ply", _ply),
    "ply, text": (".ply", _ply_text),
    "ply, polygons": (".ply", _ply_polygons),
    "ply, points": (".ply", _ply_points),
    "ply, range grid": (".ply", _grid),
    "conf": (".conf", _conf),
    "obj": (".obj", _by_trimesh),
    "stl": (".stl", _by_trimesh),
    "stl, text": (".stl", _stl_text),
    "off": (".off", _by_trimesh),
    "xyz": (".xyz", _xyz),
    "asc": (".asc", _asc),
    "asc, grid": (".asc", _asc_grid),
    "pts": (".pts", _pts),
    "ptx": (".ptx", _ptx),
    **{name: (".vtp", _vtp(options)) for name, options in VTP.items()},
}
"""Every kind of file: its suffix, and what writes one."""

STATES_UNIT = {"ply", "ply, polygons", "ply, range grid", "conf", "xyz", *VTP}
"""Kinds whose sample says what its unit is."""


def write_sample(kind, folder):
    """A small valid file of a kind, in a folder that holds nothing else."""
    suffix, write = KINDS[kind]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"sample{suffix}"
    write(path)
    return path


def check_scan(scan):
    """Something was read, and all of it is finite and in range."""
    assert scan.views or scan.mesh is not None or scan.cloud is not None
    for view in scan.views:
        assert np.isfinite(view.pose).all()
        assert (np.isfinite(view.points).all(axis=-1) == view.valid).all()
        assert view.points.size
    if scan.views:
        assert any(view.valid.any() for view in scan.views)
    if scan.mesh is not None:
        points, faces = require_triangles(scan.mesh, "mesh")
        assert len(faces)
        assert np.isfinite(topology.face_areas(points, faces)).all()
    if scan.cloud is not None:
        assert len(scan.cloud.points)
        assert np.isfinite(scan.cloud.points).all()


def mutated(content, rng):
    """Bytes broken in one to three ways, drawn from a generator."""
    for _ in range(1 + int(rng.integers(0, 3)) // 2):
        content = MUTATIONS[rng.integers(len(MUTATIONS))](content, rng)
    return content


def _span(content, rng, most=40):
    start = int(rng.integers(0, len(content) + 1))
    return start, min(start + int(rng.integers(1, most)), len(content))


def _cut(content, rng):
    return content[: int(rng.integers(0, len(content) + 1))]


def _flip(content, rng):
    broken = bytearray(content)
    for _ in range(int(rng.integers(1, 9))):
        if broken:
            broken[rng.integers(len(broken))] ^= 1 << int(rng.integers(8))
    return bytes(broken)


def _drop(content, rng):
    start, end = _span(content, rng)
    return content[:start] + content[end:]


def _repeat(content, rng):
    start, end = _span(content, rng, 400)
    return content[:end] + content[start:end] * int(rng.integers(1, 4)) + content[end:]


def _insert(content, rng):
    start, _ = _span(content, rng)
    return content[:start] + rng.bytes(int(rng.integers(1, 20))) + content[start:]


def _fill(content, rng):
    start, end = _span(content, rng, 16)
    byte = (b"\xff", b"\x7f", b"\0", b"9", b" ")[rng.integers(5)]
    return content[:start] + byte * (end - start) + content[end:]


def _number(content, rng, head=None):
    found = list(re.finditer(rb"-?\d[\d.eE+-]*", content[:head]))
    if not found:
        return content
    match = found[rng.integers(len(found))]
    number = NUMBERS[rng.integers(len(NUMBERS))]
    return content[: match.start()] + number + content[match.end() :]


def _head_number(content, rng):
    return _number(content, rng, 500)


def _line(content, rng):
    lines = content.split(b"\n")
    i, j = (int(k) for k in rng.integers(0, len(lines), 2))
    if rng.random() < 0.5:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        del lines[i]
    return b"\n".join(lines)


def _endings(content, rng):
    return content.replace(b"\n", (b"\r\n", b"\r", b"\n\n")[rng.integers(3)], 7)


def _separator(content, rng):
    return content.replace(b" ", (b",", b";", b"\t", b"")[rng.integers(4)], 9)


def _mark(content, rng):
    return (b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff", b"\0")[rng.integers(4)] + content


def _twice(content, rng):
    return content + content


MUTATIONS = (
    *(_cut, _flip, _drop, _repeat, _insert, _fill, _number, _head_number, _line),
    *(_endings, _separator, _mark, _twice),
)
"""Ways to break a file: bytes and a generator in, bytes out."""
