"""Scene files: everything that they can say, and what is wrong with those that err."""

import json

import numpy as np
import pytest

from meshes import plane, toy_hand
from skinviz import fit_skin, hand_frame, load_archive, read_scene, skin_model
from skinviz.errors import DataError, MeshError, SkinvizError
from skinviz.scan.formats import write_mesh
from skinviz.scene.describe import describe
from skinviz.scene.scene_skin import skin_from_fit_file
from skinviz.skin.report import fit_to_dict
from skinviz.surface import (
    CookTorrance,
    Lambert,
    Phong,
    TorranceSparrow,
    dispersion,
    surface_models,
)

SKIN = """
[skin]
site = "back of hand"
specular = "included"
weights = [0.1, 0.005, 0.004]
"""
MESH = '[mesh]\npath = "hand.ply"\n'
VECTORS = """
[view]
direction = [0, 0, 1]
up = [0, 1, 0]
size = [32, 24]
"""
LIGHT = "[[lights]]\ndirection = [0, 0, 1]\n"


def small_hand():
    return toy_hand(n_around=36, n_along=45)


@pytest.fixture(scope="session")
def fit_text():
    """What ``skinviz fit`` writes of two spectra, the second of them refused."""
    bands = np.arange(400.0, 701, 10)
    model = skin_model(thickness=(0.06, 1.2), specular=0.02, coefficients="textbook")
    spectrum = model.measured([0.05, 0.01, 0.006], bands)
    fit = fit_skin([spectrum, np.full(bands.size, -1.0)], bands, model)
    return json.dumps(fit_to_dict(fit, ["a", "b"]))


@pytest.fixture
def folder(tmp_path, fit_text):
    """A folder with a hand (mm), a plane, and a fit file."""
    write_mesh(tmp_path / "hand.ply", small_hand())
    write_mesh(tmp_path / "plane.ply", plane())
    (tmp_path / "fit.json").write_text(fit_text)
    return tmp_path


def written(folder, text):
    (folder / "scene.toml").write_text(text)
    return read_scene(folder / "scene.toml")


# What a file can say ----------------------------------------------------------


def test_a_short_file_has_sensible_defaults(folder):
    scene = written(folder, MESH + SKIN)
    frame = hand_frame(scene.mesh)
    assert scene.mesh.n_points == small_hand().n_points
    assert scene.skin.model == skin_model(site="back of hand", specular="included")
    np.testing.assert_array_equal(scene.skin.values, [0.1, 0.005, 0.004])
    assert len(scene.lights) == 1
    assert (scene.lights[0].illuminant, scene.lights[0].strength) == ("D65", 1.0)
    np.testing.assert_allclose(scene.lights[0].direction, frame.back, atol=1e-12)
    np.testing.assert_allclose(scene.camera.direction, frame.back, atol=1e-12)
    np.testing.assert_allclose(scene.camera.up, frame.fingers, atol=1e-12)
    assert scene.camera.size == (1024, 1024)
    assert (scene.exposure, scene.observer) == (1.0, "cie1931")


