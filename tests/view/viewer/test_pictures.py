"""What is shown of a state: the right scenes, in the right places, within tolerance."""

import dataclasses
import gc
import threading
import tracemalloc

import numpy as np
import pytest
from PIL import Image

from skinviz import Plan, read_scene, render
from skinviz.errors import SkinvizError
from skinviz.rendering.held import ONE_RAY
from skinviz.rendering.tolerance import colour_differences
from skinviz.view.viewer.controls import with_preset, with_surface
from skinviz.view.viewer.frames import OutdatedError, still_frame
from skinviz.view.viewer.opened import open_path, open_scene
from skinviz.view.viewer.pictures import Darkroom, jpeg, nice_above, png
from skinviz.view.viewer.shown import camera_of
from skinviz.view.viewer.state import Look
from skinviz.view.viewer.tiles import GAP, tiles_of

SIZE = (60, 48)


def test_at_first_the_scene_is_shown_as_it_is(opened, darkroom, scene_file):
    scene = read_scene(scene_file)
    scene = scene.replace(camera=dataclasses.replace(scene.camera, size=SIZE))
    shown = darkroom.quick(opened.initial, SIZE)
    np.testing.assert_array_equal(shown.picture, render(scene, ONE_RAY).rgb)
    exact = render(scene, Plan())
    still = darkroom.still(opened.initial, SIZE)
    assert still.picture.shape == (*SIZE[::-1], 3)
    off = np.abs(still.picture.astype(int) - exact.rgb.astype(int))
    assert np.percentile(off[exact.covered == 16], 99) <= 3
    assert still.plan.tolerance == 1.0


def test_a_still_picture_that_is_not_wanted_any_more_is_given_up(opened, darkroom):
    outdated = threading.Event()
    outdated.set()
    with pytest.raises(OutdatedError):
        still_frame(darkroom, opened.initial, SIZE, outdated)

    class Soon:
        """Wanted at first, and not once some pixels are done."""

        asked = 0

        def is_set(self):
            self.asked += 1
            return self.asked > 1

    with pytest.raises(OutdatedError):
        still_frame(darkroom, opened.initial, SIZE, Soon())


def test_without_a_file_the_shipped_hand_is_shown():
    hand = open_path(None)
    assert hand.own.fit is not None
    assert hand.scene.mesh.n_points > 20000


def test_turning_light_and_viewer_is_what_scene_files_say(opened, darkroom):
    """60/60 is light and viewer at 60 degrees, on opposite sides of the back."""
    state = with_preset(opened.initial, "60/60")
    (stage,) = darkroom.quick(state, SIZE).stages
    half = np.deg2rad(60)
    light = stage.scene.lights[0].direction
    np.testing.assert_allclose(light, opened.frame.direction(half), atol=1e-12)
    towards = stage.scene.camera.direction
    np.testing.assert_allclose(towards, opened.frame.direction(-half), atol=1e-12)


def test_zoom_and_shift_move_what_the_camera_frames(opened):
    view = camera_of(opened, opened.initial, SIZE).view(opened.geometry.in_mm)
    state = opened.initial.replace(zoom=2.0, shift=(3.0, -1.0))
    nearer = camera_of(opened, state, SIZE).view(opened.geometry.in_mm)
    assert nearer.pixel == pytest.approx(view.pixel / 2)
    moved = nearer.target - view.target
    assert moved @ view.right == pytest.approx(3.0)
    assert moved @ view.up == pytest.approx(-1.0)


def test_light_changes_what_is_shown_and_no_rays_are_cast(opened, darkroom):
    first = darkroom.quick(opened.initial, SIZE)
    state = opened.initial.replace(illuminant="A", light=(40.0, 0.0))
    second = darkroom.quick(state, SIZE)
    assert second.held is first.held
    assert (second.picture != first.picture).any()
    assert second.stages[0].scene.lights[0].spectrum.name == "A"


def test_moves_leave_no_memory_taken(opened):
    room = Darkroom(opened)
    rng = np.random.default_rng(4)

    def move():
        state = opened.initial.replace(
            view=(float(rng.uniform(-90, 90)), 0.0, 0.0),
            light=(float(rng.uniform(-60, 60)), 0.0),
        ).with_look(weights=tuple(rng.uniform(0.001, 0.2, 3).tolist()))
        room.quick(state, (24, 20))

    for _ in range(20):
        move()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    for _ in range(100):
        move()
    gc.collect()
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 1e6  # the two views that are kept, and no more


def test_only_the_last_views_and_fits_are_kept(opened):
    room = Darkroom(opened)
    for i in range(12):
        room.quick(opened.initial.replace(view=(float(i), 0.0, 0.0)), (24, 20))
    assert len(room._views) <= 2


