"""Over which wavelengths light is summed: by a plain sum of colour-science's tables."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from meshes import plane
from skinviz import Camera, DirectionalLight, Plan, Skin, TorranceSparrow, render
from skinviz.errors import ArgumentError
from skinviz.rendering.plan import SPECTRA
from skinviz.rendering.spectral import (
    colour_rule,
    light_spectra,
    spectra_rule,
    wavelength_limits,
    white_xyz,
)
from skinviz.rendering.stage import stage_of
from skinviz.rendering.tolerance import colour_differences
from skinviz.spectra.colorimetry import OBSERVERS, colour_matching_functions
from skinviz.spectra.illuminants import Illuminant, line_lamp, with_lines
from skinviz.spectra.wavelengths import band_widths
from skinviz.surface.dispersion import Dispersion, dispersion

NM = np.arange(380.0, 781.0)
FLOAT32 = 2.0**-23
LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3")
STANDARD = {
    "cie1931": "CIE 1931 2 Degree Standard Observer",
    "cie1964": "CIE 1964 10 Degree Standard Observer",
}
MERCURY = [[404.7, 0.2], [435.8, 0.3], [546.1, 1.0], [578.0, 0.4]]
UP = [0.0, 1.0, 0.0]

# Largest ΔE00 over measured skin under six lamps, of tests/spectra/test_rules.py.
BOUNDS = {"6 nodes": 1.5, "10 nodes": 0.6, "16 nodes": 0.6}


@pytest.fixture
def cmfs(colour):
    """The observer's functions at wavelengths [nm] (n, 3), linear between 1 nm."""

    def at(nm, observer="cie1931"):
        table = colour.MSDS_CMFS[STANDARD[observer]]
        columns = table.values.T
        return np.stack([np.interp(nm, table.wavelengths, c) for c in columns], axis=1)

    return at


@pytest.fixture
def power(colour):
    """A lamp's power at every nanometre, linear between its table's wavelengths."""

    def at(name):
        table = colour.SDS_ILLUMINANTS[name]
        return np.interp(NM, table.wavelengths, table.values)

    return at


@pytest.fixture
def lit_by(matt):
    """The matt square of skin under a lamp that it faces, small."""

    def scene(lamp, **changes):
        light = DirectionalLight([0, 0, 1], lamp)
        camera = Camera([0, 0, 1], UP, (4, 3), height=9.0)
        return matt.replace(lights=(light,), camera=camera, **changes)

    return scene


def xyz_facing(scene, spectrum="1 nm"):
    """XYZ of uniform matt skin that faces the light, in double precision."""
    return stage_of(scene, Plan(spectrum=spectrum)).colours.matrix[0]


def plain_sum(reflectance, power, cmfs):
    """XYZ of reflectances (..., n), Y = 1 of a perfect diffuser."""
    return reflectance @ (power[:, None] * cmfs) / (power @ cmfs[:, 1])


# Every nanometre ----------------------------------------------------------------


@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("lamp", LAMPS)
def test_uniform_skin_is_a_sum_at_every_nanometre(lit_by, cmfs, power, lamp, observer):
    scene = lit_by(lamp, observer=observer)
    R = scene.skin.model.diffuse(scene.skin.values, NM)
    expected = plain_sum(R, power(lamp), cmfs(NM, observer))
    assert_allclose(xyz_facing(scene), expected, rtol=1e-12)
    picture = render(scene, Plan())
    assert (picture.covered == 16).all()
    assert_allclose(picture.xyz, np.tile(expected, (3, 4, 1)), rtol=3 * FLOAT32)


@pytest.mark.parametrize("lamp", LAMPS)
def test_mapped_skin_is_a_sum_at_every_nanometre_and_point(lit_by, cmfs, power, lamp):
    # Pigments that are linear in place, so that interpolation changes nothing.
    scene = lit_by(lamp)
    points = np.asarray(scene.mesh.points)
    low, high = np.array([0.02, 0.002, 0.001]), np.array([0.4, 0.02, 0.01])
    values = low + (high - low) * (points[:, :1] / 40 + 0.5)
    picture = render(scene.replace(skin=Skin(scene.skin.model, values)), Plan(1))
    column = np.arange(4) + Plan(1).cells[0, 0]
    x = (column - 2) * picture.view.pixel
    own = low + (high - low) * (x[:, None] / 40 + 0.5)
    R = scene.skin.model.diffuse(own, NM)
    expected = plain_sum(R, power(lamp), cmfs(NM))
    assert np.ptp(expected[:, 1]) > 0.05
    assert_allclose(picture.xyz, np.tile(expected, (3, 1, 1)), rtol=3 * FLOAT32)


