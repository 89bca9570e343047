"""Eq. (10) at every vertex: identities, and colour against colour-science."""

import numpy as np
import pytest
from surface_kinds import SURFACES
from tolerances import ROUNDING

from meshes import cube, moved, plane, pose, sphere, tetrahedron, toy_hand
from skinviz import Camera, DirectionalLight, Plan, Skin, TorranceSparrow
from skinviz.errors import ArgumentError, MeshError, SkinvizError
from skinviz.rendering.shade import shade, vertex_spectrum
from skinviz.rendering.spectral import light_spectra
from skinviz.scan.topology import arrays, polydata, vertex_normals
from skinviz.scene.scene import Scene
from skinviz.spectra.colorimetry import colour_matching_functions
from skinviz.spectra.illuminants import illuminants
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS
from skinviz.surface import dispersion

FLOAT32 = 2.0**-23
"""Radiance is kept as float32; a product of two rounds twice."""

SHAPE = (400, 700, 5)


def radiance(scene):
    return np.asarray(shade(scene).point_data["radiance"], dtype=np.float64)


def glossy(scene, **changes):
    return scene.replace(surface=TorranceSparrow(), **changes)


# Colour, against colour-science -----------------------------------------------


def integrated(colour, spectrum, illuminant):
    """XYZ of a reflectance by colour-science itself, perfect white Y = 1."""
    shape = colour.SpectralShape(*SHAPE)
    return (
        colour.sd_to_XYZ(
            colour.SpectralDistribution(spectrum, shape.wavelengths),
            colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape),
            colour.SDS_ILLUMINANTS[illuminant].copy().align(shape),
            method="Integration",
        )
        / 100
    )


@pytest.mark.parametrize("illuminant", ["D65", "A", "FL2", "LED-B3"])
def test_a_lambertian_patch_has_the_colour_that_colour_science_integrates(
    matt, xyz_of, colour, illuminant
):
    lit = matt.replace(lights=(DirectionalLight([0, 0, 1], illuminant),))
    xyz, _ = xyz_of(lit)
    body = matt.skin.model.diffuse(matt.skin.values, matt.wavelengths)
    expected = integrated(colour, body, illuminant)
    white = integrated(colour, np.ones(61), illuminant)
    lab = [colour.XYZ_to_Lab(x, colour.XYZ_to_xy(white)) for x in (xyz[0], expected)]
    assert colour.delta_E(*lab, method="CIE 2000") < 0.05
    np.testing.assert_allclose(xyz[0], expected, rtol=1e-5)
    np.testing.assert_allclose(xyz, np.tile(xyz[0], (len(xyz), 1)), rtol=ROUNDING)


def test_its_display_colour_is_that_of_colour_science(matt, colour):
    body = matt.skin.model.diffuse(matt.skin.values, matt.wavelengths)
    expected = 255 * colour.XYZ_to_sRGB(integrated(colour, body, "D65"))
    rgb = np.asarray(shade(matt).point_data["rgb"], dtype=int)
    assert np.abs(rgb - expected).max() <= 1


@pytest.mark.parametrize("name", illuminants())
def test_the_perfect_diffuser_is_the_illuminants_white(white, xyz_of, colour, name):
    xyz, mesh = xyz_of(white.replace(lights=(DirectionalLight([0, 0, 1], name),)))
    np.testing.assert_allclose(xyz[:, 1], 1, rtol=1e-12)
    np.testing.assert_allclose(xyz[0], integrated(colour, np.ones(61), name), rtol=1e-5)
    assert np.isfinite(mesh.point_data["radiance"]).all()


@pytest.mark.parametrize("observer", ["cie1931", "cie1964"])
def test_white_has_luminance_one_for_each_observer(white, xyz_of, observer):
    xyz, _ = xyz_of(white.replace(observer=observer, exposure=0.5))
    np.testing.assert_allclose(xyz[:, 1], 0.5, rtol=1e-12)


@pytest.mark.parametrize(
    "wavelengths",
    [[550.0], np.arange(400, 701, 10), np.arange(380, 781, 1), [450, 500, 620, 640]],
    ids=["one band", "10 nm", "1 nm", "uneven"],
)
def test_white_has_luminance_one_on_any_grid(white, xyz_of, wavelengths):
    xyz, mesh = xyz_of(white.replace(wavelengths=wavelengths))
    np.testing.assert_allclose(xyz[:, 1], 1, rtol=1e-12)
    # VTK gives an array of one component back without its last axis.
    assert mesh.point_data["radiance"].size == white.mesh.n_points * len(wavelengths)


