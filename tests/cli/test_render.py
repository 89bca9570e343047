"""``skinviz render`` and ``info``: a scene file to pictures, spectra and a mesh."""

import dataclasses
import json

import numpy as np
import pytest
import pyvista as pv
import spectral
import tifffile
from PIL import Image

from meshes import sphere
from skinviz.cli.main import main
from skinviz.rendering.plan import Plan
from skinviz.scan.formats import write_mesh
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh

SKIN = """
[skin]
weights = [0.1, 0.008, 0.004]
site = "back of hand"
specular = "included"
"""
BALL = """
[mesh]
path = "ball.ply"
unit = "mm"
[[lights]]
illuminant = "D65"
direction = [0, 0, 1]
[view]
direction = [0, 0, 1]
up = [0, 1, 0]
size = [24, 16]
"""


@pytest.fixture
def ball(tmp_path):
    """A scene of a sphere, and what its file says."""
    write_mesh(tmp_path / "ball.ply", sphere(40, 3))
    scene = tmp_path / "scene.toml"
    scene.write_text(BALL + SKIN, encoding="utf-8")
    return scene


@pytest.fixture
def run(capsys):
    """Run the program: exit code, standard output, last line of standard error."""

    def call(*words):
        code = main([str(word) for word in words])
        told = capsys.readouterr()
        return code, told.out, (told.err.strip().splitlines() or [""])[-1]

    return call


def changed(scene, old, new):
    text = scene.read_text("utf-8")
    assert old in text
    scene.write_text(text.replace(old, new), encoding="utf-8")


def test_a_scene_becomes_a_picture_its_spectra_and_its_mesh(ball, run, tmp_path):
    out, cube, mesh = (tmp_path / f"ball.{kind}" for kind in ("png", "hdr", "vtp"))
    words = ["render", ball, "-o", out, "--spectral", cube, "--mesh", mesh]
    code, said, _ = run(*words)
    assert code == 0
    assert all(str(file) in said for file in (out, cube, mesh))
    with Image.open(out) as picture:
        assert picture.size == (24, 16)
        rgb = np.asarray(picture)
    assert (rgb[0, 0] == 46).all()
    assert rgb[8, 12, 0] > rgb[8, 12, 2] > 46
    radiance = spectral.open_image(str(cube))
    assert radiance.shape == (16, 24, 61)
    assert radiance.bands.centers == list(np.arange(400, 701, 5.0))
    values = np.asarray(radiance.load())
    assert (values[0, 0] == 0).all()
    assert values[8, 12, 50] > values[8, 12, 0] > 0
    assert pv.read(mesh).point_data["radiance"].shape == (642, 61)


def test_sixteen_bits_and_eight_show_the_same(ball, run, tmp_path):
    eight, sixteen = tmp_path / "a.png", tmp_path / "a.tif"
    for out in (eight, sixteen):
        assert run("render", ball, "-o", out, "--samples", 4)[0] == 0
    with Image.open(eight) as picture:
        coarse = np.asarray(picture).astype(float)
    fine = tifffile.imread(sixteen)
    assert fine.dtype == np.uint16
    np.testing.assert_allclose(fine / 257, coarse, atol=0.51)


def test_size_is_that_of_the_longer_side(ball, run, tmp_path):
    out = tmp_path / "a.png"
    assert run("render", ball, "-o", out, "--size", 48, "--samples", 1)[0] == 0
    with Image.open(out) as picture:
        assert picture.size == (48, 32)


def test_json_counts_the_pixels(ball, run, tmp_path):
    changed(ball, "size = [24, 16]", "size = [24, 16]\nexposure = 20.0")
    out = tmp_path / "a.png"
    code, said, _ = run("render", ball, "-o", out, "--json")
    told = json.loads(said)
    assert code == 0
    assert told["files"] == [str(out)]
    assert 0 < told["pixels"]["over_exposed"] <= told["pixels"]["mesh"] < 24 * 16
    assert "over-exposed on sRGB" in told["notes"][0]


