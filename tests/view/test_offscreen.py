"""Pictures show a mesh's own colours, where they say that they show them."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from meshes import joined, moved, plane, pose, sphere, toy_hand
from skinviz import Camera
from skinviz.errors import SkinvizError, SystemLibraryError
from skinviz.scene.camera import View
from skinviz.view import offscreen
from skinviz.view.offscreen import BACKGROUND, Picture, draw, save_picture

RGB = (200, 100, 50)
FRONT = Camera([0, 0, 1], [0, 1, 0], (64, 48))


def seen(scale=1.0):
    """The view from the front of the origin at so many pixels a millimetre."""
    return View(np.zeros(3), *np.eye(3), np.inf, 1 / scale, FRONT.size)


def painted(mesh, colour=RGB):
    mesh.point_data["rgb"] = np.tile(np.array(colour, np.uint8), (mesh.n_points, 1))
    return mesh


def is_background(rgb):
    return (rgb == np.array(BACKGROUND)).all(axis=-1)


def bright_spot(mesh, point, radius):
    """Paint a mesh black and its points near one point white."""
    painted(mesh, (0, 0, 0))
    near = np.linalg.norm(np.asarray(mesh.points) - point, axis=1) < radius
    assert near.any()
    mesh.point_data["rgb"][near] = 255
    return mesh


def middle_of_brightness(picture):
    """Where the bright pixels' centre lies, pixel (0, 0) being 0 to 1 wide."""
    weight = picture.rgb[..., 0].astype(float)
    weight[is_background(picture.rgb)] = 0
    weight[weight < 100] = 0
    rows, columns = np.indices(weight.shape) + 0.5
    return (columns * weight).sum() / weight.sum(), (rows * weight).sum() / weight.sum()


# Colours --------------------------------------------------------------------


@pytest.mark.parametrize("colour", [RGB, (0, 0, 0), (255, 255, 255), (1, 128, 254)])
def test_a_flat_patch_is_shown_in_its_colour(colour):
    picture = draw(painted(plane(), colour), FRONT)
    assert picture.rgb.shape == (48, 64, 3)
    assert picture.rgb.dtype == np.uint8
    inside = picture.rgb[6:42, 16:48].astype(int)
    assert np.abs(inside - colour).max() <= 1


def test_around_the_mesh_is_background():
    rgb = draw(painted(plane()), FRONT).rgb
    # The square fills the height but for the margin, and is as wide as high.
    assert is_background(rgb[:, :8]).all()
    assert is_background(rgb[:, -8:]).all()
    assert not is_background(rgb[3:-3, 12:-12]).any()


def test_the_colour_does_not_depend_on_the_light_side_or_tilt():
    for direction in ([0, 0, 1], [0, 0, -1], [2, 1, 1]):
        camera = Camera(direction, [0, 1, 0], (40, 40))
        middle = draw(painted(plane()), camera).rgb[20, 20].astype(int)
        assert np.abs(middle - RGB).max() <= 1


def test_edges_are_mixed_in_linear_light():
    # White next to black background: each edge pixel holds 0 to 9 white samples.
    mesh = painted(moved(plane(), pose((0, 0, 0.3))), (255, 255, 255))
    rgb = draw(mesh, FRONT).rgb[..., 0].ravel()
    levels = np.arange(10) / 9
    dark = ((BACKGROUND[0] / 255 + 0.055) / 1.055) ** 2.4
    mixed = levels + (1 - levels) * dark
    expected = np.round(255 * (1.055 * mixed ** (1 / 2.4) - 0.055))
    gaps = np.abs(rgb[:, None] - expected).min(axis=1)
    assert gaps.max() <= 1
    assert len(np.unique(rgb)) >= 6


def test_the_nearer_surface_hides_the_farther():
    near = painted(sphere(10, 3, centre=(0, 0, 30)), (255, 0, 0))
    far = painted(sphere(20, 3, centre=(0, 0, -30)), (0, 0, 255))
    both = joined(near, far)
    both.point_data["rgb"] = np.concatenate(
        [near.point_data["rgb"], far.point_data["rgb"]]
    )
    front = draw(both, Camera([0, 0, 1], [0, 1, 0], (41, 41))).rgb
    back = draw(both, Camera([0, 0, -1], [0, 1, 0], (41, 41))).rgb
    assert front[20, 20].tolist() == [255, 0, 0]
    assert back[20, 20].tolist() == [0, 0, 255]
    assert front[20, 5].tolist() == [0, 0, 255]


# Where things are -------------------------------------------------------------