# The factorised colour --------------------------------------------------------


@pytest.mark.parametrize("uniform", [True, False])
def test_colour_is_that_of_the_radiance(matt, xyz_of, uniform):
    # Colours come from geometry times spectra; here from the radiance itself.
    mesh = sphere(subdivisions=3)
    rng = np.random.default_rng(0)
    values = rng.uniform(0.001, 0.1, (3,) if uniform else (mesh.n_points, 3))
    scene = glossy(
        matt,
        mesh=mesh,
        skin=Skin(matt.skin.model, values),
        lights=(
            DirectionalLight([1, 1, 1], "A"),
            DirectionalLight([-1, 0.5, 0.2], "FL11", 0.4),
        ),
    )
    xyz, shaded = xyz_of(scene)
    cmfs = colour_matching_functions(PAPER_WAVELENGTHS)
    summed = 5.0 * np.asarray(shaded.point_data["radiance"], dtype=float) @ cmfs
    np.testing.assert_allclose(summed, xyz, rtol=1e-6, atol=1e-12)


def test_equal_pigments_everywhere_are_uniform_pigments(matt):
    mesh = sphere(subdivisions=3)
    uniform = glossy(matt, mesh=mesh)
    mapped = uniform.replace(
        skin=Skin(matt.skin.model, np.tile(matt.skin.values, (mesh.n_points, 1)))
    )
    one, each = shade(uniform), shade(mapped)
    np.testing.assert_allclose(
        one.point_data["radiance"], each.point_data["radiance"], rtol=3 * FLOAT32
    )
    np.testing.assert_array_equal(one.point_data["rgb"], each.point_data["rgb"])
    np.testing.assert_array_equal(
        one.point_data["pigments"], each.point_data["pigments"]
    )


def test_pigments_differ_where_they_are_made_to(matt):
    values = np.tile([0.1, 0.005, 0.005], (matt.mesh.n_points, 1))
    values[7, 0] = 0.4
    mapped = radiance(matt.replace(skin=Skin(matt.skin.model, values)))
    plain = radiance(matt)
    changed = np.flatnonzero((mapped != plain).any(axis=1))
    assert changed.tolist() == [7]
    assert (mapped[7] < plain[7]).all()


# Lights -----------------------------------------------------------------------


def test_light_adds(matt):
    first = DirectionalLight([0.3, 0, 1], "D65")
    second = DirectionalLight([-1, 0.5, 1], "A", 0.37)
    scene = glossy(matt, mesh=sphere(subdivisions=2))
    both = radiance(scene.replace(lights=(first, second)))
    alone = [radiance(scene.replace(lights=(light,))) for light in (first, second)]
    np.testing.assert_allclose(
        both, alone[0] + 0.37 * alone[1], rtol=5 * FLOAT32, atol=1e-12
    )


@pytest.mark.parametrize("strength", [1e-3, 2.0, 1e4])
def test_radiance_is_linear_in_a_lights_strength(matt, strength):
    first = DirectionalLight([0, 0, 1])
    side = [1, 0, 1]
    with_one, with_more = (
        radiance(glossy(matt, lights=(first, DirectionalLight(side, "A", s))))
        for s in (1.0, strength)
    )
    alone = radiance(glossy(matt))
    np.testing.assert_allclose(
        with_more - alone,
        strength * (with_one - alone),
        rtol=1e-5,
        atol=8 * FLOAT32 * with_more.max(),
    )


def test_the_first_lights_strength_sets_the_scale(matt):
    lights = [DirectionalLight([0, 0, 1], "D65", s) for s in (1e-20, 1.0, 1e20)]
    pictures = [radiance(matt.replace(lights=(light,))) for light in lights]
    np.testing.assert_array_equal(pictures[0], pictures[1])
    np.testing.assert_array_equal(pictures[2], pictures[1])


def test_the_order_of_the_other_lights_does_not_matter(matt):
    first, *rest = (
        DirectionalLight(d, name, s)
        for d, name, s in (
            ([0, 0, 1], "D65", 1.0),
            ([1, 0, 1], "A", 0.2),
            ([0, 1, 1], "FL2", 3.0),
        )
    )
    here = radiance(glossy(matt, lights=(first, *rest)))
    there = radiance(glossy(matt, lights=(first, *rest[::-1])))
    np.testing.assert_allclose(here, there, rtol=3 * FLOAT32)