@pytest.mark.parametrize(
    "model", ["torrance-sparrow", "cook-torrance", "phong", "lambert"]
)
def test_every_surface_can_be_shown(opened, darkroom, model):
    state = with_surface(opened.initial, opened, model)
    surface = darkroom.quick(state, SIZE).stages[0].scene.surface
    assert type(surface).name == model
    again = with_surface(state, opened, opened.initial.surface)
    assert again == opened.initial


def test_a_dispersion_is_an_index(opened, darkroom):
    state = opened.initial.replace(index="epidermis")
    surface = darkroom.quick(state, SIZE).stages[0].scene.surface
    assert surface.n.name == "epidermis"


@pytest.mark.parametrize(
    "change",
    [
        {"illuminant": "moonshine"},
        {"index": "glass"},
        {"index": "0.2"},
        {"width": 9.0},
        {"looks": (Look("China/0", "back of hand"),)},
        {"looks": (Look("", "", (1.0,)),)},
    ],
)
def test_what_cannot_be_shown_is_said_in_one_line(opened, darkroom, change):
    with pytest.raises(SkinvizError) as error:
        darkroom.quick(opened.initial.replace(**change), SIZE)
    assert str(error.value)


# Several hands ---------------------------------------------------------------


def two(state):
    return (
        state.with_hands(2)
        .replace(active=1)
        .with_look(person="UK/12", site="back of hand")
    )


def test_two_hands_differ_by_their_skin_alone(opened, darkroom):
    shown = darkroom.quick(two(opened.initial), (122, 48))
    left, right = shown.stages
    assert left.scene.camera is right.scene.camera
    assert shown.samples[1].name == "UK/12 back of hand"
    alone = darkroom.quick(opened.initial, shown.tiles.size)
    width = shown.tiles.size[0]
    np.testing.assert_array_equal(shown.picture[:, :width], alone.picture)
    assert (shown.picture[:, -width:] != alone.picture).any()


def test_the_map_between_them_is_their_colour_difference(opened, darkroom):
    state = two(opened.initial).replace(difference=True)
    shown = darkroom.quick(state, (184, 48))
    held, (one, other) = shown.held, shown.stages
    expected = colour_differences(
        *(np.concatenate(held.xyz(stage)).astype(float) for stage in (one, other)),
        one.white,
    )
    assert expected.max() > 0.5
    assert shown.scale == nice_above(np.percentile(expected, 99))
    still = darkroom.still(state, (184, 48))
    assert still.picture.shape == shown.picture.shape


def test_skin_does_not_differ_from_itself(opened, darkroom):
    state = opened.initial.with_hands(2).replace(difference=True)
    shown = darkroom.quick(state, (184, 48))
    left, _ = shown.tiles.corner(2)
    tile = shown.picture[:, left:]
    colours = {tuple(colour) for colour in tile.reshape(-1, 3).tolist()}
    assert colours == {shown.stages[0].scene.background, (68, 1, 84)}


@pytest.mark.parametrize(
    ("value", "nice"), [(0, 1), (0.9, 1), (1, 1), (1.1, 2), (37, 50)]
)
def test_scales_end_at_round_numbers(value, nice):
    assert nice_above(value) == nice


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_tiles_fill_the_picture_and_know_their_places(n):
    tiles = tiles_of(n, (301, 200))
    whole = tiles.whole
    assert 301 - 2 * n <= whole[0] <= 301
    assert whole[1] in (200, 199, 198)
    for tile in range(n):
        left, top = tiles.corner(tile)
        assert tiles.at(left + 1.5, top + 2.5) == (tile, 1.5, 2.5)
    assert tiles.at(-1, 5) is None
    assert tiles.at(whole[0] + GAP, 5) is None
    if n > 1:
        assert tiles.at(tiles.size[0] + 0.5, 5) is None


def test_stills_are_sent_without_loss(darkroom, opened, tmp_path):
    picture = darkroom.still(opened.initial, SIZE).picture
    file = tmp_path / "still.png"
    file.write_bytes(png(picture))
    with Image.open(file) as read:
        np.testing.assert_array_equal(np.asarray(read), picture)
    file.write_bytes(jpeg(picture))
    with Image.open(file) as read:
        assert read.size == SIZE


def test_a_scene_made_in_python_is_opened_as_it_is(opened):
    made = open_scene(opened.scene)
    shown = Darkroom(made).quick(made.initial, SIZE)
    expected = Darkroom(opened).quick(opened.initial, SIZE)
    np.testing.assert_array_equal(shown.picture, expected.picture)
    assert made.content is None
