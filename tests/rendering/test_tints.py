"""Tints of mapped skin: all ways come to the model as they grow finer."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from meshes import faces_of, joined, moved, plane, pose, sphere, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    render,
)
from skinviz.rendering import tints, trace
from skinviz.rendering.painter import Painter
from skinviz.rendering.stage import stage_of
from skinviz.rendering.tints import (
    TABLE_SHARE,
    ModelTints,
    TableTints,
    VertexTints,
    mixing_of,
    pigments_at,
    table_of,
    tints_of,
    vertex_pigments,
)
from skinviz.rendering.tolerance import colour_differences
from skinviz.skin.table import SAFETY
from skinviz.surface.dispersion import dispersion

FLOAT32 = 2.0**-23
UP = [0.0, 1.0, 0.0]
D65 = np.array([0.95, 1.0, 1.09])


def smooth_pigments(mesh):
    """Pigments that vary smoothly over a mesh of about 40 mm."""
    x, y, z = np.asarray(mesh.points).T / 40
    return np.stack(
        [
            0.12 + 0.08 * np.sin(5 * x + 1) * np.cos(4 * y),
            0.006 + 0.004 * np.cos(6 * y + 2 * z),
            0.004 + 0.003 * np.sin(4 * x - 3 * y),
        ],
        axis=1,
    )


def mapped(scene, mesh, **changes):
    skin = Skin(scene.skin.model, smooth_pigments(mesh))
    return scene.replace(mesh=mesh, skin=skin, **changes)


@pytest.fixture
def scene(matt):
    """A glossy wave of mapped skin with a ball's shadow on it, under two lamps."""
    mesh = joined(wave(21), sphere(8, 2, centre=(2, -3, 12)))
    return mapped(
        matt,
        mesh,
        surface=TorranceSparrow(),
        lights=(
            DirectionalLight([-0.4, 0.2, 1], "A"),
            PointLight([30, 20, 60], "FL2", 0.3),
        ),
        camera=Camera([0.2, -0.3, 1], UP, (33, 27), distance=250.0),
    )


@pytest.fixture
def bouncing(scene):
    """The same with light between the wave and the ball."""
    return scene.replace(interreflection="diffuse")


def worst(one, other):
    """Largest ΔE00 between two pictures."""
    flat = (picture.xyz.reshape(-1, 3).astype(float) for picture in (one, other))
    return colour_differences(*flat, D65).max()


# Which is which -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("reflectance", "kind"),
    [("model", ModelTints), ("table", TableTints), ("vertices", VertexTints)],
)
def test_tints_come_from_where_the_plan_says(scene, reflectance, kind):
    assert type(tints_of(stage_of(scene, Plan(reflectance=reflectance)))) is kind


def test_a_tint_is_the_models_reflectance_times_each_lamp(scene):
    stage = stage_of(scene)
    spectra = stage.colours.spectra
    values = scene.skin.values[::97]
    R = scene.skin.model.diffuse(values, spectra.wavelengths)
    expected = np.stack(
        [(R * light) @ spectra.colour for light in spectra.light], axis=1
    )
    found = ModelTints(stage, mixing_of(stage.colours)).of(values)
    assert found.shape == (len(values), 2 * 3)
    assert_allclose(found.reshape(-1, 2, 3), expected, rtol=1e-12)


@pytest.mark.parametrize("numbers", [1, 500, 10**9])
def test_tints_are_the_same_however_many_are_made_at_once(scene, monkeypatch, numbers):
    stage = stage_of(scene, Plan(spectrum="16"))
    exact = ModelTints(stage, mixing_of(stage.colours))
    values = scene.skin.values[:60]
    whole = exact.of(values)
    monkeypatch.setattr(tints, "_NUMBERS", numbers)
    assert_allclose(exact.of(values), whole, rtol=1e-14)


def test_pigments_of_a_point_are_between_those_of_its_corners(scene):
    stage = stage_of(scene)
    hits = trace.cast(stage.sight, Plan().cells, np.arange(33 * 27))
    own = pigments_at(stage, hits)
    corners = scene.skin.values[stage.geometry.faces[hits.triangles]]
    weights = hits.weights.T[:, :, None]
    assert_allclose(own, (weights * corners).sum(axis=1), rtol=1e-9)
    assert (own >= scene.skin.values.min(axis=0)).all()
    assert (own <= scene.skin.values.max(axis=0)).all()