def test_a_picture_says_how_it_was_made(ball, run, tmp_path):
    out = tmp_path / "a.png"
    assert run("render", ball, "-o", out, "--samples", 2)[0] == 0
    told = json.loads(run("info", out, "--json")[1])
    assert told["plan"]["samples"] == 2
    assert told["scene"]["lights"][0]["illuminant"] == "D65"
    assert told["scene"]["skin"]["parameters"]["w_m"] == 0.1
    assert told["software"].startswith("skinviz ")
    said = run("info", out)[1]
    assert "two-layer" in said
    assert "camera" in said


def test_a_tolerance_is_planned_for_and_told(ball, run, tmp_path):
    out = tmp_path / "a.png"
    words = ["render", ball, "-o", out, "--size", 200]
    code, said, _ = run(*words, "--tolerance", 5, "--explain")
    assert code == 0
    assert "tolerance ΔE00 5\n" in said
    for knob in ("sampling", "shadows", "specular", "shading"):
        assert f"\n{knob} " in said
    plan = json.loads(run("info", out, "--json")[1])["plan"]
    assert plan["tolerance"] == 5
    told = json.loads(run(*words, "--tolerance", 5, "--json")[1])["plan"]
    assert told == plan
    assert [finding["knob"] for finding in told["findings"]][:2] == [
        "spectrum",
        "basis",
    ]


def test_without_a_tolerance_it_is_one(ball, run, tmp_path):
    told = json.loads(run("render", ball, "-o", tmp_path / "a.png", "--json")[1])
    assert told["plan"]["tolerance"] == 1


def test_samples_are_for_all_pixels_and_leave_nothing_else_out(ball, run, tmp_path):
    words = ["render", ball, "-o", tmp_path / "a.png", "--samples", 4]
    told = json.loads(run(*words, "--json")[1])["plan"]
    assert told == json.loads(json.dumps(dataclasses.asdict(Plan(samples=4))))
    assert "not planned" in run(*words, "--explain")[1]


def test_a_black_picture_says_why(ball, run, tmp_path):
    changed(ball, "direction = [0, 0, 1]\n[view]", "direction = [0, 0, -1]\n[view]")
    code, said, _ = run("render", ball, "-o", tmp_path / "a.png")
    assert code == 0
    assert "note: light 1 is behind everything" in said


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"D65"', '"D66"', "D65"),
        ("direction = [0, 0, 1]\n[view]", "position = [0, 0, 0]\n[view]", "centroid"),
        ("size = [24, 16]", "size = [0, 16]", "camera size"),
        ("size = [24, 16]", "size = [16000, 16000]", "GiB"),
        ("size = [24, 16]", "size = [9, 9]\ndistance = 10", "in front of the whole"),
        (
            "size = [24, 16]",
            "size = [9, 9]\ndistance = 10\nheight = 5",
            "the camera is inside the mesh",
        ),
    ],
    ids=["light", "centroid", "no size", "huge", "near", "inside"],
)
def test_bad_scenes_are_refused_before_a_file_is_made(
    ball, run, tmp_path, old, new, told
):
    changed(ball, old, new)
    code, _, error = run("render", ball, "-o", tmp_path / "a.png")
    assert code == 1
    assert error.startswith("skinviz: ")
    assert told in error
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["-o", "a.jpg"], ".png, .tif, .tiff"),
        (["-o", "a.png", "--spectral", "a.png"], ".hdr, .exr"),
        (["-o", "a.png", "--mesh", "a.ply"], ".vtp"),
        (["-o", "a.png", "--size", "0"], "--size"),
        (["-o", "a.png", "--samples", "3"], "1, 2, 4, 8, 16"),
        (["-o", "a.png", "--samples", "4", "--tolerance", "1"], "give --tolerance to"),
        (["-o", "a.png", "--tolerance", "0"], "--tolerance"),
        (["-o", "a.png", "--tolerance", "nan"], "--tolerance"),
    ],
)
def test_bad_options_are_refused(ball, run, words, told):
    code, _, error = run("render", ball, *words)
    assert code == 1
    assert told in error


