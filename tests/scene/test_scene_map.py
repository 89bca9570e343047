"""Skin that differs by place, as scene files say it."""

import json

import numpy as np
import pytest
from hands import coarse_hand

from meshes import plane
from skinviz import (
    SkinTexture,
    fit_skin,
    landmarks,
    pigment_map,
    read_scene,
    skin_model,
    textured,
    write_mesh,
)
from skinviz.errors import DataError, SkinvizError
from skinviz.scene.describe import describe
from skinviz.skin.report import fit_to_dict

HEAD = """
[mesh]
path = "plane.ply"
[[lights]]
direction = [0, 0, 1]
[view]
direction = [0, 0, 1]
up = [0, 1, 0]
size = [32, 24]
[skin]
"""
PERSON = 'archive = "issa"\norigin = "China"\nsubject = "186"\nsite = "back of hand"\n'
GIVEN = 'site = "back of hand"\nspecular = "included"\n'
WEIGHTS = GIVEN + "weights = [0.1, 0.005, 0.004]\n"
BASE = [0.1, 0.005, 0.004]


def fit_text(site="back of hand"):
    """What ``skinviz fit`` writes of two spectra."""
    bands = np.arange(400.0, 701, 10)
    model = skin_model(site=site, specular="included")
    weights = [[0.05, 0.01, 0.006], [0.2, 0.004, 0.002]]
    fit = fit_skin(model.measured(weights, bands), bands, model)
    return json.dumps(fit_to_dict(fit, ["palm", "nail"])), fit.values


@pytest.fixture
def folder(tmp_path):
    write_mesh(tmp_path / "hand.ply", coarse_hand())
    write_mesh(tmp_path / "plane.ply", plane())
    return tmp_path


def written(folder, text, head=HEAD):
    (folder / "scene.toml").write_text(head + text)
    return read_scene(folder / "scene.toml")


def test_points_of_a_hand_have_what_is_said_of_them(folder):
    text = """
    [skin.map]
    back = {}
    palm_side = [0.03, 0.008, 0.004]
    knuckle = { oxyhaemoglobin = "x2" }
    """
    scene = written(folder, WEIGHTS + text, HEAD.replace("plane", "hand"))
    at, values = landmarks(scene.mesh), scene.skin.values
    np.testing.assert_allclose(values[at["back"]], BASE, rtol=1e-12)
    np.testing.assert_allclose(values[at["thenar"]], [0.03, 0.008, 0.004], rtol=1e-12)
    np.testing.assert_allclose(values[at["ring_knuckle"]], [0.1, 0.01, 0.004])
    assert "palm_side" in scene.skin.history[0]


def test_points_may_be_vertices_and_coordinates(folder):
    text = """
    [[skin.point]]
    vertex = 3
    [[skin.point]]
    at = [20, 20, 0]
    skin = { melanin = "+0.1" }
    """
    scene = written(folder, WEIGHTS + text)
    expected = pigment_map(scene.mesh, {3: BASE, 80: [0.2, 0.005, 0.004]})
    np.testing.assert_allclose(scene.skin.values, expected, rtol=1e-12)


def test_points_may_be_fits_by_number_or_label(folder):
    text, values = fit_text()
    (folder / "fit.json").write_text(text)
    scene = written(
        folder,
        """
        fit = "fit.json"
        [[skin.point]]
        vertex = 0
        skin = "fit.json#nail"
        [[skin.point]]
        vertex = 8
        skin = "fit.json#0"
        [[skin.point]]
        vertex = 80
        skin = "fit.json"
        """,
    )
    np.testing.assert_allclose(scene.skin.values[0], values[1], rtol=1e-12)
    np.testing.assert_allclose(scene.skin.values[[8, 80]], values[[0, 0]], rtol=1e-12)


def test_points_may_be_sites_of_the_archives_person(folder):
    text = '[[skin.point]]\nvertex = 0\nskin = "palm"\n[[skin.point]]\nvertex = 80\n'
    scene = written(folder, PERSON + text)
    back = written(folder, PERSON)
    palm = PERSON.replace("back of hand", "palm") + "thickness = [0.035, 1.19]\n"
    np.testing.assert_allclose(scene.skin.values[80], back.skin.values, rtol=1e-12)
    np.testing.assert_allclose(
        scene.skin.values[0], written(folder, palm).skin.values, rtol=1e-9
    )
    assert scene.skin.values[0, 0] < back.skin.values[0]  # a palm is lighter


def test_texture_and_changes_come_on_top_in_this_order(folder):
    text = """
    [skin.texture]
    melanin_mottling = 0.2
    mottling_mm = 10
    relief_um = 40
    seed = 5
    [skin.change]
    melanin = "x2"
    saturation = 0.4
    """
    scene, plain = written(folder, WEIGHTS + text), written(folder, WEIGHTS)
    texture = SkinTexture(melanin_mottling=0.2, mottling_mm=10, relief_um=40, seed=5)
    expected = textured(plain, texture)
    changed = expected.skin.changed(melanin="x2", saturation=0.4)
    np.testing.assert_array_equal(scene.skin.values, changed.values)
    assert scene.relief == expected.relief
    assert scene.skin.history == changed.history


def test_a_description_tells_how_skin_was_made(folder):
    text = "[skin.texture]\nrelief_um = 40\n[skin.change]\nmelanin = 'x2'\n"
    told = json.loads(json.dumps(describe(written(folder, WEIGHTS + text))))
    assert told["skin"]["history"] == ["changed: melanin x2"]
    assert told["relief"] == {"depth": 40.0, "spacing": 1.0, "seed": 0}
    assert "history" not in describe(written(folder, WEIGHTS))["skin"]