VIEWS = {
    "front": Camera([0, 0, 1], [0, 1, 0], (160, 120)),
    "tall": Camera([0, 0, 1], [0, 1, 0], (90, 200)),
    "turned": Camera([0, 0, 1], [1, 0.4, 0], (150, 150)),
    "askew": Camera([0.5, -0.3, 0.8], [0.2, 1, 0.1], (200, 140)),
    "behind": Camera([0.1, 0.2, -1], [0, 1, 0], (140, 140)),
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("place", [(0, 0, 0), (-524.0, 190.0, 296.0)])
def test_a_point_is_where_project_says(view, place):
    point = np.array([12.0, -8.0, 0.0]) + place
    mesh = bright_spot(moved(plane(81), pose(shift=place)), point, 2.0)
    picture = draw(mesh, VIEWS[view])
    found = middle_of_brightness(picture)
    np.testing.assert_allclose(found, picture.view.project(point), atol=0.35)


def test_right_is_right_and_up_is_up():
    picture = Picture(np.zeros((100, 200, 3), np.uint8), seen(2.0))
    size = FRONT.size
    assert tuple(picture.view.project([0, 0, 0])) == (size[0] / 2, size[1] / 2)
    assert tuple(picture.view.project([3, 0, 5])) == (size[0] / 2 + 6, size[1] / 2)
    assert tuple(picture.view.project([0, 3, -9])) == (size[0] / 2, size[1] / 2 - 6)


@pytest.mark.parametrize("size", [(200, 50), (50, 200), (97, 103)])
def test_the_whole_mesh_is_in_the_picture(size):
    mesh = painted(toy_hand())
    rng = np.random.default_rng(0)
    for _ in range(3):
        camera = Camera(rng.standard_normal(3), rng.standard_normal(3), size)
        picture = draw(mesh, camera)
        at = np.array([picture.view.project(p) for p in np.asarray(mesh.points)[::10]])
        assert (at > 0).all()
        assert (at < size).all()
        shown = ~is_background(picture.rgb)
        rim = [shown[0], shown[-1], shown[:, 0], shown[:, -1]]
        assert not np.concatenate(rim).any()
        # It fills the picture in one of its two directions.
        spans = np.ptp(np.argwhere(shown), axis=0) / shown.shape
        assert spans.max() > 0.88


def test_depth_is_never_cut_off():
    # A long object seen along its length: both ends are drawn.
    ends = joined(sphere(3, 2, centre=(8, 0, 400)), sphere(3, 2, centre=(-8, 0, -400)))
    rgb = draw(painted(ends), Camera([0, 0, 1], [0, 1, 0], (60, 40))).rgb
    shown = ~is_background(rgb)
    assert shown[:, :30].any()
    assert shown[:, 30:].any()


# Sizes ------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (9, 1), (2, 3)])
def test_the_smallest_pictures_have_their_size(size):
    picture = draw(painted(plane()), Camera([0, 0, 1], [0, 1, 0], size))
    assert picture.rgb.shape == (size[1], size[0], 3)
    if size == (1, 1):
        assert np.abs(picture.rgb[0, 0].astype(int) - RGB).max() <= 1


@pytest.mark.parametrize("size", [(5000, 4), (6000, 4), (4, 6000), (16384, 3)])
def test_the_largest_pictures_are_right_or_refused(size):
    # A graphics driver has a largest canvas; beyond it no noise may be handed out.
    try:
        rgb = draw(painted(plane()), Camera([0, 0, 1], [0, 1, 0], size)).rgb
    except SkinvizError:
        return
    width, height = size
    assert rgb.shape == (height, width, 3)
    middle = rgb[height // 2, width // 2].astype(int)
    assert np.abs(middle - RGB).max() <= 1
    assert is_background(rgb[0, 0])
    assert is_background(rgb[-1, -1])
    shown = (~is_background(rgb)).sum()
    assert shown <= (min(size) + 2) ** 2


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_tiny_and_huge_meshes_fill_the_picture(scale):
    mesh = plane()
    mesh.points = np.asarray(mesh.points) * scale
    rgb = draw(painted(mesh), FRONT).rgb
    assert np.abs(rgb[24, 32].astype(int) - RGB).max() <= 1
    assert not is_background(rgb[3:-3, 12:-12]).any()


# The rest ---------------------------------------------------------------------


def test_drawing_twice_gives_the_same_picture_and_leaves_the_mesh():
    mesh = painted(toy_hand())
    before = np.array(mesh.points)
    first, second = draw(mesh, FRONT), draw(mesh, FRONT)
    np.testing.assert_array_equal(first.rgb, second.rgb)
    np.testing.assert_array_equal(mesh.points, before)
    assert list(mesh.point_data.keys()) == ["rgb"]


def test_a_mesh_without_colours_is_refused():
    with pytest.raises(SkinvizError, match="rgb"):
        draw(plane(), FRONT)


def test_a_missing_system_library_is_told_before_drawing(monkeypatch):
    def lacking(user):
        raise SystemLibraryError(f"{user} needs libEGL.so.1")

    monkeypatch.setattr(offscreen, "require_system_libraries", lacking)
    with pytest.raises(SystemLibraryError, match=r"vtk needs libEGL\.so\.1"):
        draw(painted(plane()), FRONT)


def chunks(content):
    """Names and contents of a PNG file's chunks, their checksums checked."""
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    at, found = 8, []
    while at < len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        name, data = content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        (check,) = struct.unpack(">I", content[at + 8 + length : at + 12 + length])
        assert zlib.crc32(name + data) == check
        found.append((name, data))
        at += 12 + length
    return found


def some_picture():
    rgb = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    return Picture(rgb, seen())


def test_a_saved_picture_reads_back_and_is_marked_as_srgb(tmp_path):
    picture = some_picture()
    file = save_picture(picture, tmp_path / "new" / "a.png")
    assert file == tmp_path / "new" / "a.png"
    with Image.open(file) as image:
        assert image.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(image), picture.rgb)
    names = [name for name, _ in chunks(file.read_bytes())]
    assert names[0] == b"IHDR"
    assert names[-1] == b"IEND"
    assert names.index(b"sRGB") < names.index(b"IDAT")
    assert dict(chunks(file.read_bytes()))[b"sRGB"] == b"\x00"
    assert b"tIME" not in names


def test_a_picture_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    file = save_picture(some_picture(), tmp_path / "a.png")
    before = file.read_bytes()

    def fail(self, path, *args, **kwargs):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Image.Image, "save", fail)
    with pytest.raises(SkinvizError, match=r"cannot write .*a\.png.*No space left"):
        save_picture(some_picture(), file)
    assert file.read_bytes() == before
    assert [f.name for f in tmp_path.iterdir()] == ["a.png"]