def test_uniform_skin_has_the_same_pigments_everywhere(matt):
    stage = stage_of(matt.replace(camera=Camera([0, 0, 1], UP, (6, 5))))
    hits = trace.cast(stage.sight, Plan().cells, np.arange(30))
    assert hits.rays.size > 100
    expected = np.tile(matt.skin.values, (hits.rays.size, 1))
    assert_array_equal(pigments_at(stage, hits), expected)
    every = vertex_pigments(matt)
    assert_array_equal(every, np.tile(matt.skin.values, (matt.mesh.n_points, 1)))


# Tables -------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["scene", "bouncing"])
def test_a_tables_picture_is_within_its_tolerance_of_the_models(request, kind):
    scene = request.getfixturevalue(kind)
    plan = Plan(4, bounce_rays=32, spectrum="16")
    table = render(scene, plan.replace(reflectance="table"))
    model = render(scene, plan)
    assert worst(table, model) < 0.1
    # The share of white that a table may be off, of each light.
    most = TABLE_SHARE * (1 + 0.3) * 1.2
    assert np.abs(table.xyz - model.xyz).max() < most
    assert (table.xyz != model.xyz).any()


def test_a_finer_table_comes_to_the_model(scene, monkeypatch):
    stage = stage_of(scene, Plan(1))
    exact = ModelTints(stage, mixing_of(stage.colours))
    rng = np.random.default_rng(5)
    low, high = scene.skin.values.min(axis=0), scene.skin.values.max(axis=0)
    values = rng.uniform(low, high, (2000, 3))
    truth = exact.of(values)
    white = np.abs(exact.mixing).sum(axis=0)
    errors, sizes = [], []
    for share in (3e-2, 3e-5, 3e-7):
        monkeypatch.setattr(tints, "TABLE_SHARE", share)
        table = table_of(stage, exact.mixing, np.float64)
        off = np.abs(table.at(values) - truth) / white
        assert off.max() <= share * SAFETY
        errors.append(off.max())
        sizes.append(table.size)
    assert errors[2] < errors[1] < errors[0]
    assert sizes[0] < sizes[1] < sizes[2]


@pytest.mark.parametrize("spread", [0.0, 1e-12, 1e-300])
def test_a_table_of_skin_that_hardly_varies_is_the_model(matt, spread):
    values = np.tile([0.1, 0.005, 0.005], (matt.mesh.n_points, 1))
    values[0] += spread
    values[1, 0] += spread
    scene = matt.replace(skin=Skin(matt.skin.model, values))
    table, model = (render(scene, Plan(1, reflectance=r)) for r in ("table", "model"))
    assert_allclose(table.xyz, model.xyz, rtol=1e-6)


# Vertices -----------------------------------------------------------------------


def test_vertices_come_to_the_model_as_edges_squared(matt):
    errors = []
    for n in (9, 17, 33, 65):
        scene = mapped(matt, wave(n), camera=Camera([0, 0, 1], UP, (24, 24)))
        own, exact = (
            render(scene, Plan(1, reflectance=r)).xyz.astype(float)
            for r in ("vertices", "model")
        )
        errors.append(np.abs(own - exact).max())
    np.testing.assert_array_less(np.divide(errors[1:], errors[:-1]), 0.5)
    assert errors[0] / errors[-1] > 40


def test_at_its_vertices_a_tint_is_the_models(scene):
    stage = stage_of(scene, Plan(reflectance="vertices"))
    found = tints_of(stage)
    exact = ModelTints(stage, mixing_of(stage.colours))
    seen = stage.wanted
    assert 0 < seen.sum() < seen.size
    assert_allclose(found.values[seen], exact.of(scene.skin.values[seen]), rtol=1e-12)
    # Others matter to nobody.
    assert not found.values[~seen].any()


def test_vertex_tints_are_linear_over_triangles(scene):
    stage = stage_of(scene, Plan(reflectance="vertices"))
    hits = trace.cast(stage.sight, Plan(1).cells, np.arange(33 * 27))
    found = tints_of(stage)
    corners = found.values[stage.geometry.faces[hits.triangles]]
    expected = (hits.weights.T[:, :, None] * corners).sum(axis=1)
    assert_allclose(found.at(hits), expected, rtol=1e-12)


# Shading at vertices ------------------------------------------------------------


