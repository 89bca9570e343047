"""Descriptions of scenes are frozen, checked when made, and changed by replacing."""

import dataclasses

import numpy as np
import pytest
import pyvista as pv
from tolerances import ROUNDING

from meshes import cube, plane, sphere
from skinviz import Camera, DirectionalLight, Scene, Skin, fit_skin
from skinviz.errors import ArgumentError, FitError, MeshError
from skinviz.scan.topology import polydata
from skinviz.spectra.illuminants import illuminants
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS

UP = [0.0, 1.0, 0.0]
Z = [0.0, 0.0, 1.0]


# Skin -------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(3,), (81, 3), (1, 3)])
def test_skin_keeps_its_values_as_float64(model, shape):
    skin = Skin(model, np.full(shape, 0.01, dtype=np.float32))
    assert skin.values.shape == shape
    assert skin.values.dtype == np.float64


@pytest.mark.parametrize("shape", [(), (2,), (4,), (3, 2), (2, 2, 3), (0,)])
def test_skin_values_of_another_shape_are_refused(model, shape):
    with pytest.raises(ArgumentError, match=r"skin values must have shape \(3,\) or"):
        Skin(model, np.zeros(shape))


def test_skin_values_that_are_no_numbers_are_refused(model):
    with pytest.raises(ArgumentError):
        Skin(model, ["a", "b", "c"])


def test_a_fit_becomes_the_skin_that_it_describes(model):
    bands = np.arange(400.0, 701, 10)
    true = np.array([0.12, 6e-3, 3e-3])
    skin = Skin.from_fit(fit_skin(model.measured(true, bands), bands, model))
    assert skin.model == model
    np.testing.assert_allclose(skin.values, true, rtol=1e-6)


def test_a_fit_that_was_refused_is_no_skin(model):
    bands = np.arange(400.0, 701, 10)
    with pytest.raises(FitError, match="refused"):
        Skin.from_fit(fit_skin(np.full(bands.size, -1.0), bands, model))


def test_a_batch_of_fits_is_no_skin(model):
    bands = np.arange(400.0, 701, 10)
    spectra = model.measured(np.full((4, 3), 0.01), bands)
    with pytest.raises(ArgumentError, match="fit of one spectrum"):
        Skin.from_fit(fit_skin(spectra, bands, model))


# Lights -----------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1.0, 1e-150, 1e150])
def test_a_lights_direction_has_length_one(scale):
    light = DirectionalLight(np.array([3.0, 0, -4]) * scale)
    np.testing.assert_allclose(light.direction, [0.6, 0, -0.8], rtol=ROUNDING)


def test_every_shipped_illuminant_makes_a_light():
    for name in illuminants():
        assert DirectionalLight(Z, name).illuminant == name


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"direction": [0, 0, 0]}, "zero vector"),
        ({"direction": [0, 0]}, "three finite numbers"),
        ({"direction": [0, 0, np.nan]}, "three finite numbers"),
        ({"direction": [0, 0, np.inf]}, "three finite numbers"),
        ({"direction": [[0, 0, 1]]}, "three finite numbers"),
        ({"direction": "up"}, "light direction"),
        ({"direction": Z, "illuminant": "D66"}, "did you mean 'D65'"),
        ({"direction": Z, "illuminant": None}, "unknown illuminant"),
        ({"direction": Z, "strength": 0}, "light strength"),
        ({"direction": Z, "strength": -1}, "light strength"),
        ({"direction": Z, "strength": np.nan}, "light strength"),
        ({"direction": Z, "strength": np.inf}, "light strength"),
        ({"direction": Z, "strength": "bright"}, "light strength"),
    ],
)
def test_an_impossible_light_is_refused(arguments, message):
    with pytest.raises(ArgumentError, match=message):
        DirectionalLight(**arguments)


# Cameras ----------------------------------------------------------------------


def test_a_cameras_axes_are_unit_and_across_each_other():
    camera = Camera([0, 3, 4], [0, 1, 0])
    np.testing.assert_allclose(camera.direction, [0, 0.6, 0.8], rtol=ROUNDING)
    np.testing.assert_allclose(camera.up, [0, 0.8, -0.6], rtol=1e-12)


@pytest.mark.parametrize(
    ("direction", "up"),
    [
        (Z, Z),
        (Z, [0, 0, -5]),
        (Z, [1e-9, 0, 1]),
        (Z, [0, 0, 0]),
        ([0, 0, 0], UP),
        (Z, [0, np.nan, 0]),
        ("front", UP),
    ],
)
def test_impossible_camera_directions_are_refused(direction, up):
    with pytest.raises(ArgumentError, match="camera"):
        Camera(direction, up)