def test_a_sphere_falls_off_as_the_cosine(white):
    direction = np.array([0.6, 0.0, 0.8])
    mesh = sphere(40, 4)
    lit = white.replace(mesh=mesh, lights=(DirectionalLight(direction),))
    cosine = np.maximum(np.asarray(mesh.points) @ direction / 40, 0)
    expected = np.outer(cosine, vertex_spectrum(lit, 0).white)
    # Normals of the triangles' mean deviate from the radius by up to 0.5 degrees.
    np.testing.assert_allclose(
        radiance(lit), expected, rtol=0, atol=0.009 * expected.max()
    )
    dark = mesh.points @ direction < -1
    assert dark.sum() > 1000
    assert (radiance(lit)[dark] == 0).all()


@pytest.mark.parametrize("degrees", [0, 30, 60, 85, 89.9])
def test_a_patch_darkens_as_the_cosine(white, degrees):
    angle = np.deg2rad(degrees)
    light = DirectionalLight([np.sin(angle), 0, np.cos(angle)])
    tilted = white.replace(lights=(light,))
    np.testing.assert_allclose(
        radiance(tilted), np.cos(angle) * radiance(white), rtol=1e-6
    )


def test_the_diffuse_scale_is_alpha(white):
    np.testing.assert_allclose(
        radiance(white.replace(diffuse_scale=0.25)),
        0.25 * radiance(white),
        rtol=2 * FLOAT32,
    )


# The specular term ------------------------------------------------------------


def test_gloss_at_normal_incidence_is_beta_times_fresnel(white):
    # D = 1 and G/(N·V) = 1 there, so what is left is β ((n - 1)/(n + 1))² E.
    surface = TorranceSparrow(gamma=0.3, n=1.4, specular_scale=0.8)
    spectrum = vertex_spectrum(white.replace(surface=surface), 3)
    fresnel = (0.4 / 2.4) ** 2
    np.testing.assert_allclose(
        spectrum.specular, surface.beta * fresnel * spectrum.white, rtol=1e-12
    )
    np.testing.assert_allclose(spectrum.diffuse, spectrum.white, rtol=1e-12)


def test_gloss_has_the_colour_of_the_light(matt):
    scene = glossy(matt, lights=(DirectionalLight([1, 0, 2], "A"),))
    spectrum = vertex_spectrum(scene, 0)
    ratio = spectrum.specular / spectrum.white
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-12)
    assert ratio[0] > 0


@pytest.mark.parametrize("kind", SURFACES)
@pytest.mark.parametrize("tissue", ["epidermis", "dermis"])
def test_gloss_is_that_of_the_surface_at_each_wavelength(matt, kind, tissue):
    surface = SURFACES[kind](0.3, n=dispersion(tissue))
    lights = (DirectionalLight([1, 0, 2], "A"), DirectionalLight([-2, 1, 1], "D65"))
    camera = Camera([0.4, -0.8, 0.7], [0, 1, 0])
    scene = matt.replace(surface=surface, lights=lights, camera=camera)
    normal, n = np.array([0.0, 0.0, 1.0]), dispersion(tissue).index(scene.wavelengths)
    expected = sum(
        surface.evaluate(normal, light.direction, scene.camera.direction, n) * power
        for light, power in zip(lights, light_spectra(scene), strict=True)
    )
    found = vertex_spectrum(scene, 0).specular
    # Fresnel's law at a few indices stands for all bands to 1e-9.
    np.testing.assert_allclose(found, expected, rtol=2e-9)
    assert kind == "lambert" or found.min() > 0


def test_without_gloss_or_index_nothing_is_specular(matt):
    for surface in (TorranceSparrow(specular_scale=0), TorranceSparrow(n=1.0)):
        spectrum = vertex_spectrum(matt.replace(surface=surface), 0)
        assert (spectrum.specular == 0).all()


def test_matt_skin_looks_the_same_from_everywhere(matt):
    views = [Camera(d, [0, 1, 0.5]) for d in ([0, 0, 1], [1, 0, 1], [-3, 1, 0.1])]
    first, *others = (radiance(matt.replace(camera=camera)) for camera in views)
    for other in others:
        np.testing.assert_array_equal(other, first)


def test_light_and_viewer_may_change_places(white):
    # The BRDF Y/((N·L) E) is reciprocal; the specular part as well as the diffuse.
    a, b = np.array([0.3, 0.2, 1.0]), np.array([-0.8, 0.1, 0.4])
    parts = []
    for light, view in ((a, b), (b, a)):
        scene = glossy(
            white, lights=(DirectionalLight(light),), camera=Camera(view, [0, 1, 0])
        )
        spectrum = vertex_spectrum(scene, 0)
        cosine = light[2] / np.linalg.norm(light)
        parts.append((spectrum.diffuse + spectrum.specular) / cosine)
    np.testing.assert_allclose(*parts, rtol=1e-12)