@pytest.mark.parametrize("skin", ["uniform", "mapped", "bouncing"])
@pytest.mark.parametrize("shadows", [True, False])
def test_where_a_sample_is_a_vertex_light_at_vertices_is_light_at_points(
    matt, skin, shadows
):
    # A flat square whose vertices are where the samples are; 40 mm hold 32 steps.
    n, cell = 33, Plan(1).cells[0]
    mesh = joined(plane(n), sphere(6, 2, centre=(3, -4, 30)))
    camera = Camera([0, 0, 1], UP, (32, 32), target=[0, 0, 0], height=40.0)
    shift = np.array([cell[0], 1 - cell[1], 0]) * 40 / 32
    mesh = moved(mesh, pose(shift=shift))
    changes = {
        "surface": TorranceSparrow(),
        "lights": (
            DirectionalLight([0.5, -0.2, 1]),
            PointLight([0, 0, 90], "A", 0.2),
        ),
        "camera": camera,
        "interreflection": "diffuse" if skin == "bouncing" else "none",
    }
    if skin == "uniform":
        scene = matt.replace(mesh=mesh, **changes)
    else:
        scene = mapped(matt, mesh, **changes)
    plan = Plan(1, shadows=shadows, bounce_rays=16, spectrum="16")
    stage = stage_of(scene, plan.replace(shading="vertices"))
    colours = Painter(stage).vertex_xyz[: n * n].reshape(n, n, 3)[::-1]
    own = render(scene, plan.replace(shading="vertices")).xyz
    exact = render(scene, plan).xyz
    # Column and row of each vertex: one more of them than there are pixels.
    at = stage.sight.places[: n * n].reshape(n, n, 2)[::-1]
    column, row = np.floor(at + 1e-6).astype(int).transpose(2, 0, 1)
    whole = (column >= 0) & (column < 32) & (row >= 0) & (row < 32)
    ball = np.abs(np.asarray(mesh.points)[: n * n, :2] - [3, -4] - shift[:2])
    free = whole & (ball.max(axis=1) > 6.5).reshape(n, n)[::-1]
    inner = free & (at.min(axis=2) > 1) & (at.max(axis=2) < 31)
    assert inner.sum() > 600
    got, expected = own[row[inner], column[inner]], colours[inner]
    assert_allclose(got, expected, rtol=1e-5)
    # At points; where a shadow's rim is, either may be right.
    close = np.isclose(exact[row[inner], column[inner]], expected, rtol=1e-5)
    assert close.all(axis=1).mean() > (0.98 if shadows else 0.999)


def test_between_vertices_light_at_vertices_is_linear(scene):
    stage = stage_of(scene, Plan(1, shading="vertices"))
    painter = Painter(stage)
    hits = trace.cast(stage.sight, Plan(1).cells, np.arange(33 * 27))
    corners = painter.vertex_xyz[stage.geometry.faces[hits.triangles]]
    expected = (hits.weights.T[:, :, None] * corners).sum(axis=1)
    found = painter.colours(hits, 1)[hits.pixels]
    assert_allclose(found, expected, rtol=4 * FLOAT32)


def test_light_at_vertices_comes_to_light_at_points(matt):
    errors = []
    for n in (17, 33, 65):
        scene = mapped(
            matt,
            wave(n),
            lights=(DirectionalLight([0.5, 0.3, 1]),),
            camera=Camera([0, 0, 1], UP, (24, 24), target=[0, 0, 0], height=30.0),
        )
        own, exact = (
            render(scene, Plan(1, shading=s)).xyz.astype(float)
            for s in ("vertices", "points")
        )
        errors.append(np.abs(own - exact).max())
    np.testing.assert_array_less(np.divide(errors[1:], errors[:-1]), 0.45)


# Basis and arithmetic -----------------------------------------------------------


@pytest.mark.parametrize("interreflection", ["none", "diffuse"])
@pytest.mark.parametrize("n", [1.4, dispersion("epidermis")])
@pytest.mark.parametrize("skin", ["uniform", "mapped"])
def test_spectra_of_each_point_give_the_colours_of_shared_ones(
    scene, skin, n, interreflection
):
    scene = scene.replace(surface=TorranceSparrow(n=n), interreflection=interreflection)
    if skin == "uniform":
        scene = scene.replace(skin=Skin(scene.skin.model, [0.1, 0.005, 0.005]))
    plan = Plan(2, bounce_rays=16, spectrum="31")
    shared, each = (render(scene, plan.replace(basis=b)) for b in ("shared", "points"))
    scale = shared.xyz.max()
    assert_allclose(each.xyz, shared.xyz, rtol=2e-6, atol=2e-6 * scale)
    assert_allclose(
        each.radiance(), shared.radiance(), rtol=1e-5, atol=1e-6 * scale / 100
    )
    assert_array_equal(each.covered, shared.covered)


