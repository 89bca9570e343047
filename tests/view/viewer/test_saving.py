"""What is saved is what is shown, in the opened folder and nowhere else."""

import dataclasses

import numpy as np
import pytest
from PIL import Image

from skinviz import read_scene
from skinviz.cli.main import main
from skinviz.errors import SkinvizError
from skinviz.view.viewer.controls import with_surface
from skinviz.view.viewer.opened import open_path, open_scene
from skinviz.view.viewer.pictures import Darkroom
from skinviz.view.viewer.readings import mark_at
from skinviz.view.viewer.saving import (
    FIGURE_SUFFIXES,
    SCENE_SUFFIXES,
    command,
    file_named,
    save_scene,
    save_view_figure,
    scene_content,
    toml_text,
)

SIZE = (48, 40)


def saved_again(opened, state, tmp_path, scene_file):
    """Save a state's scene beside its mesh and show it as a fresh viewer does."""
    shown = Darkroom(opened).quick(state, SIZE)
    text = toml_text(scene_content(opened, shown))
    again = tmp_path / "again.toml"
    again.write_text(text.replace("ball.ply", str(scene_file.with_name("ball.ply"))))
    reopened = open_path(again)
    return shown, Darkroom(reopened).quick(reopened.initial, SIZE), reopened


def test_relief_stays_under_the_skin_of_another(scene_file, tmp_path):
    ball = scene_file.with_name("ball.ply")
    text = scene_file.read_text().replace("ball.ply", str(ball))
    rough = tmp_path / "rough.toml"
    texture = "[skin.texture]\nrelief_um = 80\nrelief_mm = 6.0\nseed = 4\n\n[[lights]]"
    rough.write_text(text.replace("[[lights]]", texture))
    opened = open_path(rough)
    person = opened.samples.people("")[3]
    look = {"person": person, "site": opened.samples.sites(person)[0]}
    for weights in ((), (0.2, 0.01, 0.004)):
        state = opened.initial.with_look(**look, weights=weights)
        shown = Darkroom(opened).quick(state, SIZE)
        saved = tmp_path / "saved.toml"
        saved.write_text(toml_text(scene_content(opened, shown)))
        assert read_scene(saved).relief == shown.stages[0].scene.relief
        assert read_scene(saved).relief.depth == 80


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"light": (30.0, 10.0), "view": (40.0, -20.0, 15.0)},
        {"zoom": 1.7, "shift": (4.0, -3.0)},
        {"illuminant": "A", "exposure": 1.5, "white": "cat16"},
        {"width": 0.4, "index": "epidermis", "specular_scale": 0.5},
    ],
)
def test_a_saved_scene_shows_the_same(opened, changes, tmp_path, scene_file):
    state = opened.initial.replace(**changes)
    shown, again, _ = saved_again(opened, state, tmp_path, scene_file)
    off = np.abs(shown.picture.astype(int) - again.picture.astype(int))
    assert off.max() <= 1


def test_the_skin_that_was_set_is_saved(opened, tmp_path, scene_file):
    state = opened.initial.with_look(weights=(0.2, 0.01, 0.004))
    shown, again, _ = saved_again(opened, state, tmp_path, scene_file)
    np.testing.assert_array_equal(shown.picture, again.picture)


def test_another_person_is_saved_by_name(opened, tmp_path, scene_file):
    state = opened.initial.with_look(person="UK/12", site="cheek")
    shown, again, reopened = saved_again(opened, state, tmp_path, scene_file)
    np.testing.assert_array_equal(shown.picture, again.picture)
    assert reopened.own.name == "UK/12 cheek"


@pytest.mark.parametrize("model", ["cook-torrance", "phong", "lambert"])
def test_another_surface_is_saved(opened, model, tmp_path, scene_file):
    state = with_surface(opened.initial, opened, model)
    shown, again, _ = saved_again(opened, state, tmp_path, scene_file)
    np.testing.assert_array_equal(shown.picture, again.picture)


def test_of_several_hands_the_active_one_is_saved(opened, tmp_path, scene_file):
    state = opened.initial.with_hands(2).replace(active=1)
    state = state.with_look(person="UK/12", site="cheek")
    *_, reopened = saved_again(opened, state, tmp_path, scene_file)
    assert reopened.own.name == "UK/12 cheek"