def test_everything_that_can_be_said_is_heard(folder):
    scene = written(
        folder,
        """
        [mesh]
        path = "plane.ply"
        unit = "mm"

        [skin]
        model = "two-layer"
        thickness = [0.05, 1.5]
        specular = 0.03
        coefficients = "textbook"
        weights = [0.2, 0.01, 0.02]

        [surface]
        gamma = 0.3
        n = 1.45
        specular_scale = 0.5
        masking = "none"

        [[lights]]
        illuminant = "A"
        direction = [0, 0, 2]
        strength = 3

        [[lights]]
        illuminant = "FL2"
        direction = [1, 0, 1]
        strength = 0.5

        [view]
        direction = [0, 1, 1]
        up = [1, 0, 0]
        size = [64, 48]
        exposure = 0.25
        observer = "cie1964"
        """,
    )
    assert np.ptp(scene.mesh.points[:, 0]) == pytest.approx(40)
    assert scene.skin.model == skin_model(
        thickness=(0.05, 1.5), specular=0.03, coefficients="textbook"
    )
    surface = scene.surface
    assert (surface.gamma, surface.n, surface.specular_scale) == (0.3, 1.45, 0.5)
    assert surface.masking == "none"
    first, second = scene.lights
    assert (first.illuminant, first.strength) == ("A", 3.0)
    assert (second.illuminant, second.strength) == ("FL2", 0.5)
    np.testing.assert_allclose(second.direction, [np.sqrt(0.5), 0, np.sqrt(0.5)])
    np.testing.assert_allclose(scene.camera.direction, [0, np.sqrt(0.5), np.sqrt(0.5)])
    np.testing.assert_allclose(scene.camera.up, [1, 0, 0], atol=1e-15)
    assert scene.camera.size == (64, 48)
    assert (scene.exposure, scene.observer) == (0.25, "cie1964")


def degrees(a, b):
    return np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


@pytest.mark.parametrize(
    ("text", "light", "view"), [("60/60", 60, 60), ("0/0", 0, 0), ("30/75.5", 30, 75.5)]
)
def test_angles_put_light_and_viewer_on_opposite_sides(folder, text, light, view):
    scene = written(folder, f'{MESH}{SKIN}[view]\nangles = "{text}"\n')
    frame = hand_frame(scene.mesh)
    towards_light, towards_viewer = scene.lights[0].direction, scene.camera.direction
    assert degrees(towards_light, frame.back) == pytest.approx(light, abs=1e-9)
    assert degrees(towards_viewer, frame.back) == pytest.approx(view, abs=1e-9)
    assert degrees(towards_light, towards_viewer) == pytest.approx(light + view)
    # Both lie across the fingers, the light to the viewer's left.
    assert towards_light @ frame.fingers == pytest.approx(0, abs=1e-12)
    assert towards_light @ frame.side <= 1e-12 <= towards_viewer @ frame.side + 2e-12


def test_a_lights_own_angle_comes_before_the_shorthand(folder):
    scene = written(
        folder,
        f'{MESH}{SKIN}[[lights]]\nangle = -40\n[[lights]]\nilluminant = "A"\n'
        '[view]\nangles = "20/10"\n',
    )
    frame = hand_frame(scene.mesh)
    own, shared = (light.direction for light in scene.lights)
    np.testing.assert_allclose(own, frame.direction(np.deg2rad(-40)), atol=1e-12)
    np.testing.assert_allclose(shared, frame.direction(np.deg2rad(20)), atol=1e-12)


@pytest.mark.parametrize(
    ("said", "name", "lines"),
    [
        ('illuminant = "632.8 nm"', "632.8 nm", [[632.8, 1]]),
        (
            "lines = [[435.8, 0.3], [546.1, 1]]",
            "435.8 nm + 546.1 nm",
            [[435.8, 0.3], [546.1, 1]],
        ),
        ('illuminant = "F2"\nlines = [[546.1, 5]]', "FL2 + 546.1 nm", [[546.1, 5]]),
        (
            "temperature = 3000\nlines = [[500, 5]]",
            "black body 3000 K + 500 nm",
            [[500, 5]],
        ),
    ],
)
def test_lights_may_have_lines(folder, said, name, lines):
    lit = MESH.replace("hand", "plane") + SKIN + LIGHT + said + VECTORS
    scene = written(folder, lit)
    assert scene.lights[0].spectrum.name == name
    np.testing.assert_array_equal(scene.lights[0].spectrum.lines, lines)
    told = describe(scene)["lights"][0]
    assert (told["illuminant"], told["lines_nm_power"]) == (name, lines)


def test_a_light_without_lines_tells_none(folder):
    scene = written(folder, MESH.replace("hand", "plane") + SKIN + LIGHT + VECTORS)
    assert "lines_nm_power" not in describe(scene)["lights"][0]