# Spectra at one vertex --------------------------------------------------------


@pytest.mark.parametrize("uniform", [True, False])
def test_the_parts_of_a_vertexs_spectrum_sum_to_its_radiance(matt, uniform):
    mesh = sphere(subdivisions=2)
    rng = np.random.default_rng(1)
    values = rng.uniform(0.001, 0.1, (3,) if uniform else (mesh.n_points, 3))
    scene = glossy(
        matt,
        mesh=mesh,
        skin=Skin(matt.skin.model, values),
        lights=(DirectionalLight([1, 1, 1]), DirectionalLight([0, -1, 1], "A", 2.0)),
    )
    whole = radiance(scene)
    for vertex in range(0, mesh.n_points, 7):
        spectrum = vertex_spectrum(scene, vertex)
        np.testing.assert_allclose(
            spectrum.diffuse + spectrum.specular,
            whole[vertex],
            rtol=4 * FLOAT32,
            atol=1e-12,
        )
        np.testing.assert_array_equal(spectrum.wavelengths, scene.wavelengths)


@pytest.mark.parametrize("vertex", [-1, 81, 10**9, np.nan, "first", 1.5])
def test_a_vertex_that_the_mesh_lacks_is_refused(matt, vertex):
    with pytest.raises(ArgumentError, match="vertex"):
        vertex_spectrum(matt, vertex)


# Geometry ---------------------------------------------------------------------


def test_radiance_turns_with_the_scene(matt):
    motion = pose((0.7, -1.9, 0.4), (-524, 190, 296))
    turn = motion[:3, :3]
    lights = [(np.array([0.2, 0.4, 1.0]), "D65"), (np.array([1.0, 0, 0.1]), "A")]
    towards, up = np.array([0.3, 1.0, 0.2]), np.array([0.0, 0, 1])
    here = glossy(
        matt,
        mesh=toy_hand(),
        lights=tuple(DirectionalLight(d, name) for d, name in lights),
        camera=Camera(towards, up),
    )
    there = here.replace(
        mesh=moved(toy_hand(), motion),
        lights=tuple(DirectionalLight(turn @ d, name) for d, name in lights),
        camera=Camera(turn @ towards, turn @ up),
    )
    expected = radiance(here)
    np.testing.assert_allclose(
        radiance(there), expected, rtol=2e-6, atol=1e-9 * expected.max()
    )
    rgb = [np.asarray(shade(s).point_data["rgb"], dtype=int) for s in (here, there)]
    assert np.abs(rgb[0] - rgb[1]).max() <= 1


def test_radiance_does_not_depend_on_size(matt):
    points, faces = arrays(toy_hand())
    for scale in (1e-6, 1e6):
        scaled = matt.replace(mesh=polydata(scale * points, faces))
        np.testing.assert_allclose(
            radiance(scaled),
            radiance(matt.replace(mesh=toy_hand())),
            rtol=4 * FLOAT32,
            atol=1e-9,
        )


def test_normals_of_the_mesh_file_are_not_trusted(matt):
    lying = sphere(subdivisions=2)
    lying.point_data["Normals"] = np.tile([0.0, 0, 1], (lying.n_points, 1))
    np.testing.assert_array_equal(
        radiance(matt.replace(mesh=lying)),
        radiance(matt.replace(mesh=sphere(subdivisions=2))),
    )


def test_one_triangle_is_shaded(matt):
    triangle = polydata(np.eye(3), np.array([[0, 1, 2]]))
    light = DirectionalLight([1, 1, 1])
    got = radiance(matt.replace(mesh=triangle, lights=(light,)))
    np.testing.assert_allclose(got, np.tile(radiance(matt)[0], (3, 1)), rtol=1e-6)


def test_squares_are_shaded_as_their_triangles(matt):
    box = cube(30)
    light = DirectionalLight([1, 2, 3])
    try:
        scene = matt.replace(mesh=box, lights=(light,))
    except MeshError:
        return
    triangles = matt.replace(mesh=box.triangulate(), lights=(light,))
    np.testing.assert_array_equal(radiance(scene), radiance(triangles))