@pytest.mark.parametrize("nm", [405.25, 532.0, 632.8, 700.1])
def test_a_laser_is_where_it_is(lit_by, cmfs, nm):
    scene = lit_by(line_lamp([[nm, 5.0]]))
    R = scene.skin.model.diffuse(scene.skin.values, np.array([nm]))
    own = cmfs([nm])[0]
    assert_allclose(xyz_facing(scene), R[0] * own / own[1], rtol=1e-12)


def test_lines_count_where_they_are_and_by_their_power(lit_by, cmfs):
    nm, power = np.array(MERCURY).T
    scene = lit_by(line_lamp(MERCURY))
    R = scene.skin.model.diffuse(scene.skin.values, nm)
    assert_allclose(xyz_facing(scene), plain_sum(R, power, cmfs(nm)), rtol=1e-12)


def test_lines_add_to_a_table_of_power_per_nanometre(lit_by, cmfs, power):
    lamp = Illuminant("D65", NM, power("D65"))
    nm, own = np.array(MERCURY).T
    scene = lit_by(with_lines(lamp, np.stack([nm, 300 * own], axis=1)))
    every = np.concatenate([NM, nm])
    ascending, place = np.unique(every, return_inverse=True)
    R = scene.skin.model.diffuse(scene.skin.values, ascending)[place]
    light = np.concatenate([power("D65"), 300 * own])
    expected = plain_sum(R, light, cmfs(every))
    assert_allclose(xyz_facing(scene), expected, rtol=1e-12)


def test_a_short_table_is_dark_beyond_its_ends(lit_by, cmfs):
    nm = np.arange(500.0, 601.0)
    own = np.interp(nm, [500, 530, 600], [1.0, 3.0, 2.0])
    scene = lit_by(Illuminant("short", [500, 530, 600], [1.0, 3.0, 2.0]))
    R = scene.skin.model.diffuse(scene.skin.values, nm)
    assert_allclose(xyz_facing(scene), plain_sum(R, own, cmfs(nm)), rtol=1e-12)


def test_lamps_each_have_their_own_wavelengths(lit_by, matt):
    # With two lamps, each gives what it gives alone.
    short = Illuminant("short", [500, 530, 600], [1.0, 3.0, 2.0])
    lamps = [short, line_lamp(MERCURY), "A"]
    lights = tuple(DirectionalLight([0, 0, 1], lamp, 2.0) for lamp in lamps)
    together = stage_of(matt.replace(lights=lights)).colours.matrix[:3]
    for lamp, own in zip(lamps, together, strict=True):
        assert_allclose(own, xyz_facing(lit_by(lamp)), rtol=1e-12)


@pytest.mark.parametrize("exposure", [0.3, 1.0, 1e20])
@pytest.mark.parametrize("lamp", LAMPS)
def test_white_is_colour_sciences_white(lit_by, cmfs, power, lamp, exposure):
    expected = exposure * plain_sum(np.ones(NM.size), power(lamp), cmfs(NM))
    assert_allclose(white_xyz(lit_by(lamp, exposure=exposure)), expected, rtol=1e-12)


# Bands and nodes ----------------------------------------------------------------


@pytest.mark.parametrize("spectrum", SPECTRA)
@pytest.mark.parametrize("lamp", [*LAMPS, "546 nm"])
def test_every_sum_gives_white_a_luminance_of_one(lit_by, spectrum, lamp):
    rule = colour_rule(lit_by(lamp), spectrum)
    assert rule.white[0, 1] == pytest.approx(1, rel=1e-12)
    assert (rule.light >= 0).all()
    assert (rule.colour >= 0).all()


@pytest.mark.parametrize("n", [16, 31])
def test_even_bands_are_a_plain_sum_over_the_papers_range(lit_by, cmfs, power, n):
    scene, nm = lit_by("A"), np.linspace(400, 700, n)
    R = scene.skin.model.diffuse(scene.skin.values, nm)
    own = np.interp(nm, NM, power("A")) * band_widths(nm)
    expected = plain_sum(R, own, cmfs(nm))
    assert_allclose(xyz_facing(scene, str(n)), expected, rtol=1e-12)