def test_vectors_need_no_hand(folder):
    scene = written(folder, MESH.replace("hand", "plane") + SKIN + LIGHT + VECTORS)
    np.testing.assert_array_equal(scene.camera.direction, [0, 0, 1])


def test_a_viewing_direction_may_be_given_with_lights_by_angle(folder):
    scene = written(folder, f"{MESH}{SKIN}[view]\ndirection = [0, 1, 0]\n")
    np.testing.assert_array_equal(scene.camera.direction, [0, 1, 0])
    frame = hand_frame(scene.mesh)
    np.testing.assert_allclose(scene.lights[0].direction, frame.back, atol=1e-12)


def test_every_surface_model_can_be_named(folder):
    asked = {
        "torrance-sparrow": ("gamma = 0.3", TorranceSparrow(0.3)),
        "cook-torrance": (
            "roughness = 0.2\nmasking = 'smith'",
            CookTorrance(0.2, masking="smith"),
        ),
        "phong": ("exponent = 20\nspecular_scale = 0.5", Phong(20, 1.4, 0.5)),
        "lambert": ("", Lambert()),
    }
    assert tuple(asked) == surface_models()
    for model, (keys, expected) in asked.items():
        text = f"{MESH}{SKIN}[surface]\nmodel = '{model}'\n{keys}\n"
        assert written(folder, text).surface == expected


@pytest.mark.parametrize("tissue", ["epidermis", "dermis"])
def test_the_index_may_be_that_of_a_tissue(folder, tissue):
    scene = written(folder, f"{MESH}{SKIN}[surface]\nn = '{tissue}'\nbeta = 0.5\n")
    assert scene.surface.n == dispersion(tissue)


def test_beta_may_be_given_itself(folder):
    scene = written(folder, f"{MESH}{SKIN}[surface]\nbeta = 0.7\ngamma = 0.2\n")
    assert scene.surface.beta == pytest.approx(0.7, rel=1e-12)
    assert scene.surface.gamma == 0.2


def test_paths_are_relative_to_the_scene_file(folder, monkeypatch):
    monkeypatch.chdir("/")
    assert written(folder, MESH + SKIN).mesh.n_points == small_hand().n_points
    absolute = MESH.replace("hand.ply", str(folder / "hand.ply"))
    assert written(folder, absolute + SKIN).mesh.n_points == small_hand().n_points


def test_a_fit_file_gives_its_model_and_weights(folder):
    scene = written(folder, f'{MESH}[skin]\nfit = "fit.json"\n')
    assert scene.skin.model == skin_model(
        thickness=(0.06, 1.2), specular=0.02, coefficients="textbook"
    )
    np.testing.assert_allclose(scene.skin.values, [0.05, 0.01, 0.006], rtol=1e-6)
    direct = skin_from_fit_file(folder / "fit.json", 0)
    np.testing.assert_array_equal(direct.values, scene.skin.values)


def test_an_archive_subject_is_fitted(folder):
    scene = written(
        folder,
        f'{MESH}[skin]\narchive = "issa"\norigin = "China"\nsubject = "186"\n'
        'site = "back of hand"\n',
    )
    archive = load_archive("issa")
    chosen = (
        (archive.origin == "China")
        & (archive.subject == "186")
        & (archive.site == "back of hand")
    ).values
    spectrum = archive.reflectance.values[chosen].mean(axis=0)
    model = skin_model(site="back of hand", specular=archive.attrs["specular"])
    fit = fit_skin(spectrum, archive.wavelength.values, model)
    assert scene.skin.model == model
    np.testing.assert_array_equal(scene.skin.values, fit.values)


def test_numbers_may_be_written_without_a_point(folder):
    scene = written(
        folder, f"{MESH}{SKIN}[view]\nexposure = 2\n[surface]\ngamma = 1\nn = 1\n"
    )
    assert (scene.exposure, scene.surface.gamma, scene.surface.n) == (2, 1, 1)