@pytest.mark.parametrize(
    ("extra_points", "extra_faces"),
    [
        ([[5.0, 5, 5]], []),
        ([[5.0, 5, 5], [6, 6, 6]], [[81, 82, 81]]),
        ([[5.0, 5, 5], [6, 6, 6], [7, 7, 7]], [[81, 82, 83]]),
    ],
    ids=["unreferenced", "two corners in one", "three in line"],
)
def test_a_vertex_without_a_normal_is_named(matt, extra_points, extra_faces):
    points, faces = arrays(plane())
    mesh = polydata(
        np.concatenate([points, extra_points]),
        np.concatenate([faces, np.array(extra_faces, dtype=int).reshape(-1, 3)]),
    )
    message = rf"vertex 81 .*\({len(extra_points)} such vertices\).*skinviz clean"
    with pytest.raises(MeshError, match=message):
        shade(matt.replace(mesh=mesh))


def test_a_triangle_without_area_between_others_does_no_harm(matt):
    points, faces = arrays(plane())
    mesh = polydata(points, np.concatenate([faces, [[0, 1, 1]]]))
    np.testing.assert_array_equal(radiance(matt.replace(mesh=mesh)), radiance(matt))


# Extremes ---------------------------------------------------------------------


@pytest.mark.parametrize("masking", ["v-cavity", "none"])
def test_nothing_is_negative_or_undefined_at_any_angle(matt, masking):
    rng = np.random.default_rng(2)
    mesh = sphere(subdivisions=3)
    normals = vertex_normals(*arrays(mesh))
    # Among the lights are ones that graze single vertices exactly.
    grazing = np.cross(normals[:20], rng.standard_normal((20, 3)))
    surface = TorranceSparrow(masking=masking)
    for light in (*rng.standard_normal((20, 3)), *grazing):
        for view in (light, -light, rng.standard_normal(3)):
            scene = matt.replace(
                mesh=mesh,
                surface=surface,
                lights=(DirectionalLight(light),),
                camera=Camera(view, rng.standard_normal(3)),
                wavelengths=[450, 550, 650],
            )
            got = radiance(scene)
            assert np.isfinite(got).all()
            assert got.min() >= 0


def test_light_from_behind_leaves_the_patch_black(matt):
    for direction in ([0, 0, -1], [1, 0, -1e-6], [1, 0, 0]):
        mesh = shade(glossy(matt, lights=(DirectionalLight(direction),)))
        assert (np.asarray(mesh.point_data["radiance"]) == 0).all()
        assert (np.asarray(mesh.point_data["rgb"]) == 0).all()
        assert mesh.field_data["over_exposed"][0] == 0


@pytest.mark.parametrize("exposure", [1e-30, 1e-9, 1e9, 1e30])
def test_radiance_is_linear_in_exposure_however_extreme(matt, exposure):
    np.testing.assert_allclose(
        radiance(glossy(matt, exposure=exposure)),
        exposure * radiance(glossy(matt)),
        rtol=4 * FLOAT32,
        atol=0,
    )


def test_extreme_exposure_is_black_or_white(matt):
    dark, bright = (shade(matt.replace(exposure=e)) for e in (1e-30, 1e30))
    assert (np.asarray(dark.point_data["rgb"]) == 0).all()
    assert (np.asarray(bright.point_data["rgb"]) == 255).all()
    assert bright.field_data["over_exposed"][0] == matt.mesh.n_points


@pytest.mark.parametrize("values", [[0, 0, 0], [1e-12] * 3, [1e12] * 3, [1e12, 0, 0]])
def test_extreme_pigments_stay_between_black_and_white(matt, values):
    got = radiance(matt.replace(skin=Skin(matt.skin.model, values)))
    white = vertex_spectrum(matt, 0).white
    assert np.isfinite(got).all()
    assert got.min() >= 0
    assert (got <= white * (1 + 1e-6)).all()


@pytest.mark.parametrize(
    "changes",
    [
        {"exposure": 1e30, "strengths": (1e-30, 1e30)},
        {"exposure": 1.0, "strengths": (1e-30, 1e30)},
        {"exposure": 1e30, "strengths": (1.0, 1e6)},
        {"exposure": 1e-30, "strengths": (1e30, 1e-30)},
        {"exposure": 1e30, "diffuse_scale": 1e6, "strengths": (1.0, 1.0)},
    ],
    ids=lambda c: " ".join(f"{k}={v}" for k, v in c.items()),
)
def test_extremes_together_are_right_or_refused(matt, changes):
    strengths = changes["strengths"]
    lights = tuple(
        DirectionalLight(d, "D65", s)
        for d, s in zip(([0, 0, 1], [0, 0, -1]), strengths, strict=True)
    )
    others = {k: v for k, v in changes.items() if k != "strengths"}
    scene = glossy(matt, lights=lights, **others)
    try:
        got = radiance(scene)
    except SkinvizError:
        return
    # The second light is behind the patch, so only the first counts.
    alone = radiance(scene.replace(lights=lights[:1]))
    np.testing.assert_allclose(got, alone, rtol=1e-6)
    assert np.isfinite(got).all()


