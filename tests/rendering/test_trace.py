"""Rays against brute force in float64: what is hit, where, and what shades it."""

import numpy as np
import pytest
from oracles import rays as brute

from meshes import joined, moved, plane, polydata, pose, sphere, toy_hand
from skinviz import Camera, DirectionalLight, Plan, PointLight
from skinviz.rendering import trace
from skinviz.rendering.stage import stage_of

Z, UP = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]

CLEAR = 1e-5
"""Crossings nearer to an edge may be of either triangle: rays are float32."""

VIEWS = {
    "front": Camera([0, 0, 1], [0, 1, 0], (23, 17)),
    "oblique": Camera([0.3, -0.5, 1], [0.2, 1, 0], (16, 20)),
    "near": Camera([0.3, -0.5, 1], [0.2, 1, 0], (20, 20), distance=300.0),
    "close": Camera([1, 0.2, 0.1], [0, 0, 1], (20, 20), distance=60.0, height=40.0),
    "far": Camera([-1, 0.4, 0.3], [0, 0, 1], (20, 20), distance=1e7),
}


def soup(n=60, size=50.0):
    """Triangles anywhere, that pierce each other."""
    rng = np.random.default_rng(3)
    centres = rng.uniform(-size / 2, size / 2, (n, 1, 3))
    corners = centres + rng.normal(0, size / 6, (n, 3, 3))
    return polydata(corners.reshape(-1, 3), np.arange(3 * n).reshape(n, 3))


def two_spheres():
    """One partly before the other."""
    return joined(sphere(20, 2), sphere(12, 2, centre=(18, 5, 25)))


MESHES = {
    "soup": soup(),
    "spheres": two_spheres(),
    "hand": moved(toy_hand(80.0, 12, 14), pose((1.3, 0.4, -0.7), (3, -9, 20))),
    "far away": moved(soup(), pose((0.1, 0.2, 0.3), (-4e4, 7e4, 1e5))),
}


@pytest.fixture(params=MESHES)
def mesh(request):
    return MESHES[request.param]


@pytest.fixture(params=VIEWS)
def camera(request):
    return VIEWS[request.param]


def places(view, cells, pixels):
    """Columns and rows (n, 2) of the samples of pixels, those of a pixel in a row."""
    row, column = np.divmod(pixels, view.size[0])
    corner = np.stack([column, row], axis=1)
    return (corner[:, None] + cells).reshape(-1, 2)


def rays_of(view, at):
    """Origins and unit directions (n, 3) [mm] of rays through places of a picture."""
    width, height = view.size
    x, y = (at - np.array([width, height]) / 2).T * view.pixel
    across = x[:, None] * view.right - y[:, None] * view.up
    directions = across / view.distance - view.direction
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    # From the eye, or from before the mesh where the eye is so far that digits go.
    back = min(view.distance, 1e3)
    return view.target + across - back * directions, directions / length


def seen_by_brute_force(stage, at):
    """What the rays through places meet in the mesh as it was given, and where."""
    points = np.asarray(stage.scene.mesh.points)
    faces = np.asarray(stage.scene.mesh.regular_faces)
    origins, directions = rays_of(stage.sight.view, at)
    found = brute.nearest(origins, directions, points, faces)
    a, b, c = (points[faces[:, k]] for k in range(3))
    towards = np.cross(b - a, c - a)[found.triangle]
    front = (found.triangle >= 0) & ((towards * directions).sum(axis=1) < 0)
    where = np.einsum("nk,nkx->nx", found.weights, points[faces[found.triangle]])
    return found, front, where


def cast(stage, cells=None):
    width, height = stage.sight.view.size
    cells = stage.plan.cells if cells is None else cells
    pixels = np.arange(width * height)
    return trace.cast(stage.sight, cells, pixels), places(
        stage.sight.view, cells, pixels
    )


def in_mm(stage, points):
    return stage.geometry.centre + stage.geometry.scale * points.T


# What is hit --------------------------------------------------------------------