# What is wrong with it --------------------------------------------------------

WRONG = {
    "no mesh": (SKIN, r"\[mesh\] needs path"),
    "no path": ("[mesh]\nunit = 'mm'" + SKIN, r"\[mesh\] needs path"),
    "unknown table": (MESH + SKIN + "[sky]\nblue = 1", r"unknown table \[sky\].*view"),
    "unknown key": (
        MESH + SKIN + "[view]\nzoom = 2",
        r"unknown key 'zoom' in \[view\]",
    ),
    "unknown unit": (MESH + 'unit = "yard"' + SKIN, "unknown unit.*mm, cm"),
    "lights once": (MESH + SKIN + "[lights]\nangle = 5", r"\[\[lights\]\]"),
    "mesh twice": ("[[mesh]]\npath = 'hand.ply'" + SKIN, r"write \[mesh\]"),
    "no table": ("skin = 3\n" + MESH, r"write \[skin\]"),
    "light is no table": ("lights = [1]\n" + MESH + SKIN, r"\[\[lights\]\]"),
    "no light": ("lights = []\n" + MESH + SKIN, "at least one light"),
    "illuminant": (MESH + SKIN + LIGHT + "illuminant = 'D66'", "did you mean 'D65'"),
    "strength": (MESH + SKIN + LIGHT + "strength = 0", "light strength"),
    "no lines": (MESH + SKIN + LIGHT + "lines = []", "must be pairs"),
    "three of a line": (MESH + SKIN + LIGHT + "lines = [[1, 2, 3]]", "list of .nm, p"),
    "line is no pair": (MESH + SKIN + LIGHT + "lines = [500, 1]", "list of .nm, power"),
    "lines of text": (MESH + SKIN + LIGHT + "lines = [['a', 1]]", "list of .nm, power"),
    "dark line": (MESH + SKIN + LIGHT + "lines = [[500, 0]]", "which is no light"),
    "zero direction": (
        MESH + SKIN + "[[lights]]\ndirection = [0, 0, 0]",
        "light direction",
    ),
    "two numbers": (MESH + SKIN + "[[lights]]\ndirection = [0, 1]", "light direction"),
    "site": (MESH + SKIN.replace("back of hand", "knee"), "unknown body site 'knee'"),
    "model": (MESH + SKIN + "model = 'jelly'", "unknown skin model 'jelly'"),
    "coefficients": (MESH + SKIN + "coefficients = 'x'", "unknown coefficient set"),
    "no weights": (MESH + SKIN.replace("weights", "# "), "exactly one of weights"),
    "no skin": (MESH, "exactly one of weights"),
    "weights and fit": (MESH + SKIN + "fit = 'fit.json'", "exactly one of weights"),
    "two weights": (MESH + SKIN.replace(", 0.004", ""), r"shape \(3,\)"),
    "negative weight": (MESH + SKIN.replace("[0.1", "[-0.1"), "weights"),
    "no specular": (MESH + SKIN.replace("specular", "# "), "needs specular"),
    "specular word": (MESH + SKIN.replace("included", "shiny"), "specular"),
    "specular number": (MESH + SKIN.replace('"included"', "0.9"), "specular"),
    "site and thickness": (
        MESH + SKIN + "thickness = [0.1, 1]",
        "exactly one of site and thickness",
    ),
    "three thicknesses": (
        MESH + SKIN.replace('site = "back of hand"', "thickness = [0.1, 1, 2]"),
        "thickness",
    ),
    "fit is missing": (MESH + "[skin]\nfit = 'gone.json'", r"gone\.json.*no such file"),
    "fit is junk": (MESH + "[skin]\nfit = 'junk.json'", r"junk\.json.*not a fit file"),
    "fit is binary": (MESH + "[skin]\nfit = 'bin.json'", r"bin\.json.*not a fit file"),
    "fit is a list": (MESH + "[skin]\nfit = 'list.json'", r"list\.json.*not a fit"),
    "fit of another program": (MESH + "[skin]\nfit = 'other.json'", "not a fit file"),
    "no such record": (
        MESH + "[skin]\nfit = 'fit.json'\nrecord = 9",
        "has 2 records.*got 9",
    ),
    "refused record": (MESH + "[skin]\nfit = 'fit.json'\nrecord = 1", "refused"),
    "negative record": (MESH + "[skin]\nfit = 'fit.json'\nrecord = -1", "record"),
    "archive": (MESH + "[skin]\narchive = 'x'", "archive"),
    "no subject": (
        MESH + "[skin]\narchive = 'issa'\norigin = 'China'\nsite = 'cheek'",
        "needs subject",
    ),
    "unknown subject": (
        MESH
        + "[skin]\narchive = 'issa'\norigin = 'China'\nsubject = '0'\nsite = 'cheek'",
        "no spectrum of subject '0'",
    ),
    "gamma": (MESH + SKIN + "[surface]\ngamma = 0", "gamma"),
    "masking": (MESH + SKIN + "[surface]\nmasking = 'full'", "masking"),
    "beta twice": (
        MESH + SKIN + "[surface]\nbeta = 1\nspecular_scale = 1",
        "not both",
    ),
    "beta": (MESH + SKIN + "[surface]\nbeta = -1", "beta|specular_scale"),
    "surface model": (
        MESH + SKIN + "[surface]\nmodel = 'fong'",
        "choose one of: torrance-sparrow, cook-torrance, phong, lambert; did you mean "
        "'phong'",
    ),
    "another model's key": (
        MESH + SKIN + "[surface]\nmodel = 'phong'\ngamma = 0.3",
        r"unknown key 'gamma' in \[surface\]; known are exponent, model, n, "
        "specular_scale$",
    ),
    "a model's masking": (
        MESH + SKIN + "[surface]\nmodel = 'cook-torrance'\nmasking = 'schlick'",
        "choose one of: v-cavity, smith, none",
    ),
    "keys of no lobe": (
        MESH + SKIN + "[surface]\nmodel = 'lambert'\nn = 1.4",
        r"unknown key 'n' in \[surface\]; known are model$",
    ),
    "tissue": (
        MESH + SKIN + "[surface]\nn = 'hypodermis'",
        "choose one of: epidermis, dermis",
    ),
    "one angle": (MESH + SKIN + "[view]\nangles = '60'", "angles must be"),
    "angles in words": (MESH + SKIN + "[view]\nangles = 'a/b'", "angles must be"),
    "angle beyond": (MESH + SKIN + "[view]\nangles = '60/100'", "0 to 90"),
    "NaN angle": (MESH + SKIN + "[view]\nangles = 'nan/0'", "0 to 90"),
    "infinite own angle": (MESH + SKIN + "[[lights]]\nangle = inf", "angle"),
    "one size": (MESH + SKIN + "[view]\nsize = [5]", "size must be"),
    "half pixels": (MESH + SKIN + "[view]\nsize = [5.5, 5]", "size must be"),
    "no pixels": (MESH + SKIN + "[view]\nsize = [0, 5]", "size"),
    "up": (MESH + SKIN + LIGHT + VECTORS.replace("[0, 1, 0]", "[0, 0, 1]"), "parallel"),
    "exposure": (MESH + SKIN + "[view]\nexposure = -1", "exposure"),
    "NaN exposure": (MESH + SKIN + "[view]\nexposure = nan", "exposure"),
    "observer": (MESH + SKIN + "[view]\nobserver = 'me'", "observer"),
}


