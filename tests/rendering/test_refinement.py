"""Pixels that are refined have the reference's light; the others the plan's samples."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from meshes import joined, plane, sphere, toy_hand, wave
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    render,
)
from skinviz.rendering import contrasts, imager
from skinviz.rendering.imager import contrast_white
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.stage import stage_of
from skinviz.spectra.colorimetry import xyz_to_lab
from skinviz.spectra.illuminants import line_lamp

UP = [0.0, 1.0, 0.0]
SIZE = (45, 35)


@pytest.fixture(params=["uniform", "mapped", "bouncing", "vertices"])
def scene(request, matt):
    """A glossy wave with a ball's shadow on it, and how its light is computed."""
    mesh = joined(wave(15), sphere(8, 2, centre=(2, -3, 12)))
    rng = np.random.default_rng(7)
    skin = matt.skin
    if request.param != "uniform":
        skin = Skin(skin.model, rng.uniform(0.001, 0.1, (mesh.n_points, 3)))
    return matt.replace(
        mesh=mesh,
        skin=skin,
        surface=TorranceSparrow(),
        lights=(DirectionalLight([-0.4, 0.2, 1]), PointLight([30, 20, 60], "A", 0.3)),
        camera=Camera([0.2, -0.3, 1], UP, SIZE, distance=250.0),
        interreflection="diffuse" if request.param == "bouncing" else "none",
    )


@pytest.fixture
def plan(request, scene):
    """The reference, but for wavelengths; at vertices where the scene says so."""
    shading = "vertices" if "vertices" in request.node.name else "points"
    return Plan(bounce_rays=16, spectrum="16", shading=shading)


def marked(scene):
    """Pixels (h, w) that an outline may cross."""
    return stage_of(scene).sight.outlines


# Which pixels, and what they are ------------------------------------------------


@pytest.mark.parametrize(
    ("samples", "refine"), [(1, 2.0), (1, 1e6), (2, 16.0), (4, 8.0)]
)
def test_refined_pixels_are_the_references_bit_for_bit(scene, plan, samples, refine):
    reference, even = render(scene, plan), render(scene, plan.replace(samples=samples))
    picture = render(scene, plan.replace(samples=samples, refine=refine))
    fine = picture.rays == 16
    assert set(np.unique(picture.rays)) == {samples, 16}
    assert_array_equal(picture.xyz[fine], reference.xyz[fine])
    assert_array_equal(picture.covered[fine], reference.covered[fine])
    # All others are what they are without refinement.
    assert_array_equal(picture.xyz[~fine], even.xyz[~fine])
    assert_array_equal(picture.covered[~fine], even.covered[~fine])


@pytest.mark.parametrize("samples", [1, 4])
def test_no_pixel_in_part_is_left_with_few_rays(scene, plan, samples):
    reference = render(scene, plan)
    picture = render(scene, plan.replace(samples=samples, refine=1e6))
    partly = (reference.covered > 0) & (reference.covered < 16)
    assert partly.sum() > 50
    assert (picture.rays[partly] == 16).all()
    assert (picture.rays[marked(scene)] == 16).all()
    assert_array_equal(picture.coverage, reference.coverage)


def test_a_lower_contrast_refines_more_and_all_that_a_higher_one_does(scene, plan):
    before = np.ones(SIZE[::-1], dtype=bool)
    counts = []
    for refine in (0.0, 1.0, 4.0, 16.0, 64.0, 1e6):
        fine = render(scene, plan.replace(samples=1, refine=refine)).rays == 16
        assert before[fine].all()
        counts.append(int(fine.sum()))
        before = fine
    assert counts[-1] < counts[2] < counts[0]


def test_without_a_limit_all_that_differs_at_all_is_refined(scene, plan):
    even = render(scene, plan.replace(samples=1))
    picture = render(scene, plan.replace(samples=1, refine=0.0))
    few = picture.rays == 1
    # What has few rays is like each neighbour that has as few.
    for axis in (0, 1):
        first, second = (np.moveaxis(a, axis, 0) for a in (few, even.xyz))
        both = first[1:] & first[:-1]
        assert_array_equal(second[1:][both], second[:-1][both])
    reference = render(scene, plan)
    full = few & (reference.covered == 16)
    assert full.sum() < 12


