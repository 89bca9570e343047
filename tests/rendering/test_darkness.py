"""Pictures without light: each is drawn, and says why it is empty or black."""

import warnings

import numpy as np
import pytest

from meshes import joined, moved, plane, polydata, pose, sphere
from skinviz import (
    Camera,
    DirectionalLight,
    Plan,
    PointLight,
    Skin,
    TorranceSparrow,
    render,
)
from skinviz.errors import ArgumentError, SceneWarning

BALL = sphere(40, 2)
FRONT = Camera([0, 0, 1], [0, 1, 0], (12, 12))
BEHIND = DirectionalLight([0, 0, -1])
PLAN = Plan(samples=1)


def turned_over(mesh):
    return polydata(np.asarray(mesh.points), np.asarray(mesh.regular_faces)[:, ::-1])


@pytest.fixture
def ball(white):
    """A white sphere lit from the viewer."""
    return white.replace(mesh=BALL, camera=FRONT)


def black(scene, told, plan=PLAN):
    """Draw a scene, see that it is black and why, and return the reasons."""
    with pytest.warns(SceneWarning) as caught:
        picture = render(scene, plan)
    assert tuple(str(warning.message) for warning in caught) == picture.notes
    assert picture.metadata["notes"] == list(picture.notes)
    rim = np.count_nonzero(picture.xyz[..., 1])
    assert rim <= 0.01 * np.count_nonzero(picture.covered)
    assert any(told in note for note in picture.notes), picture.notes
    return picture


def test_a_lit_picture_has_nothing_to_say(ball):
    picture = render(ball, PLAN)
    assert picture.notes == ()
    assert picture.xyz.any()


def test_a_light_behind_everything_lights_nothing(ball):
    black(ball.replace(lights=(BEHIND,)), "light 1 is behind everything")
    near = PointLight([0, 0, -100])
    black(ball.replace(lights=(near,)), "light 1 is behind everything")


@pytest.mark.parametrize("plan", [PLAN, Plan(1, shadows=False)])
def test_a_light_inside_the_mesh_lights_nothing(ball, plan):
    inside = PointLight([10, 5, -8])
    black(ball.replace(lights=(inside,)), "light 1 is inside the mesh", plan)


def test_every_light_has_its_own_reason(ball):
    lights = (PointLight([10, 5, -8]), BEHIND)
    notes = black(ball.replace(lights=lights), "light 1 is inside").notes
    assert len(notes) == 2
    assert "light 2 is behind" in notes[1]


def test_light_that_only_touches_the_rim_is_behind(ball):
    # Normals at the rim of a coarse sphere face away from the viewer by a few degrees.
    fine = Camera([0, 0, 1], [0, 1, 0], (200, 200))
    picture = black(
        ball.replace(mesh=sphere(40, 4), camera=fine, lights=(BEHIND,)), "is behind"
    )
    assert picture.xyz[..., 1].max() < 0.05


def test_light_at_right_angles_is_not_behind(ball):
    assert render(ball.replace(lights=(DirectionalLight([1, 0, -0.5]),))).notes == ()


def test_one_light_that_shines_is_enough(ball):
    lights = (DirectionalLight([0, 0, 1]), BEHIND, PointLight([1, 2, 3]))
    assert render(ball.replace(lights=lights), PLAN).notes == ()


def test_a_light_that_the_mesh_hides_lights_nothing(white):
    # A large plate between the light and a small one that alone is seen.
    roof = moved(plane(2, 400.0), pose(shift=(0, 0, 90)))
    mesh = joined(plane(2, 20.0), roof)
    camera = Camera([0, 4, 1], [0, 0, 1], (4, 4), target=[0, 0, 0], height=2.0)
    scene = white.replace(
        mesh=mesh, camera=camera, lights=(DirectionalLight([0, 0, 1]),)
    )
    black(scene, "the mesh hides light 1 from everything that the camera sees")
    assert render(scene, Plan(1, shadows=False)).notes == ()


def test_a_light_at_the_centroid_has_no_strength(ball):
    with pytest.raises(ArgumentError, match="light 2 stands at the mesh's centroid"):
        render(
            ball.replace(lights=(DirectionalLight([0, 0, 1]), PointLight([0, 0, 0])))
        )


@pytest.mark.parametrize("direction", [[0, 0, 1], [0.3, -2, -1]])
def test_a_mesh_inside_out_says_so(ball, direction):
    scene = ball.replace(mesh=turned_over(BALL), lights=(DirectionalLight(direction),))
    picture = black(scene, "normals point inwards")
    assert len(picture.notes) == 1
    assert picture.covered.any()


@pytest.mark.parametrize("turn", [(0, 0, 0), (0.3, -0.2, 0.9)])
def test_a_plate_seen_from_behind_says_so(white, turn):
    behind = Camera([0, 0, -1], [0, 1, 0], (6, 6))
    scene = white.replace(
        mesh=moved(plane(), pose(turn)), camera=behind, lights=(BEHIND,)
    )
    assert len(black(scene, "only the inside of the mesh is seen").notes) == 1


def test_light_that_nothing_reflects_says_so(ball):
    dark = ball.replace(diffuse_scale=0.0)
    assert len(black(dark, "diffuse_scale is 0").notes) == 1
    soot = ball.replace(skin=Skin(ball.skin.model, [0.0]))
    assert len(black(soot, "the skin absorbs all").notes) == 1
    shiny = dark.replace(surface=TorranceSparrow())
    assert render(shiny, PLAN).notes == ()


def test_without_fresnel_the_surface_reflects_nothing(ball):
    black(
        ball.replace(diffuse_scale=0.0, surface=TorranceSparrow(n=1.0)),
        "diffuse_scale is 0",
    )


@pytest.mark.parametrize("distance", [np.inf, 500.0, 5.0])
def test_a_camera_that_looks_past_the_mesh_says_so(ball, distance):
    aside = Camera(
        [0, 0, 1], [0, 1, 0], (5, 5), target=[999, 0, 0], height=9, distance=distance
    )
    picture = black(ball.replace(camera=aside), "no ray meets the mesh")
    assert not picture.covered.any()
    assert (picture.rgb == ball.background).all()


def test_warnings_point_at_the_call(ball):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        render(ball.replace(lights=(BEHIND,)), PLAN)
    assert [warning.filename for warning in caught] == [__file__]


# Cameras that are too near --------------------------------------------------------


def test_a_camera_inside_the_mesh_is_refused(ball):
    inside = Camera([0, 0, 1], [0, 1, 0], (5, 5), distance=30.0, height=10.0)
    with pytest.raises(ArgumentError, match=r"camera is inside the mesh.*distance"):
        render(ball.replace(camera=inside), PLAN)


@pytest.mark.parametrize("distance", [1.0, 40.0, 40.01])
def test_a_camera_nearer_than_the_mesh_must_say_what_it_shows(ball, distance):
    near = Camera([0, 0, 1], [0, 1, 0], (5, 5), distance=distance)
    with pytest.raises(ArgumentError, match=r"not in front of the whole mesh.*height"):
        render(ball.replace(camera=near), PLAN)


def test_a_camera_just_off_the_mesh_sees_it(ball):
    # The icosphere has a point at the pole neither of facets, so a facet is 1 mm off.
    near = Camera([0, 0, 1], [0, 1, 0], (8, 8), distance=40.5, height=5.0)
    picture = render(ball.replace(camera=near), PLAN)
    assert (picture.covered == 1).all()
    assert (picture.xyz[..., 1] > 0.9).all()