@pytest.mark.parametrize("surface", [{"gamma": 1e-4}, {"gamma": np.pi / 2}, {"n": 3.0}])
def test_extreme_surfaces_stay_finite(matt, surface):
    scene = matt.replace(
        mesh=sphere(subdivisions=3), surface=TorranceSparrow(**surface)
    )
    got = radiance(scene)
    assert np.isfinite(got).all()
    assert got.min() >= 0


# What comes back --------------------------------------------------------------


def test_over_exposed_vertices_are_counted(matt, white):
    lit = np.array([[0.0, 0, 1]])
    mesh = sphere(40, 4)
    ball = white.replace(mesh=mesh, lights=(DirectionalLight(lit[0]),), exposure=2.0)
    shaded = shade(ball)
    # Twice the exposure puts white at half the full light: above 60 degrees none is.
    expected = (np.asarray(mesh.points)[:, 2] / 40 > 0.5).sum()
    assert shaded.field_data["over_exposed"][0] == pytest.approx(expected, rel=0.03)
    assert shade(matt).field_data["over_exposed"][0] == 0


def test_white_itself_is_not_over_exposed(white):
    # Rounded in the display's matrix, it is off 1 by less than half an 8-bit step.
    mesh = shade(white)
    assert (np.asarray(mesh.point_data["rgb"]) == 255).all()
    assert mesh.field_data["over_exposed"][0] == 0


def test_colours_outside_the_display_are_counted(white):
    green = shade(white.replace(wavelengths=[510.0]), Plan(spectrum="scene"))
    assert green.field_data["out_of_gamut"][0] == white.mesh.n_points
    assert shade(white).field_data["out_of_gamut"][0] == 0


def test_the_shaded_mesh_carries_what_it_is_made_of(matt):
    mesh = shade(matt)
    n = matt.mesh.n_points
    assert mesh.point_data["radiance"].shape == (n, 61)
    assert mesh.point_data["radiance"].dtype == np.float32
    assert mesh.point_data["rgb"].shape == (n, 3)
    assert mesh.point_data["rgb"].dtype == np.uint8
    np.testing.assert_array_equal(
        mesh.point_data["pigments"], np.tile(matt.skin.values, (n, 1))
    )
    np.testing.assert_array_equal(mesh.field_data["wavelengths"], matt.wavelengths)
    assert list(mesh.field_data["unit"]) == ["mm"]


def test_shading_leaves_the_scene_as_it_was(matt):
    before = np.array(matt.mesh.points)
    shade(matt)
    assert list(matt.mesh.point_data.keys()) == []
    assert list(matt.mesh.field_data.keys()) == []
    np.testing.assert_array_equal(matt.mesh.points, before)


def test_shading_twice_gives_the_same(matt):
    scene = glossy(matt, mesh=sphere(subdivisions=2))
    np.testing.assert_array_equal(radiance(scene), radiance(scene))


def test_pigments_out_of_their_range_are_refused(matt):
    for values in ([-1.0, 0, 0], [np.nan, 0, 0], [1e13, 0, 0]):
        with pytest.raises(ArgumentError, match="w_m"):
            shade(matt.replace(skin=Skin(matt.skin.model, values)))


def test_wavelengths_out_of_the_tables_are_refused(matt):
    with pytest.raises(ArgumentError, match="extrapolated"):
        shade(matt.replace(wavelengths=[300.0, 500.0]))


def test_a_tetrahedron_is_lit_where_it_faces_the_light(white):
    # The corner (0, 0, 1) of three faces: its normal is their area-weighted mean.
    scene = white.replace(mesh=tetrahedron(), lights=(DirectionalLight([0, 0, 1]),))
    normals = vertex_normals(*arrays(tetrahedron()))
    expected = np.outer(np.maximum(normals[:, 2], 0), vertex_spectrum(scene, 0).white)
    np.testing.assert_allclose(radiance(scene), expected, rtol=2 * FLOAT32)
    assert isinstance(scene, Scene)