def test_sixteen_samples_leave_nothing_to_refine(scene, plan):
    refined, plain = render(scene, plan.replace(refine=0.5)), render(scene, plan)
    assert_array_equal(refined.xyz, plain.xyz)
    assert (refined.rays == 16).all()


def test_even_plans_have_as_many_rays_everywhere(scene, plan):
    for samples in (1, 2, 4, 8):
        assert (render(scene, plan.replace(samples=samples)).rays == samples).all()


@pytest.mark.parametrize("step", [45, 150])
def test_pictures_are_the_same_however_many_pixels_are_worked_on(
    scene, plan, monkeypatch, step
):
    own = plan.replace(samples=1, refine=4.0)
    whole = render(scene, own)
    monkeypatch.setattr(imager, "_step", lambda *_: step)
    parts = render(scene, own)
    assert_array_equal(parts.xyz, whole.xyz)
    assert_array_equal(parts.rays, whole.rays)


# Spectra of refined pictures ----------------------------------------------------


def test_spectra_are_of_the_rays_of_the_picture(scene, plan):
    own = plan.replace(samples=2, refine=4.0, shading="points")
    picture = render(scene, own)
    fine = picture.rays == 16
    assert 0 < fine.sum() < fine.size
    many, few = (
        render(scene, own.replace(samples=n, refine=None)).radiance() for n in (16, 2)
    )
    found = picture.radiance()
    assert_array_equal(found[fine], many[fine])
    assert_array_equal(found[~fine], few[~fine])


def test_spectra_of_regions_are_those_of_the_whole(scene, plan):
    picture = render(scene, plan.replace(samples=1, refine=4.0, shading="points"))
    whole = picture.radiance()
    for left, top, right, bottom in [(0, 0, 45, 1), (12, 9, 33, 31), (44, 34, 45, 35)]:
        part = picture.radiance((left, top, right, bottom))
        assert_array_equal(part, whole[top:bottom, left:right])
    rows = np.concatenate([block.copy() for block in picture.rows()])
    assert_array_equal(rows, whole)


def test_a_refined_pictures_bands_sum_to_its_colours(scene, plan):
    from skinviz.spectra.colorimetry import colour_matching_functions
    from skinviz.spectra.wavelengths import band_widths

    own = plan.replace(samples=1, refine=4.0, spectrum="scene", shading="points")
    picture = render(scene, own)
    nm = picture.wavelengths
    weights = colour_matching_functions(nm) * band_widths(nm)[:, None]
    expected = picture.radiance().astype(float) @ weights
    np.testing.assert_allclose(picture.xyz, expected, rtol=1e-5, atol=1e-7)


# Small and empty pictures -------------------------------------------------------


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (7, 1), (2, 2)])
@pytest.mark.parametrize("refine", [0.0, 8.0])
def test_small_pictures_are_the_references(scene, plan, size, refine):
    scene = scene.replace(camera=Camera([0.2, -0.3, 1], UP, size))
    picture = render(scene, plan.replace(samples=1, refine=refine))
    reference = render(scene, plan)
    fine = picture.rays == 16
    assert_array_equal(picture.xyz[fine], reference.xyz[fine])
    assert_array_equal(picture.coverage, reference.coverage)


@pytest.mark.parametrize("refine", [None, 0.0, 8.0])
def test_a_picture_past_the_mesh_is_empty(scene, plan, refine):
    camera = Camera([0, 0, 1], UP, (9, 8), target=[900, 0, 0], height=10.0)
    with pytest.warns(UserWarning, match="no ray meets the mesh"):
        picture = render(
            scene.replace(camera=camera), plan.replace(samples=1, refine=refine)
        )
    assert not picture.xyz.any()
    assert not picture.covered.any()
    assert (picture.rays == 1).all()
    assert not picture.radiance().any()


def test_with_the_eye_among_the_points_all_has_sixteen(white):
    # No outline is known there.
    camera = Camera([0, 0, 1], UP, (20, 16), 10.0, target=[0, 0, 25], height=9.0)
    scene = white.replace(mesh=joined(plane(9), sphere(3, 1, (40, 0, 36))))
    scene = scene.replace(camera=camera)
    assert stage_of(scene).sight.places is None
    picture, reference = render(scene, Plan(1, refine=64.0)), render(scene, Plan())
    assert (picture.rays == 16).all()
    assert_array_equal(picture.xyz, reference.xyz)