@pytest.mark.parametrize("n", [16, 31])
def test_even_bands_stay_within_what_lamps_cover(lit_by, n):
    scene = lit_by(Illuminant("short", [500, 530, 600], [1.0, 3.0, 2.0]))
    rule = colour_rule(scene, str(n))
    assert_allclose(rule.wavelengths, np.linspace(500, 600, n))
    apart = (DirectionalLight(UP, Illuminant("other", [610, 650], [1.0, 1.0])),)
    with pytest.raises(ArgumentError, match="share no wavelengths"):
        colour_rule(scene.replace(lights=scene.lights + apart), str(n))
    # Every nanometre is summed all the same.
    assert len(colour_rule(scene.replace(lights=scene.lights + apart), "1 nm").light)


def many_skins(scene, n=400):
    """The scene with as many pigments as it has vertices, from light to dark."""
    mesh = plane(20)
    rng = np.random.default_rng(1)
    values = rng.uniform(0, 1, (mesh.n_points, 3)) ** 2 * [0.6, 0.03, 0.03] + 1e-4
    assert mesh.n_points == n
    return scene.replace(mesh=mesh, skin=Skin(scene.skin.model, values))


def largest_error(scene, spectrum):
    """Largest ΔE00 of a scene's pigments, facing the light, to every nanometre."""
    values, model = scene.skin.values, scene.skin.model

    def xyz(rule):
        every, place = np.unique(rule.wavelengths, return_inverse=True)
        return rule.xyz(model.diffuse(values, every)[:, place])[0]

    exact = colour_rule(scene, "1 nm")
    ours, true = xyz(colour_rule(scene, spectrum)), xyz(exact)
    return colour_differences(ours, true, exact.white[0]).max()


@pytest.mark.parametrize("lamp", LAMPS)
def test_nodes_keep_the_colours_of_mapped_skin(lit_by, lamp):
    scene = many_skins(lit_by(lamp))
    errors = {name: largest_error(scene, name) for name in BOUNDS}
    for name, bound in BOUNDS.items():
        assert errors[name] < bound
    assert errors["10 nodes"] <= errors["6 nodes"]


@pytest.mark.parametrize("lamp", ["D65", "A"])
def test_bands_are_off_by_their_width_and_by_what_lies_beyond_them(lit_by, lamp):
    # However narrow, from 400 to 700 nm: measured, and rounded up.
    scene = many_skins(lit_by(lamp))
    assert largest_error(scene, "1 nm") == 0
    assert 0.2 < largest_error(scene, "16") < 1.3
    assert 0.2 < largest_error(scene, "31") < 0.5


@pytest.mark.parametrize("spectrum", ["6 nodes", "10 nodes", "1 nm"])
def test_few_lines_are_kept_as_they_are(lit_by, spectrum):
    scene = lit_by(line_lamp(MERCURY))
    rule = colour_rule(scene, spectrum)
    assert_array_equal(np.sort(rule.wavelengths), np.array(MERCURY)[:, 0])
    assert_allclose(xyz_facing(scene, spectrum), xyz_facing(scene), rtol=1e-13)


@pytest.mark.parametrize("spectrum", ["6 nodes", "10 nodes", "16 nodes"])
def test_nodes_are_no_more_than_their_name_says(lit_by, spectrum):
    scene = many_skins(lit_by("D65"))
    assert colour_rule(scene, spectrum).wavelengths.size <= int(spectrum.split()[0])


# The scene's own bands ----------------------------------------------------------


@pytest.mark.parametrize("skin", ["uniform", "mapped"])
@pytest.mark.parametrize("bands", [[550.0], np.arange(420.0, 681.0, 20.0), None])
def test_colours_of_the_scenes_bands_are_sums_of_its_radiance(lit_by, skin, bands):
    scene = lit_by("FL2", surface=TorranceSparrow())
    if bands is not None:
        scene = scene.replace(wavelengths=bands)
    if skin == "mapped":
        scene = many_skins(scene)
    picture = render(scene, Plan(4, spectrum="scene"))
    nm = scene.wavelengths
    weights = colour_matching_functions(nm) * band_widths(nm)[:, None]
    expected = picture.radiance().astype(float) @ weights
    assert_allclose(picture.xyz, expected, rtol=4 * FLOAT32 * nm.size)