def test_the_command_draws_the_saved_scene(scene_file, tmp_path, monkeypatch, capsys):
    (tmp_path / "ball.ply").write_bytes(scene_file.with_name("ball.ply").read_bytes())
    (tmp_path / "ball.toml").write_bytes(scene_file.read_bytes())
    opened = open_path(tmp_path / "ball.toml")
    state = opened.initial.replace(illuminant="A", tolerance=2.0)
    shown = Darkroom(opened).quick(state, SIZE)
    file = save_scene(opened, shown, "by hand.toml")
    assert read_scene(file).lights[0].illuminant == "A"
    words = command(file.name, state)
    assert words == "skinviz render 'by hand.toml' -o 'by hand.png' --tolerance 2"
    monkeypatch.chdir(tmp_path)
    assert (
        main(["render", "by hand.toml", "-o", "by hand.png", "--tolerance", "2"]) == 0
    )
    with Image.open(tmp_path / "by hand.png") as drawn:
        assert drawn.size == SIZE
    capsys.readouterr()


def test_a_scene_made_in_python_has_no_file_to_change(opened, tmp_path):
    made = dataclasses.replace(open_scene(opened.scene), folder=tmp_path)
    shown = Darkroom(made).quick(made.initial, SIZE)
    with pytest.raises(SkinvizError, match="made in Python"):
        save_scene(made, shown, "scene.toml")
    assert not list(tmp_path.iterdir())


# Figures ---------------------------------------------------------------------


@pytest.mark.parametrize("suffix", FIGURE_SUFFIXES)
def test_a_figure_of_two_hands_and_two_points(own_folder, suffix):
    room = Darkroom(own_folder)
    state = own_folder.initial.with_hands(2)
    for i, place in enumerate([(30, 22), (20, 26)]):
        mark = mark_at(room.quick(state, (120, 48)), *place)
        state = state.marking(mark, second=i == 1)
    shown = room.quick(state, (120, 48))
    file = save_view_figure(own_folder, shown, f"two{suffix}")
    assert file == own_folder.folder / f"two{suffix}"
    assert file.stat().st_size > 10_000


def test_a_figure_of_skin_that_was_set(own_folder):
    state = own_folder.initial.with_look(weights=(0.2, 0.01, 0.004))
    shown = Darkroom(own_folder).quick(state, SIZE)
    assert save_view_figure(own_folder, shown, "set.png").is_file()


# Names -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "../out.png",
        "/etc/out.png",
        "a/b.png",
        "..png",
        ".hidden.png",
        "a\\b.png",
        "a\0.png",
        "a..png",
        "",
        "view",
        "view.sh",
        "view.toml",
        "x" * 200 + ".png",
        None,
        7,
        ["view.png"],
    ],
)
def test_no_file_outside_the_folder_can_be_named(own_folder, name):
    with pytest.raises(SkinvizError):
        file_named(own_folder, name, FIGURE_SUFFIXES)
    assert not list(own_folder.folder.iterdir())


def test_what_is_there_already_is_left_alone(own_folder):
    old = own_folder.folder / "mine.toml"
    old.write_text("mine")
    with pytest.raises(SkinvizError, match="there already"):
        file_named(own_folder, "mine.toml", SCENE_SUFFIXES)
    (own_folder.folder / "link.png").symlink_to("/nonexistent/elsewhere.png")
    with pytest.raises(SkinvizError, match="there already"):
        file_named(own_folder, "link.png", FIGURE_SUFFIXES)
    assert old.read_text() == "mine"


def test_toml_says_what_it_was_given():
    import tomllib

    content = {
        "skin": {
            "site": 'a "b" \\ c',
            "weights": [0.1, 1e-7],
            "record": 2,
            "change": {"melanin": "x2"},
            "point": [{"at": [1.0, 2.0]}, {"at": [3.0, 4.0]}],
        },
        "lights": [{"lines": [[532.0, 1.0]], "strength": 2.0}, {"illuminant": "A"}],
        "view": {"background": [1, 2, 3], "on": True},
    }
    assert tomllib.loads(toml_text(content)) == content
