"""A small ball to look at, with the skin of a person of the archive."""

import dataclasses

import pytest

from meshes import sphere
from skinviz.scan.formats import write_mesh
from skinviz.view.viewer.opened import open_path
from skinviz.view.viewer.pictures import Darkroom
from skinviz.view.viewer.readings import mark_at

SCENE = """\
[mesh]
path = "ball.ply"
unit = "mm"

[skin]
archive = "issa"
origin = "China"
subject = "186"
site = "back of hand"

[[lights]]
illuminant = "D65"
direction = [0.0, 0.3, 1.0]

[view]
direction = [0.0, 0.0, 1.0]
up = [0.0, 1.0, 0.0]
size = [48, 40]
"""


@pytest.fixture(scope="session")
def scene_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("opened")
    write_mesh(folder / "ball.ply", sphere(40, 3))
    file = folder / "ball.toml"
    file.write_text(SCENE, encoding="utf-8")
    return file


@pytest.fixture(scope="session")
def opened(scene_file):
    return open_path(scene_file)


@pytest.fixture
def own_folder(opened, tmp_path):
    """The same, opened in a folder of its own."""
    return dataclasses.replace(opened, folder=tmp_path)


@pytest.fixture(scope="module")
def darkroom(opened):
    return Darkroom(opened)


@pytest.fixture
def marked(opened, darkroom):
    """Show the scene in a size with points marked at some pixels."""

    def mark(size, *places):
        state = opened.initial
        for i, place in enumerate(places):
            point = mark_at(darkroom.quick(state, size), *place)
            state = state.marking(point, second=i == 1)
        return darkroom.quick(state, size)

    return mark