@pytest.fixture
def bad_fits(folder):
    (folder / "junk.json").write_text("{ not json")
    (folder / "bin.json").write_bytes(b"\xff\xfe\x00{}")
    (folder / "list.json").write_text("[]")
    (folder / "other.json").write_text('{"format": "other 1", "fits": []}')
    return folder


@pytest.mark.parametrize("fault", WRONG)
def test_what_is_wrong_is_said_and_the_file_named(bad_fits, fault):
    text, message = WRONG[fault]
    with pytest.raises(DataError, match=message) as caught:
        written(bad_fits, text)
    assert "scene.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


BROKEN_FITS = {
    "a number of fits": {"fits": 3},
    "a fit that is a number": {"fits": [1]},
    "no parameters": {"fits": [{"label": "a"}]},
    "parameters that are a number": {"fits": [{"parameters": 3}]},
    "parameters of another model": {"fits": [{"parameters": {"a": {"value": 1}}}]},
    "a parameter without value": {"fits": [{"parameters": {"w_m": {}}}]},
}


@pytest.mark.parametrize("fault", BROKEN_FITS)
@pytest.mark.parametrize("record", [0, "a"])
def test_a_fit_file_of_the_wrong_shape_is_refused(folder, fault, record):
    file = folder / "fit.json"
    content = json.loads(file.read_text("utf-8"))
    file.write_text(json.dumps(content | BROKEN_FITS[fault]), "utf-8")
    with pytest.raises(DataError, match=r"fit\.json"):
        skin_from_fit_file(file, record)