def test_skin_may_be_painted_on_vertices(folder):
    values = np.random.default_rng(1).uniform(0.01, 0.1, (81, 3))
    mesh = plane()
    mesh.point_data["pigments"] = values
    write_mesh(folder / "painted.vtp", mesh)
    scene = written(folder, GIVEN + 'painted = "painted.vtp"\n')
    np.testing.assert_array_equal(scene.skin.values, values)
    assert scene.skin.history == ("painted in painted.vtp",)


def test_skin_may_be_painted_in_an_image(folder):
    import tifffile

    mesh = plane()
    mesh.point_data["Texture Coordinates"] = np.asarray(mesh.points)[:, :2] / 40 + 0.5
    write_mesh(folder / "plane.vtp", mesh)
    image = np.full((2, 2, 3), [0.5, 0.25, 0.1], np.float32)
    tifffile.imwrite(folder / "paint.tif", image, photometric="rgb")
    text = GIVEN + 'image = "paint.tif"\nweights_at_one = [0.2, 0.04, 0.05]\n'
    scene = written(folder, text, HEAD.replace("plane.ply", "plane.vtp"))
    np.testing.assert_allclose(
        scene.skin.values, np.broadcast_to([0.1, 0.01, 0.005], (81, 3)), rtol=1e-6
    )


WRONG = {
    "place": ("[skin.map]\nbakc = {}\n", "did you mean 'back'"),
    "no hand": (
        "[skin.map]\nback = {}\n",
        "no hand; give points as vertices or coordinates",
    ),
    "kind": ("[skin.map]\nback = 3\n", "the point 'back'.*weights as"),
    "change": ("[skin.map]\nback = { melanin = 'y2' }\n", "melanin must be x2"),
    "count": ("[[skin.point]]\nvertex = 1\nskin = [0.1]\n", "must have shape"),
    "negative": ("[[skin.point]]\nvertex = 1\nskin = [-1, 0, 0]\n", "out of bounds"),
    "words": ("[[skin.point]]\nvertex = 1\nskin = ['a', 'b', 'c']\n", "numbers"),
    "two places": ("[[skin.point]]\nvertex = 1\nat = [0, 0, 0]\n", "takes at ="),
    "no place": ("[[skin.point]]\nskin = [0.1, 0, 0]\n", "takes at ="),
    "misspelt": ("[[skin.point]]\nvertx = 1\n", "takes at ="),
    "half a vertex": ("[[skin.point]]\nvertex = 1.5\n", "whole number"),
    "no vertex": ("[[skin.point]]\nvertex = 81\n", "none of the mesh's 81"),
    "place as text": ("[[skin.point]]\nat = 'here'\n", "at must be"),
    "far away": ("[[skin.point]]\nat = [0, 0, 90]\n", "90 mm from the mesh"),
    "twice": ("[[skin.point]]\nvertex = 1\n[[skin.point]]\nvertex = 1\n", "twice"),
    "same vertex": (
        "[[skin.point]]\nvertex = 40\n[[skin.point]]\nat = [0, 0, 0]\n",
        "same vertex",
    ),
    "no archive": ("[[skin.point]]\nvertex = 1\nskin = 'palm'\n", "names 'palm'"),
    "no fit": ("[[skin.point]]\nvertex = 1\nskin = 'no.json'\n", "no such file"),
    "record": ("[[skin.point]]\nvertex = 1\nskin = 'fit.json#2'\n", "has 2 records"),
    "label": ("[[skin.point]]\nvertex = 1\nskin = 'fit.json#arm'\n", "are palm, nail"),
    "thickness": ("[[skin.point]]\nvertex = 1\nskin = 'cheek.json'\n", "thickness_mm"),
    "texture": ("[skin.texture]\nvein = 1\n", "did you mean 'veins'"),
    "amount": ("[skin.texture]\nveins = 'some'\n", "veins must be a number"),
    "texture table": ("texture = 3\n", r"texture in \[skin\] must be a table"),
    "quantity": ("[skin.change]\nmelamin = 2\n", "did you mean 'melanin'"),
    "too little": ("[skin.change]\nmelanin = '-1'\n", "makes w_m -0.9"),
}


@pytest.mark.parametrize("fault", WRONG)
def test_what_is_wrong_is_said_in_a_line(folder, fault):
    text, message = WRONG[fault]
    (folder / "fit.json").write_text(fit_text()[0])
    (folder / "cheek.json").write_text(fit_text("cheek")[0])
    with pytest.raises(SkinvizError, match=message) as caught:
        written(folder, WEIGHTS + text)
    assert "\n" not in str(caught.value)


def test_a_painted_skin_takes_no_points(folder):
    mesh = plane()
    mesh.point_data["pigments"] = np.full((81, 3), 0.01)
    write_mesh(folder / "painted.vtp", mesh)
    text = GIVEN + 'painted = "painted.vtp"\n[[skin.point]]\nvertex = 1\n'
    with pytest.raises(DataError, match="maps already"):
        written(folder, text)


def test_an_image_needs_its_scale(folder):
    with pytest.raises(DataError, match=r"weights_at_one = \[w_m, w_h, w_dh\]"):
        written(folder, GIVEN + 'image = "a.tif"\n')