def test_rays_hit_what_brute_force_finds(white, mesh, camera):
    stage = stage_of(white.replace(mesh=mesh, camera=camera), Plan(samples=1))
    hits, at = cast(stage)
    found, front, where = seen_by_brute_force(stage, at)
    clear = found.margin > CLEAR
    assert clear.mean() > 0.9
    assert (front & clear).sum() > 20
    by_pixel = np.full(len(at), -1)
    by_pixel[hits.pixels] = np.arange(hits.pixels.size)
    np.testing.assert_array_equal((by_pixel >= 0)[clear], front[clear])
    np.testing.assert_array_equal(hits.covered[clear], (found.triangle >= 0)[clear])
    sure = front & clear
    mine = by_pixel[sure]
    np.testing.assert_array_equal(hits.triangles[mine], found.triangle[sure])
    # Weights divide by areas that may be slivers of the mesh's square.
    size = np.abs(np.asarray(mesh.points)).max() / stage.geometry.scale
    np.testing.assert_allclose(
        hits.weights[:, mine].T, found.weights[sure], rtol=0, atol=1e-10 * size
    )
    np.testing.assert_allclose(
        in_mm(stage, hits.points[:, mine]),
        where[sure],
        rtol=0,
        atol=1e-12 * size * stage.geometry.scale,
    )


def test_hits_are_where_the_view_says_that_they_are_seen(white, mesh, camera):
    stage = stage_of(white.replace(mesh=mesh, camera=camera), Plan(samples=4))
    hits, _ = cast(stage)
    shown = stage.sight.view.project(in_mm(stage, hits.points))
    inner = hits.weights.min(axis=0) > CLEAR
    assert inner.mean() > 0.9
    pixels = np.stack(np.divmod(hits.pixels, stage.sight.view.size[0])[::-1], axis=1)
    inside = shown - pixels
    assert ((inside > 0) & (inside < 1)).all()
    apart = np.abs(inside[:, None] - stage.plan.cells).max(axis=2).min(axis=1)
    np.testing.assert_allclose(apart[inner], 0, atol=1e-7)
    # Also those that float32 placed beside their triangle are hardly anywhere else.
    np.testing.assert_allclose(apart, 0, atol=1e-3)