@pytest.mark.parametrize("reflectance", ["table", "vertices", "model"])
def test_single_precision_is_double_to_its_rounding(scene, reflectance):
    plan = Plan(1, reflectance=reflectance)
    single, double = (
        render(scene, plan.replace(arithmetic=a)).xyz for a in ("single", "double")
    )
    assert_allclose(single, double, rtol=16 * FLOAT32)
    if reflectance == "model":  # of which nothing is kept
        assert_array_equal(single, double)


@pytest.mark.parametrize("reflectance", ["table", "vertices"])
@pytest.mark.parametrize("arithmetic", ["single", "double"])
def test_tints_are_kept_in_the_numbers_that_the_plan_says(
    scene, reflectance, arithmetic
):
    plan = Plan(reflectance=reflectance, arithmetic=arithmetic)
    stage = stage_of(scene, plan)
    hits = trace.cast(stage.sight, Plan(1).cells, np.arange(33 * 27))
    dtype = tints_of(stage).at(hits).dtype
    assert dtype == (np.float32 if arithmetic == "single" else np.float64)


# Light between parts ------------------------------------------------------------


def test_mapped_pigments_that_are_all_the_same_are_uniform_ones(bouncing):
    one = np.array([0.1, 0.005, 0.005])
    model, n = bouncing.skin.model, bouncing.mesh.n_points
    uniform = bouncing.replace(skin=Skin(model, one))
    same = bouncing.replace(skin=Skin(model, np.tile(one, (n, 1))))
    plan = Plan(2, bounce_rays=32, spectrum="16")
    expected = render(uniform, plan).xyz
    for reflectance in ("vertices", "table", "model"):
        found = render(same, plan.replace(reflectance=reflectance)).xyz
        assert_allclose(found, expected, rtol=1e-5, atol=1e-7)
    found = render(same, plan.replace(shading="vertices")).xyz
    expected = render(uniform, plan.replace(shading="vertices")).xyz
    assert_allclose(found, expected, rtol=1e-5, atol=1e-7)


def test_light_from_mapped_parts_is_what_the_plain_way_gives(bouncing):
    # Spectra at each point and band, summed, against fields of few spectra.
    plan = Plan(2, bounce_rays=32, spectrum="scene")
    ours = render(bouncing, plan)
    nothing = render(bouncing, plan.replace(bounce_rays=0))
    more = ours.xyz.astype(float) - nothing.xyz
    assert more.max() > 0.005
    plain = render(bouncing, plan.replace(basis="points"))
    assert_allclose(plain.xyz, ours.xyz, rtol=2e-6, atol=1e-7)


def test_dark_parts_throw_less_light_than_fair_ones(bouncing):
    ball = np.arange(bouncing.mesh.n_points) >= 21 * 21
    pictures = []
    for melanin in (0.02, 0.6):
        values = np.array(bouncing.skin.values)
        values[ball, 0] = melanin
        skin = Skin(bouncing.skin.model, values)
        pictures.append(
            [
                render(
                    bouncing.replace(skin=skin), Plan(1, bounce_rays=n, spectrum="16")
                )
                for n in (0, 32)
            ]
        )
    stage = stage_of(bouncing)
    hits = trace.cast(stage.sight, Plan(1).cells, np.arange(33 * 27))
    floor = hits.pixels[hits.triangles < len(faces_of(wave(21)))]
    fair, dark = (
        (every.xyz - none.xyz).reshape(-1, 3)[floor, 1] for none, every in pictures
    )
    lit = fair > 1e-4
    assert lit.sum() > 20
    assert (dark[lit] < fair[lit] + 1e-5).all()  # some see the wave alone
    assert np.median(dark[lit] / fair[lit]) < 0.8


def test_a_painter_can_be_used_without_being_prepared(scene):
    stage = stage_of(scene, Plan(1, reflectance="table"))
    ready = Painter(dataclasses.replace(stage))
    ready.prepare()
    pixels = np.arange(33 * 27)
    one, other = (p.colours(p.cast(pixels, 1), 1) for p in (ready, Painter(stage)))
    assert_array_equal(one, other)