def test_lamps_spectra_are_told_in_the_scenes_bands(lit_by):
    # Between two bands, each of which has its share.
    scene = lit_by("546 nm")
    light = light_spectra(scene)[0]
    nm = scene.wavelengths
    assert_array_equal(nm[light > 0], [545, 550])
    assert (light * nm).sum() / light.sum() == pytest.approx(546, rel=1e-12)
    rule = spectra_rule(scene)
    assert_array_equal(rule.wavelengths, nm)
    assert rule.white[0, 1] == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("exposure", [1.0, 7.0])
def test_the_luminance_of_a_lamps_spectrum_is_the_exposure(lit_by, exposure):
    scene = lit_by("A", exposure=exposure)
    lights = (*scene.lights, DirectionalLight(UP, "D65", 0.25))
    spectra = light_spectra(scene.replace(lights=lights))
    nm = scene.wavelengths
    weights = colour_matching_functions(nm)[:, 1] * band_widths(nm)
    assert_allclose(spectra @ weights, [exposure, exposure / 4], rtol=1e-12)


# What of the surface ------------------------------------------------------------


@pytest.fixture
def glossy(lit_by):
    """Glossy skin that shines at the viewer, with an index that falls."""
    return lit_by("D65", surface=TorranceSparrow(n=dispersion("epidermis")))


def test_without_specular_nothing_shines(glossy):
    bare = glossy.replace(surface=TorranceSparrow(specular_scale=0.0))
    ours, expected = render(glossy, Plan(specular="none")), render(bare, Plan())
    assert_allclose(ours.xyz, expected.xyz, rtol=2 * FLOAT32)
    assert_allclose(ours.radiance(), expected.radiance(), rtol=2 * FLOAT32)
    assert (render(glossy, Plan()).xyz > 1.02 * ours.xyz).all()


def test_a_constant_index_is_that_at_555_nm(glossy):
    index = float(dispersion("epidermis").index([555.0])[0])
    one = glossy.replace(surface=TorranceSparrow(n=index))
    ours, expected = render(glossy, Plan(specular="constant")), render(one, Plan())
    assert_array_equal(ours.xyz, expected.xyz)
    assert_array_equal(ours.radiance(), expected.radiance())
    assert (ours.xyz != render(glossy, Plan()).xyz).any()


def test_without_dispersion_a_constant_index_is_exact(glossy):
    scene = glossy.replace(surface=TorranceSparrow(n=1.5))
    ours, exact = render(scene, Plan(specular="constant")), render(scene, Plan())
    assert_array_equal(ours.xyz, exact.xyz)


def test_dispersion_is_fresnels_law_at_every_nanometre(glossy, cmfs, power):
    # At normal incidence F = ((n - 1) / (n + 1))² of each wavelength.
    shine = render(glossy, Plan()).xyz - render(glossy, Plan(specular="none")).xyz
    n = dispersion("epidermis").index(NM)
    F = ((n - 1) / (n + 1)) ** 2
    expected = plain_sum(F, power("D65"), cmfs(NM))
    got = shine[1, 1].astype(float)
    assert_allclose(got / got[1], expected / expected[1], rtol=2e-5)


def test_light_is_summed_as_far_as_skin_and_surface_are_known(lit_by, cmfs, power):
    known = Dispersion("short", 1.38, 4000.0, shortest=430.0, longest=650.5)
    scene = lit_by("A", surface=TorranceSparrow(n=known, specular_scale=0.0))
    assert wavelength_limits(lit_by("A")) == (380, 780)
    assert wavelength_limits(scene) == (430, 650.5)
    nm = np.arange(430.0, 651.0)
    R = scene.skin.model.diffuse(scene.skin.values, nm)
    expected = plain_sum(R, np.interp(nm, NM, power("A")), cmfs(nm))
    assert_allclose(xyz_facing(scene), expected, rtol=1e-12)


def test_a_surface_known_where_skin_is_not_is_refused(lit_by):
    known = Dispersion("infrared", 1.38, 4000.0, shortest=800.0, longest=900.0)
    scene = lit_by("A", surface=TorranceSparrow(n=known))
    with pytest.raises(ArgumentError, match="share no wavelength"):
        render(scene, Plan())


def test_a_lamp_that_nobody_sees_is_refused(lit_by):
    with pytest.raises(ArgumentError, match="no power where the observer sees"):
        render(lit_by(line_lamp([[900.0, 1.0]])), Plan())