# Contrasts ----------------------------------------------------------------------


def about_delta_e(one, other, white):
    """ΔE of two XYZ (..., 3), with half of the chroma: in CIELAB by the library."""
    lab = [
        np.cbrt(np.maximum(v / np.maximum(v[..., 1:2], 1), 0) / white)
        for v in (one, other)
    ]
    x, y, z = np.moveaxis(lab[0] - lab[1], -1, 0)
    return np.sqrt((116 * y) ** 2 + (250 * (x - y)) ** 2 + (100 * (y - z)) ** 2)


def test_contrast_is_the_size_of_cielabs_difference_with_half_the_chroma():
    rng = np.random.default_rng(2)
    white = np.array([0.95, 1.0, 1.09])
    xyz = rng.uniform(0.05, 0.9, (400, 2, 3))
    out = np.zeros(400)
    contrasts.neighbour_contrasts(xyz, white, out)
    lab = xyz_to_lab(xyz, white)
    L, a, b = (lab[:, 0] - lab[:, 1]).T
    expected = np.sqrt(L**2 + (a / 2) ** 2 + (b / 2) ** 2)
    np.testing.assert_allclose(out, expected, rtol=1e-9)
    np.testing.assert_allclose(about_delta_e(xyz[:, 0], xyz[:, 1], white), out)


@pytest.mark.parametrize("limit", [0.0, 3.0, 20.0])
def test_contrasts_are_marked_on_both_sides_where_rays_are_few(limit):
    rng = np.random.default_rng(4)
    h, w = 23, 31
    white = np.array([0.95, 1.0, 1.09])
    xyz = rng.uniform(0.2, 1.3, (h, w, 1)) * [0.9, 1, 0.7]
    xyz *= rng.normal(1, 0.03, (h, w, 3))
    xyz[3:6, 4:9] = 0.4  # even, and nothing
    xyz[10:12, :5] = 0.0
    xyz = xyz.astype(np.float32)
    rays = np.where(rng.random((h, w)) < 0.2, 16, 2).astype(np.uint8)
    out = np.zeros((h, w), dtype=bool)
    contrasts.contrasts(xyz, rays, 2, white, limit, 0, h, out)
    # By a slow loop over pairs.
    expected = np.zeros((h, w), dtype=bool)
    for row, column in np.ndindex(h, w):
        for other in ((row, column + 1), (row + 1, column)):
            if other[0] == h or other[1] == w:
                continue
            pair = xyz[row, column].astype(float), xyz[other].astype(float)
            few = rays[row, column] == rays[other] == 2
            if few and about_delta_e(*pair, white) > limit:
                expected[row, column] = expected[other] = True
    assert_array_equal(out, expected)
    assert expected.any()
    assert not expected.all()


@pytest.mark.parametrize(("lamp", "flat"), [("D65", False), ("A", False), (None, True)])
def test_contrasts_under_a_lamp_without_white_are_judged_by_equal_energy(
    matt, lamp, flat
):
    light = DirectionalLight([0, 0, 1], lamp or line_lamp([[580.0, 1.0]]))
    stage = stage_of(matt.replace(lights=(light,), exposure=2.0))
    white = contrast_white(stage)
    expected = np.full(3, 2.0) if flat else white_xyz(stage.scene)
    np.testing.assert_allclose(white, expected, rtol=1e-12)


def test_refining_a_hand_comes_near_the_reference_for_few_rays(matt):
    scene = matt.replace(
        mesh=toy_hand(),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([-1, 0.6, 0.4]),),
        camera=Camera([0.3, 1, 0.1], [0, 0, 1], (96, 96)),
    )
    reference = render(scene, Plan()).xyz.astype(float)
    errors = []
    for plan in (Plan(1), Plan(1, refine=8.0), Plan(4, refine=2.0)):
        picture = render(scene, plan)
        errors.append(np.abs(picture.xyz - reference).max())
        assert picture.rays.mean() < 8
    assert errors[2] < errors[1] < errors[0]