def test_info_says_what_a_scene_computes_and_leaves_out(tmp_path, run):
    scene = tmp_path / "scene.toml"
    mesh = json.dumps(str(shipped_mesh(TRUE_SHAPE)))
    head = f'[mesh]\npath = {mesh}\nunit = "m"\n[view]\nangles = "30/0"\n'
    scene.write_text(head + SKIN, encoding="utf-8")
    facts = json.loads(run("info", scene, "--json")[1])
    assert "61 wavelengths" in facts["computed"][0]
    assert "cast shadows" in facts["computed"][0]
    assert "light between fingers" in facts["left out"]
    text = head + SKIN + '[transport]\ninterreflection = "diffuse"\n'
    scene.write_text(text, encoding="utf-8")
    said = run("info", scene)[1]
    assert "one diffuse bounce" in said
    assert "bounces more than once" in said


def test_info_says_what_a_tolerance_leaves_out(ball, run):
    code, said, _ = run("info", ball, "--tolerance", 2)
    assert code == 0
    assert "mesh " in said
    assert "\n\ntolerance ΔE00 2\nknob " in said
    told = json.loads(run("info", ball, "--tolerance", 2, "--json")[1])
    assert told["plan"]["tolerance"] == 2
    assert "mesh" in told
    assert "plan" not in json.loads(run("info", ball, "--json")[1])


@pytest.mark.parametrize("tolerance", ["0", "-1", "101", "nan"])
def test_info_refuses_what_is_no_tolerance(ball, run, tolerance):
    code, _, error = run("info", ball, "--tolerance", tolerance)
    assert code == 1
    assert "tolerance" in error


def test_info_has_tolerances_for_scenes_alone(ball, run):
    mesh = ball.parent / "ball.ply"
    code, _, error = run("info", mesh, "--unit", "mm", "--tolerance", 1)
    assert code == 1
    assert "are for scenes (.toml); leave them out" in error


def test_info_says_what_a_mesh_is(ball, run):
    assert "boundaries" in run("info", ball.parent / "ball.ply", "--unit", "mm")[1]


# What if -----------------------------------------------------------------------


def test_what_if_on_the_command_line_is_what_the_file_may_say(ball, run, tmp_path):
    words = ("--melanin", "x2", "--oxyhaemoglobin", "+0.004", "--saturation", "0.25")
    assert run("render", ball, "-o", tmp_path / "a.png", *words)[0] == 0
    said = (
        "[skin.change]\nmelanin = 'x2'\noxyhaemoglobin = '+0.004'\nsaturation = 0.25\n"
    )
    ball.write_text(ball.read_text() + said)
    assert run("render", ball, "-o", tmp_path / "b.png")[0] == 0
    one, other = (np.asarray(Image.open(tmp_path / f"{n}.png")) for n in "ab")
    np.testing.assert_array_equal(one, other)


def test_info_tells_what_is_changed(ball, run):
    code, told, _ = run("info", ball, "--melanin", "-0.05", "--haemoglobin", "x2")
    assert code == 0
    assert "w_m 0.05, w_h 0.016, w_dh 0.008" in told
    assert "changed: melanin -0.05, haemoglobin x2" in told


def test_info_tells_of_texture_and_relief(ball, run):
    ball.write_text(
        ball.read_text()
        + "[skin.texture]\nmelanin_mottling = 0.1\nmottling_mm = 20\nrelief_um = 30\n"
    )
    code, told, _ = run("info", ball)
    assert code == 0
    assert "texture: melanin_mottling 0.1, mottling_mm 20, relief_um 30" in told
    assert "furrows 30 µm deep, 1 mm apart" in told


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--melanin", "2x"), "melanin must be x2"),
        (("--melanin", "-1"), "melanin -1 makes w_m -0.9"),
        (("--saturation", "x9"), "within 0 and 1"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(ball, run, tmp_path, words, message):
    code, _, error = run("render", ball, "-o", tmp_path / "a.png", *words)
    assert code == 1
    assert message in error
    assert not (tmp_path / "a.png").exists()


def test_what_if_is_for_scenes(ball, run):
    code, _, error = run("info", ball.parent / "ball.ply", "--melanin", "x2")
    assert code == 1
    assert "are for scenes" in error