@pytest.mark.parametrize(
    "size",
    [
        (0, 10),
        (10, -1),
        (10, 16385),
        (np.nan, 10),
        (10.5, 20),
        (10,),
        (10, 10, 10),
        100,
        None,
        "ab",
        (True, 5),
    ],
)
def test_impossible_picture_sizes_are_refused(size):
    with pytest.raises(ArgumentError, match="size"):
        Camera(Z, UP, size)


@pytest.mark.parametrize("size", [(1, 1), (640, 480), (np.int64(5), np.int32(7))])
def test_possible_picture_sizes_are_kept(size):
    assert Camera(Z, UP, size).size == size


# Scenes -----------------------------------------------------------------------


def test_everything_is_frozen(scene):
    for thing in (scene, scene.skin, scene.camera, scene.lights[0], scene.surface):
        name = dataclasses.fields(thing)[0].name
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(thing, name, None)


def test_replacing_changes_one_thing_and_leaves_the_scene(scene):
    other = scene.replace(exposure=2.0)
    assert (scene.exposure, other.exposure) == (1.0, 2.0)
    for field in dataclasses.fields(scene):
        if field.name != "exposure":
            assert getattr(other, field.name) is getattr(scene, field.name)


def test_replacing_checks_again(scene):
    with pytest.raises(ArgumentError, match="at least one light"):
        scene.replace(lights=())
    with pytest.raises(TypeError):
        scene.replace(colour="red")


def test_lights_may_come_in_a_list(scene):
    lights = [DirectionalLight(Z), DirectionalLight(UP, "A")]
    assert scene.replace(lights=lights).lights == tuple(lights)


def test_wavelengths_are_the_papers_unless_given(scene):
    np.testing.assert_array_equal(scene.wavelengths, PAPER_WAVELENGTHS)
    assert scene.replace(wavelengths=[550]).wavelengths.tolist() == [550.0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"diffuse_scale": -1}, "diffuse_scale"),
        ({"diffuse_scale": np.nan}, "diffuse_scale"),
        ({"exposure": 0}, "exposure"),
        ({"exposure": np.inf}, "exposure"),
        ({"exposure": "bright"}, "exposure"),
        ({"observer": "cie1932"}, "did you mean 'cie1931'"),
        ({"wavelengths": [500, 400]}, "ascending"),
        ({"wavelengths": []}, "1-D array"),
        ({"wavelengths": [np.nan]}, "finite"),
    ],
)
def test_impossible_settings_are_refused_by_name(scene, changes, message):
    with pytest.raises(ArgumentError, match=message):
        scene.replace(**changes)


@pytest.mark.parametrize(
    "mesh",
    [
        pv.PolyData(),
        pv.PolyData(np.zeros((4, 3))),
        polydata(np.array([[0.0, 0, 0], [1, 0, 0], [0, np.nan, 0]]), [[0, 1, 2]]),
    ],
    ids=["empty", "points", "NaN"],
)
def test_what_is_no_triangle_mesh_makes_no_scene(scene, mesh):
    with pytest.raises(MeshError, match="the scene's mesh"):
        scene.replace(mesh=mesh)


def test_pigments_must_be_as_many_as_the_points(scene, model):
    n = scene.mesh.n_points
    assert scene.replace(skin=Skin(model, np.full((n, 3), 0.01))).mesh.n_points == n
    with pytest.raises(MeshError, match=f"pigments at {n + 1} vertices.*has {n}"):
        scene.replace(skin=Skin(model, np.full((n + 1, 3), 0.01)))
    with pytest.raises(MeshError, match="pigments at 1 vertices"):
        scene.replace(skin=Skin(model, [[0.1, 0.01, 0.01]]))


def test_a_mesh_of_squares_becomes_one_of_triangles_or_is_refused(scene):
    try:
        mesh = scene.replace(mesh=cube()).mesh
    except MeshError:
        return
    assert mesh.is_all_triangles
    assert mesh.n_cells == 12


def test_a_scene_does_not_copy_the_mesh(scene):
    mesh = sphere()
    assert scene.replace(mesh=mesh).mesh is mesh
    assert isinstance(scene, Scene)
    assert plane().n_points == scene.mesh.n_points
