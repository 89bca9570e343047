"""Pictures: their colours, spectra and parts agree, and what is no part is refused."""

import json
import tracemalloc

import numpy as np
import pytest

from meshes import joined, sphere, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    geometry_of,
    render,
)
from skinviz.errors import ArgumentError
from skinviz.spectra.colorimetry import colour_matching_functions
from skinviz.spectra.wavelengths import band_widths
from skinviz.surface.torrance_sparrow import TorranceSparrow

UP = [0.0, 1.0, 0.0]
SIZE = (37, 29)


@pytest.fixture(params=["uniform", "mapped", "diffuse", "one band"])
def scene(request, matt):
    """Glossy skin with shadows, in each of the ways that radiance is computed."""
    mesh = joined(wave(17), sphere(8, 2, centre=(2, -3, 12)))
    rng = np.random.default_rng(7)
    shape = (mesh.n_points, 3) if request.param == "mapped" else (3,)
    return matt.replace(
        mesh=mesh,
        skin=Skin(matt.skin.model, rng.uniform(0.001, 0.1, shape)),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([-0.4, 0.2, 1]), PointLight([30, 20, 60], "FL2", 0.3)),
        camera=Camera([0.2, -0.3, 1], UP, SIZE, distance=250.0),
        interreflection="diffuse" if request.param == "diffuse" else "none",
        wavelengths=[550.0] if request.param == "one band" else matt.wavelengths,
    )


@pytest.fixture
def picture(scene):
    return render(scene, Plan(samples=4, bounce_rays=64, spectrum="scene"))


# What agrees --------------------------------------------------------------------


def test_pixels_regions_and_rows_are_parts_of_the_whole_bit_for_bit(picture):
    whole = picture.radiance()
    width, height = SIZE
    assert whole.shape == (height, width, picture.wavelengths.size)
    assert whole.dtype == np.float32
    for column, row in [(0, 0), (width - 1, height - 1), (18, 14), (20, 11), (3, 25)]:
        part = picture.radiance((column, row))
        np.testing.assert_array_equal(part, whole[row, column])
    for box in [
        (0, 0, width, height),
        (5, 7, 31, 20),
        (0, 3, width, 4),
        (36, 0, 37, 29),
    ]:
        left, top, right, bottom = box
        part = picture.radiance(box)
        np.testing.assert_array_equal(part, whole[top:bottom, left:right])
    rows = [block.copy() for block in picture.rows()]
    np.testing.assert_array_equal(np.concatenate(rows), whole)


def test_a_picture_and_its_mesh_are_told_in_a_line(picture):
    width, height = picture.size
    told = repr(picture)
    assert told.startswith(f"Rendering({width} x {height} pixels, ")
    assert f"{picture.wavelengths.size} bands" in told
    mesh = picture.scene.mesh
    assert repr(geometry_of(mesh)) == (
        f"Geometry({mesh.n_points} vertices, {mesh.n_cells} triangles)"
    )


def test_asking_again_gives_the_same(picture):
    np.testing.assert_array_equal(picture.radiance(), picture.radiance())
    again = render(picture.scene, picture.plan)
    np.testing.assert_array_equal(again.xyz, picture.xyz)
    np.testing.assert_array_equal(again.covered, picture.covered)
    np.testing.assert_array_equal(again.rgb, picture.rgb)


def test_colours_are_those_of_the_spectra(picture):
    cmfs = colour_matching_functions(picture.wavelengths)
    seen = picture.radiance().astype(float) * band_widths(picture.wavelengths)
    np.testing.assert_allclose(seen @ cmfs, picture.xyz, rtol=1e-6, atol=1e-9)


def test_rows_come_from_the_top_in_blocks_that_fit(scene):
    # Wide pictures come a few rows at a time, and the last block may be smaller.
    camera = Camera([0, 0, 1], UP, (9000, 17))
    picture = render(scene.replace(camera=camera), Plan(samples=1, bounce_rays=16))
    heights = []
    for block in picture.rows():
        assert block.dtype == np.float32
        assert block.shape[1:] == (9000, picture.wavelengths.size)
        top = sum(heights)
        np.testing.assert_array_equal(
            block[0, 4400:4500], picture.radiance((4400, top, 4500, top + 1))[0]
        )
        heights.append(len(block))
    assert sum(heights) == 17
    assert (len(heights) > 1) == (picture.wavelengths.size > 1)


def test_spectra_are_written_where_they_are_asked_for(picture):
    width, height = SIZE
    bands = picture.wavelengths.size
    out = np.full((height, width, bands), np.nan, dtype=np.float32)
    assert picture.radiance(out=out) is out
    np.testing.assert_array_equal(out, picture.radiance())
    part = np.full((3, 4, bands), np.nan, dtype=np.float32)
    assert picture.radiance((10, 8, 14, 11), out=part) is part
    np.testing.assert_array_equal(part, out[8:11, 10:14])


def test_progress_is_told_pixel_by_pixel(scene):
    told = []
    picture = render(scene, Plan(samples=1), advance=told.append)
    assert sum(told) == SIZE[0] * SIZE[1]
    for ask in (
        lambda: picture.radiance(advance=told.append),
        lambda: list(picture.rows(told.append)),
    ):
        told.clear()
        ask()
        assert sum(told) == SIZE[0] * SIZE[1]
    told.clear()
    picture.radiance((3, 4, 10, 9), advance=told.append)
    assert sum(told) == 35