KINDS = {
    "text": ["3", "true", "[1]", "2001-01-01"],
    "number": ["'a'", "true", "[1]"],
    "list": ["3", "'a'", "['a', 'b', 'c']", "[[1]]", "[true, 1, 1]"],
    "text or number": ["true", "[1]"],
}
KEYS = {
    "text": [
        ("mesh", "path"),
        ("mesh", "unit"),
        ("skin", "model"),
        ("skin", "site"),
        ("skin", "fit"),
        ("skin", "archive"),
        ("skin", "subject"),
        ("surface", "masking"),
        ("lights", "illuminant"),
        ("view", "angles"),
        ("view", "observer"),
    ],
    "number": [
        ("surface", "gamma"),
        ("surface", "beta"),
        ("lights", "angle"),
        ("lights", "strength"),
        ("view", "exposure"),
        ("skin", "record"),
    ],
    "list": [
        ("skin", "weights"),
        ("skin", "thickness"),
        ("lights", "direction"),
        ("view", "up"),
        ("view", "size"),
    ],
    "text or number": [("surface", "n")],
}


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [(*place, v) for kind in KEYS for place in KEYS[kind] for v in KINDS[kind]],
)
def test_a_value_of_the_wrong_kind_is_refused_by_table_and_key(
    folder, table, key, value
):
    head = "[[lights]]" if table == "lights" else f"[{table}]"
    rest = "" if table == "mesh" else MESH
    with pytest.raises(DataError, match=rf"scene\.toml.*{key} in \[{table}\] must be"):
        written(folder, f"{rest}{head}\n{key} = {value}\n")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[mesh\npath", "not a TOML file"),
        (b"\xff\xfe\x00", "not a TOML file"),
        (b"", "empty"),
        (b"just words", "not a TOML file"),
    ],
)
def test_what_is_no_toml_is_refused(tmp_path, content, message):
    (tmp_path / "scene.toml").write_bytes(content)
    with pytest.raises(DataError, match=rf"scene\.toml.*{message}"):
        read_scene(tmp_path / "scene.toml")


def test_a_missing_scene_is_named(tmp_path):
    with pytest.raises(DataError, match=r"gone\.toml: no such file"):
        read_scene(tmp_path / "gone.toml")


def test_a_mesh_that_cannot_be_read_is_named(folder):
    with pytest.raises(MeshError, match=r"gone\.ply: no such file"):
        written(folder, MESH.replace("hand", "gone") + SKIN)


def test_a_mesh_without_a_wrist_is_named(folder):
    # The plane has an opening but no thumb; which file it is about must be said.
    with pytest.raises(SkinvizError, match=r"scene\.toml|plane\.ply"):
        written(folder, MESH.replace("hand", "plane") + SKIN)
