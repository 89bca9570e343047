"""Maps that were painted: vertex data of a mesh file, and images."""

import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image

from meshes import plane, sphere
from skinviz import painted_image, painted_vertices, write_mesh
from skinviz.errors import ArgumentError, DataError, MeshError

AT_ONE = [0.2, 0.05, 0.04]


@pytest.fixture
def sheet():
    """A square of 40 mm whose texture coordinates are its x and y."""
    mesh = plane()
    mesh.point_data["Texture Coordinates"] = np.asarray(mesh.points)[:, :2] / 40 + 0.5
    return mesh


def ramps(n=33):
    """An image (n, n, 3), red to the right, green upwards, blue a half."""
    x = (np.arange(n) + 0.5) / n
    right, up = np.meshgrid(x, x[::-1])
    return np.stack([right, up, np.full((n, n), 0.5)], axis=-1)


@pytest.mark.parametrize("kind", ["png", "tif16", "tif", "exr"])
def test_an_image_that_is_cut_short_is_refused(tmp_path, sheet, kind):
    file = tmp_path / f"paint.{kind[:3]}"
    write(file, kind)
    content = file.read_bytes()
    for share in (0.1, 0.5, 0.9):
        file.write_bytes(content[: int(share * len(content))])
        with pytest.raises(DataError, match="no whole"):
            painted_image(sheet, file, AT_ONE)


def write(path, kind):
    """Write the ramps; how far numbers may be off by what the file keeps."""
    numbers = ramps()
    if kind == "png":
        Image.fromarray(np.round(255 * numbers).astype(np.uint8)).save(path)
        return 1 / 510
    if kind == "tif16":
        image = np.round(65535 * numbers).astype(np.uint16)
        tifffile.imwrite(path, image, photometric="rgb")
        return 1 / 131070
    if kind == "tif":
        tifffile.imwrite(path, numbers.astype(np.float32), photometric="rgb")
        return 1e-7
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": numbers.astype(np.float32)}).write(str(path))
    return 1e-7


@pytest.mark.parametrize("kind", ["png", "tif16", "tif", "exr"])
def test_an_image_is_laid_on_by_texture_coordinates(tmp_path, sheet, kind):
    file = tmp_path / f"paint.{kind[:3]}"
    allowed = write(file, kind)
    found = painted_image(sheet, file, AT_ONE) / AT_ONE
    u, v = np.asarray(sheet.point_data["Texture Coordinates"]).T
    inside = (u > 0.02) & (u < 0.98) & (v > 0.02) & (v < 0.98)
    np.testing.assert_allclose(found[inside, 0], u[inside], atol=2 * allowed)
    np.testing.assert_allclose(found[inside, 1], v[inside], atol=2 * allowed)
    np.testing.assert_allclose(found[:, 2], 0.5, atol=2 * allowed)


def test_a_png_of_16_bits_is_refused(tmp_path, sheet):
    # Pillow can write grey of 16 bits; what it would keep of colours is 8.
    Image.fromarray(np.full((4, 4), 12345, np.uint16)).save(tmp_path / "deep.png")
    with pytest.raises(DataError, match=r"not of 8 bits a channel; save it as .tif"):
        painted_image(sheet, tmp_path / "deep.png", [1.0])


def test_beyond_the_middles_of_outer_pixels_it_is_even(tmp_path, sheet):
    tifffile.imwrite(tmp_path / "two.tif", np.array([[0.0, 1.0]], np.float32))
    found = painted_image(sheet, tmp_path / "two.tif", [1.0])[:, 0]
    u = np.asarray(sheet.point_data["Texture Coordinates"])[:, 0]
    np.testing.assert_allclose(found, np.clip(2 * u - 0.5, 0, 1), atol=1e-12)


def test_vertex_data_come_back(tmp_path, sheet):
    values = np.random.default_rng(1).uniform(0, 1, (sheet.n_points, 3))
    sheet.point_data["pigments"] = values
    write_mesh(tmp_path / "painted.vtp", sheet)
    np.testing.assert_array_equal(
        painted_vertices(plane(), tmp_path / "painted.vtp"), values
    )


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (sphere(20, 2), "81 vertices, the mesh 162"),
        (plane(9, 50.0), "5 mm from the mesh's"),
    ],
)
def test_another_meshs_paint_is_refused(tmp_path, sheet, mesh, message):
    sheet.point_data["pigments"] = np.zeros((sheet.n_points, 3))
    write_mesh(tmp_path / "painted.vtp", sheet)
    with pytest.raises(MeshError, match=message):
        painted_vertices(mesh, tmp_path / "painted.vtp")


def test_a_file_without_paint_tells_what_it_has(tmp_path, sheet):
    write_mesh(tmp_path / "bare.vtp", sheet)
    with pytest.raises(MeshError, match=r"no point data 'pigments'.*Texture"):
        painted_vertices(sheet, tmp_path / "bare.vtp")


def test_a_mesh_without_coordinates_is_refused(tmp_path):
    write(tmp_path / "paint.tif", "tif")
    with pytest.raises(MeshError, match="no texture coordinates"):
        painted_image(plane(), tmp_path / "paint.tif", AT_ONE)


def test_coordinates_beyond_the_image_are_refused(tmp_path, sheet):
    write(tmp_path / "paint.tif", "tif")
    sheet.point_data["Texture Coordinates"] *= 2
    with pytest.raises(MeshError, match="within 0 and 1"):
        painted_image(sheet, tmp_path / "paint.tif", AT_ONE)


@pytest.mark.parametrize(
    ("name", "content", "error", "message"),
    [
        ("a.png", b"\x89PNG\r\n\x1a\n no more", DataError, "no whole .png"),
        ("a.tif", b"II*\x00 no more", DataError, "no whole .tif"),
        ("a.exr", b"v/1\x01 no more", DataError, "no whole .exr"),
        ("a.jpg", b"whatever", ArgumentError, "image suffix"),
        ("a.tif", None, DataError, "no such file"),
    ],
)
def test_broken_images_are_refused(tmp_path, sheet, name, content, error, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(error, match=message):
        painted_image(sheet, tmp_path / name, AT_ONE)


@pytest.mark.parametrize(
    ("pixels", "at_one", "message"),
    [
        (np.zeros((4, 4), np.float32), AT_ONE, "1 channels; 3 are needed"),
        (np.full((4, 4, 3), np.nan, np.float32), AT_ONE, "not finite"),
        (np.zeros((4, 4, 3), np.int16), AT_ONE, "unsigned whole numbers or floats"),
        (np.zeros((4, 4, 3), np.float32), [np.inf, 1, 1], "finite"),
    ],
)
def test_images_that_are_no_maps_are_refused(tmp_path, sheet, pixels, at_one, message):
    kind = "rgb" if pixels.ndim == 3 else "minisblack"
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric=kind)
    with pytest.raises((DataError, ArgumentError), match=message):
        painted_image(sheet, tmp_path / "a.tif", at_one)