def test_what_misses_the_mesh_is_dark_and_shows_the_background(picture):
    empty = picture.covered == 0
    assert empty.any()
    assert not picture.xyz[empty].any()
    assert not picture.radiance()[empty].any()
    assert (picture.rgb[empty] == picture.scene.background).all()


def test_a_picture_is_described_in_json(picture):
    told = json.loads(json.dumps(picture.metadata))
    assert told["plan"]["samples"] == 4
    assert told["plan"]["spectrum"] == "scene"
    assert told["plan"]["findings"] == []
    assert told["counts"]["total"] == np.count_nonzero(picture.covered)
    assert told["notes"] == []
    assert told["scene"]["camera"]["size_pixels"] == list(SIZE)
    assert told["scene"]["interreflection"] == picture.scene.interreflection


def test_numbers_of_numpy_are_described_too(white):
    camera = Camera(
        np.array([0, 0, 1]),
        UP,
        (np.int64(4), np.int32(3)),
        distance=np.float32(100),
        target=np.zeros(3, dtype=np.float32),
        height=np.int64(5),
    )
    picture = render(white.replace(camera=camera), Plan(np.int64(1)))
    json.dumps(picture.metadata)


def test_more_samples_are_the_same_picture_more_smoothly(scene):
    pictures = [render(scene, Plan(n, bounce_rays=64)) for n in (1, 4, 16)]
    means = [picture.xyz[..., 1].mean() for picture in pictures]
    np.testing.assert_allclose(means, means[-1], rtol=0.01)
    finest = pictures[-1].xyz
    off = [np.abs(picture.xyz - finest).mean() for picture in pictures[:-1]]
    assert off[0] > off[1] > 0


# What is refused ----------------------------------------------------------------


@pytest.fixture
def square(white):
    return render(white.replace(camera=Camera([0, 0, 1], UP, (8, 6))), Plan(1))


@pytest.mark.parametrize(
    "where",
    [
        *((8, 0), (0, 6), (-1, 0), (0, -1), (10**9, 0)),
        *((0, 0, 9, 6), (0, 0, 8, 7), (3, 3, 3, 4), (3, 3, 4, 3), (5, 0, 2, 6)),
        *((1.5, 2), (np.nan, 1), (True, 0), ("a", "b"), "ab", (None, 1)),
        *((), (1,), (1, 2, 3), (1, 2, 3, 4, 5), 5, 1.5, [[1, 2], [3, 4]]),
    ],
)
def test_what_is_no_part_of_a_picture_is_refused(square, where):
    with pytest.raises(ArgumentError, match=r"column|row|within"):
        square.radiance(where)


@pytest.mark.parametrize("where", [(3, 2), [3, 2], np.array([3, 2]), (3.0, np.int8(2))])
def test_pixels_may_be_given_as_any_whole_numbers(square, where):
    np.testing.assert_array_equal(square.radiance(where), square.radiance((3, 2)))


@pytest.mark.parametrize(
    "out",
    [
        np.zeros((6, 8, 61)),
        np.zeros((8, 6, 61), np.float32),
        np.zeros((6, 8, 60), np.float32),
        np.zeros((61, 8, 6), np.float32).T,
        np.zeros((6, 16, 61), np.float32)[:, ::2],
        np.zeros(6 * 8 * 61, np.float32),
        [[0.0]],
        "memory",
    ],
)
def test_memory_that_spectra_do_not_fit_is_refused(square, out):
    with pytest.raises(ArgumentError, match=r"out must be .*float32.*\(6, 8, 61\)"):
        square.radiance(out=out)


def test_too_large_pictures_say_what_they_take_before_anything_is_computed():
    for size, told in [
        ((20000, 20000), "5.96 GiB"),
        ((16000, 16000), "256 million pixels"),
        ((8193, 8192), "at most 16384 a side and 67 million"),
        ((10**6, 10**6), "GiB"),
        ((16385, 1), "16384 a side"),
    ]:
        with pytest.raises(ArgumentError, match=told):
            Camera([0, 0, 1], UP, size)


def test_spectra_that_no_memory_holds_say_what_they_take(square, monkeypatch):
    def none_left(*args, **kwargs):
        raise MemoryError

    monkeypatch.setattr(np, "zeros", none_left)
    with pytest.raises(
        ArgumentError, match=r"8 x 6 pixels in 61 bands .*GiB.*rows\(\)"
    ):
        square.radiance()


# Memory -------------------------------------------------------------------------


@pytest.mark.parametrize("mapped", [False, True])
def test_rows_take_the_memory_of_a_block_not_of_the_whole(white, mapped):
    bands, size = 4000, (128, 128)
    values = np.full((white.mesh.n_points, 1), 0.5) if mapped else [0.5]
    scene = white.replace(
        skin=Skin(white.skin.model, values),
        wavelengths=np.linspace(400, 700, bands),
        camera=Camera([0, 0, 1], UP, size),
    )
    picture = render(scene, Plan(1))
    tracemalloc.start()
    for _ in picture.rows():
        pass
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    whole = 4 * bands * size[0] * size[1]
    assert peak < whole / 2


def test_mapped_skin_without_reflection_is_skin_that_has_none(white, model):
    values = np.tile([0.1, 0.005, 0.005], (white.mesh.n_points, 1))
    values[::3] = 0.01
    glossy = white.replace(skin=Skin(model, values), surface=TorranceSparrow())
    dull = glossy.replace(surface=TorranceSparrow(specular_scale=0))
    for _ in range(5):  # memory that nobody wrote differs from time to time
        left_out = render(glossy, Plan(specular="none")).radiance()
        np.testing.assert_array_equal(left_out, render(dull, Plan()).radiance())