def test_hits_are_on_their_triangles_with_unit_normals(white, mesh, camera):
    stage = stage_of(white.replace(mesh=mesh, camera=camera))
    hits, _ = cast(stage)
    corners = stage.geometry.points[stage.geometry.faces[hits.triangles]]
    a, b, c = corners.transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    off = ((hits.points.T - a) * across).sum(axis=1)
    np.testing.assert_allclose(off, 0, atol=1e-12)
    assert (hits.weights >= 0).all()
    np.testing.assert_allclose(hits.weights.sum(axis=0), 1, rtol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(hits.normals, axis=0), 1, rtol=1e-14)
    smooth = np.einsum(
        "kn,nkx->nx",
        hits.weights,
        stage.geometry.normals[stage.geometry.faces[hits.triangles]],
    )
    length = np.linalg.norm(smooth, axis=1, keepdims=True)
    clear = length[:, 0] > 1e-3
    np.testing.assert_allclose(
        hits.normals.T[clear], (smooth / length)[clear], rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("distance", [np.inf, 300.0])
@pytest.mark.parametrize("height", [1e-3, 1e-6])
def test_hits_beside_their_triangle_are_taken_to_its_edge(white, height, distance):
    # So near to an edge that float32 places rays on the wrong side of it.
    mesh = moved(plane(9), pose((0.3, 0.2, 0.1), (7, 3, -5)))
    corner = np.asarray(mesh.points)[40]
    camera = Camera(Z, UP, (32, 32), distance, target=corner, height=height)
    stage = stage_of(white.replace(mesh=mesh, camera=camera), Plan(1))
    hits, _ = cast(stage)
    assert hits.pixels.size == 32 * 32
    assert (hits.weights >= 0).all()
    assert (hits.weights.min(axis=0) == 0).any()
    np.testing.assert_allclose(
        in_mm(stage, hits.points), np.tile(corner, (32 * 32, 1)), atol=height
    )


def test_hits_come_in_the_pixels_order(white, mesh):
    stage = stage_of(white.replace(mesh=mesh, camera=VIEWS["front"]))
    hits, _ = cast(stage)
    assert (np.diff(hits.pixels) >= 0).all()
    assert hits.covered.max() <= 16
    front = np.bincount(hits.pixels, minlength=hits.covered.size)
    assert (front <= hits.covered).all()


def test_pixels_do_not_depend_on_their_neighbours(white, mesh):
    stage = stage_of(white.replace(mesh=mesh, camera=VIEWS["near"]))
    hits, _ = cast(stage)
    asked = np.arange(3, 400, 7)
    some = trace.cast(stage.sight, stage.plan.cells, asked)
    kept = np.isin(hits.pixels, asked)
    np.testing.assert_array_equal(asked[some.pixels], hits.pixels[kept])
    np.testing.assert_array_equal(some.triangles, hits.triangles[kept])
    np.testing.assert_array_equal(some.weights, hits.weights[:, kept])
    np.testing.assert_array_equal(some.points, hits.points[:, kept])
    np.testing.assert_array_equal(some.normals, hits.normals[:, kept])
    np.testing.assert_array_equal(some.lifted, hits.lifted[:, kept])


def test_no_pixels_and_pixels_of_nothing_have_no_hits(white):
    stage = stage_of(white.replace(mesh=sphere(40, 1), camera=VIEWS["front"]))
    for pixels in (np.arange(0), np.array([0])):
        hits = trace.cast(stage.sight, stage.plan.cells, pixels)
        assert hits.pixels.size == hits.triangles.size == hits.points.size == 0
        np.testing.assert_array_equal(hits.covered, np.zeros(pixels.size))


def test_the_inside_of_a_mesh_covers_but_is_not_lit(white):
    seen_from_behind = Camera([0, 0, -1], [0, 1, 0], (8, 8), height=20.0)
    stage = stage_of(white.replace(camera=seen_from_behind))
    hits, _ = cast(stage)
    assert hits.pixels.size == 0
    assert (hits.covered == 16).all()


def test_what_is_behind_the_eye_is_not_seen(white):
    # Two plates that face +z, the eye between them looking at the lower one.
    plates = joined(plane(3), moved(plane(3), pose(shift=(0, 0, 30))))
    camera = Camera(
        [0, 0, 1], [0, 1, 0], (8, 8), distance=10, height=8, target=[0, 0, 5]
    )
    stage = stage_of(white.replace(mesh=plates, camera=camera))
    hits, _ = cast(stage)
    assert (hits.covered == 16).all()
    np.testing.assert_allclose(in_mm(stage, hits.points)[:, 2], 0, atol=1e-12)


def test_values_at_the_corners_are_interpolated(white):
    mesh = MESHES["spheres"]
    stage = stage_of(white.replace(mesh=mesh, camera=VIEWS["near"]))
    hits, _ = cast(stage)
    # The coordinates themselves are linear over each triangle.
    fields = np.concatenate([stage.geometry.points, np.ones((mesh.n_points, 1))], 1)
    np.testing.assert_allclose(
        trace.at_corners(stage.geometry, hits, fields),
        [*hits.points, np.ones(hits.pixels.size)],
        rtol=1e-14,
        atol=1e-14,
    )


# What shades it -----------------------------------------------------------------

LIGHTS = {
    "far": DirectionalLight([0.5, 0.4, 1]),
    "side": DirectionalLight([1, -0.2, 0.1]),
    "near": PointLight([30, 10, 60]),
    "among": PointLight([9.5, -2.5, 21]),
}


@pytest.mark.parametrize("name", LIGHTS)
@pytest.mark.parametrize("what", ["soup", "spheres"])
def test_shadows_are_what_brute_force_finds(white, what, name):
    scene = white.replace(
        mesh=MESHES[what], camera=VIEWS["front"], lights=(LIGHTS[name],)
    )
    stage = stage_of(scene, Plan(samples=1))
    hits, _ = cast(stage)
    flat = np.zeros_like(hits.facets)  # rays start at ``lifted``, no higher
    seen = (stage.geometry, stage.bands.lighting, hits.lifted, hits.normals)
    visible = trace.visibility(*seen, flat)[0]
    # A triangle's own shadow is lifted where the smooth surface faces the light.
    turned = (hits.facets.T * stage.bands.lighting.lights[0, :3]).sum(axis=1) >= 0
    if not stage.bands.lighting.lights[0, 3]:
        raised = trace.visibility(*seen, hits.facets)[0]
        np.testing.assert_array_equal(raised[turned], visible[turned])
    light = stage.bands.lighting.lights[0]
    towards = light[:3] - light[3] * hits.lifted.T
    length = np.linalg.norm(towards, axis=1)
    directions = towards / length[:, None]
    reach = length if light[3] else np.full(len(length), 1e6)
    points, faces = stage.geometry.points, stage.geometry.faces
    found = brute.nearest(hits.lifted.T, directions, points, faces)
    faces_it = (hits.normals.T * directions).sum(axis=1) > 0
    clear = (found.margin > CLEAR) & (np.abs(found.distance - reach) > CLEAR)
    assert clear.mean() > 0.8
    lit = faces_it & ~(found.distance < reach)
    np.testing.assert_array_equal(visible[clear], lit[clear])
    assert 0 < lit[clear].sum() < clear.sum()
