"""Uneven skin: off by default, the same for the same seed, in the amounts asked for."""

import numpy as np
import pytest
from hands import coarse_hand
from scipy.spatial import KDTree

from meshes import plane, toy_hand
from skinviz import Relief, Skin, SkinTexture, hand_frame, landmarks, textured
from skinviz.errors import ArgumentError, MeshError
from skinviz.scene.geodesics import surface_of
from skinviz.scene.noise import network, smooth_noise

EVEN = [0.1, 0.005, 0.005]


@pytest.fixture
def sheet(scene):
    """A square of 2 m, on which statistics are good."""
    return scene.replace(mesh=plane(201, 2000.0))


@pytest.fixture
def hand(scene):
    return scene.replace(mesh=coarse_hand())


def test_none_is_the_default(scene):
    same = textured(scene, SkinTexture())
    assert same.skin is scene.skin
    assert same.relief == Relief()
    assert Relief().depth == 0


def test_mottling_keeps_the_mean_and_has_the_spread_asked_for(sheet):
    texture = SkinTexture(melanin_mottling=0.3, mottling_mm=20)
    skin = textured(sheet, texture).skin.values
    np.testing.assert_allclose(skin[:, 0].mean(), EVEN[0], rtol=0.05)
    np.testing.assert_allclose(skin[:, 0].std() / skin[:, 0].mean(), 0.3, rtol=0.1)
    assert (skin[:, 0] > 0).all()
    np.testing.assert_array_equal(skin[:, 1:], np.broadcast_to(EVEN[1:], (40401, 2)))


def test_mottled_blood_keeps_its_saturation(sheet):
    skin = textured(sheet, SkinTexture(blood_mottling=0.3, mottling_mm=20)).skin.values
    np.testing.assert_allclose(skin[:, 1], skin[:, 2], rtol=1e-14)
    np.testing.assert_allclose(skin[:, 1].std() / EVEN[1], 0.3, rtol=0.15)
    assert (skin[:, 0] == EVEN[0]).all()


def test_a_seed_is_a_skin(sheet):
    def made(seed):
        texture = SkinTexture(melanin_mottling=0.2, mottling_mm=20, seed=seed)
        return textured(sheet, texture).skin.values[:, 0]

    np.testing.assert_array_equal(made(4), made(4))
    assert abs(np.corrcoef(made(4), made(5))[0, 1]) < 0.3


def test_texture_is_on_top_of_a_map(sheet):
    ramp = np.linspace(0.05, 0.2, sheet.mesh.n_points)
    values = np.stack([ramp, 0 * ramp, ramp / 20], axis=1)
    uneven = sheet.replace(skin=Skin(sheet.skin.model, values))
    texture = SkinTexture(melanin_mottling=0.2, mottling_mm=20)
    ratio = textured(uneven, texture).skin.values[:, 0] / ramp
    alone = textured(sheet, texture).skin.values[:, 0] / EVEN[0]
    np.testing.assert_allclose(ratio, alone, rtol=1e-12)


def test_noise_correlates_as_it_says():
    # Over many fields: mean 0, variance 1, exp(-r²/2) at a distance of r sizes.
    points = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4.5, 0], [0, 0, 12]])
    fields = np.stack(
        [smooth_noise(points, 3.0, np.random.default_rng(k)) for k in range(4000)]
    )
    expected = np.exp(-np.square([0.0, 1.0, 1.5, 4.0]) / 2)
    np.testing.assert_allclose(fields.mean(axis=0), 0, atol=0.06)
    np.testing.assert_allclose(fields.T @ fields[:, 0] / 4000, expected, atol=0.07)


def test_networks_tell_the_distance_from_their_walls():
    # By brute force: the nearest of many places where the distance is about 0.
    x = np.linspace(0, 60, 601)
    plane = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    distance = network(plane, np.array([10.0, 20.0]), 3)
    walls = KDTree(plane[distance < 0.05])
    near = (distance < 1.0) & (np.abs(plane - 30) < 25).all(axis=1)
    true, _ = walls.query(plane[near])
    assert np.median(np.abs(true - distance[near])) < 0.06
    assert np.quantile(np.abs(true - distance[near]), 0.9) < 0.3
    assert 0.05 < near.mean() < 0.3
    assert (distance >= 0).all()


def test_veins_are_on_the_back_and_only_there(hand):
    skin = textured(hand, SkinTexture(veins=0.05, vein_width_mm=6, seed=3)).skin.values
    frame, normals = hand_frame(hand.mesh), surface_of(hand.mesh).normals
    added = skin[:, 2] - EVEN[2]
    assert 0.02 < added.max() <= 0.05
    assert (added[normals @ frame.back < 0.2] == 0).all()
    at = landmarks(hand.mesh)
    assert added[[at[f"{f}_nail_bed"] for f in ("index", "ring", "little")]].max() == 0
    back = (normals @ frame.back > 0.8) & (added >= 0)
    assert 0.02 < (added[back] > 0.025).mean() < 0.4
    np.testing.assert_array_equal(
        skin[:, :2], np.broadcast_to(EVEN[:2], skin[:, :2].shape)
    )


def test_knuckles_are_redder_by_what_is_asked_for(hand):
    skin = textured(hand, SkinTexture(knuckle_redness=0.5)).skin.values
    at = landmarks(hand.mesh)
    np.testing.assert_allclose(skin[at["middle_knuckle"], 1], 1.5 * EVEN[1], rtol=1e-3)
    np.testing.assert_allclose(skin[at["index_joint"], 1], 1.5 * EVEN[1], rtol=1e-3)
    for name in ("palm", "wrist", "middle_fingertip"):
        np.testing.assert_allclose(skin[at[name], 1], EVEN[1], rtol=1e-3)


def test_folds_are_redder_and_ridges_are_not(scene):
    # A sheet with one fold down and one up, 3 mm wide.
    sheet = plane(81, 80.0)
    points = np.array(sheet.points)
    x = points[:, 0]
    points[:, 2] = 2 * np.exp(-(((x - 15) / 3) ** 2)) - 2 * np.exp(
        -(((x + 15) / 3) ** 2)
    )
    sheet.points = points
    skin = textured(scene.replace(mesh=sheet), SkinTexture(crease_redness=1.0)).skin
    redness = skin.values[:, 1] / EVEN[1] - 1
    middle = np.abs(points[:, 1]) < 20
    assert redness[middle & (x == -15)].min() > 0.4
    assert redness[middle & (x == 15)].max() == 0
    assert redness[middle & (np.abs(x) < 2)].max() < 0.02
    assert redness.max() <= 1


def test_the_history_tells_of_it(sheet):
    texture = SkinTexture(melanin_mottling=0.2, mottling_mm=20, seed=7)
    assert textured(sheet, texture).skin.history == (
        "texture: melanin_mottling 0.2, mottling_mm 20, seed 7",
    )


@pytest.mark.parametrize(
    ("amounts", "error", "message"),
    [
        ({"melanin_mottling": -0.1}, ArgumentError, "melanin_mottling must be in"),
        ({"relief_um": 1e4}, ArgumentError, "relief_um must be in .0, 500. µm"),
        ({"mottling_mm": 0}, ArgumentError, "mottling_mm must be"),
        ({"veins": "many"}, ArgumentError, "veins must be a number"),
        ({"seed": 1.5}, ArgumentError, "seed must be a whole number"),
        ({"seed": -1}, ArgumentError, "seed must be in"),
        (
            {"melanin_mottling": 0.1, "mottling_mm": 2},
            MeshError,
            "too fine for the mesh",
        ),
        ({"veins": 0.02, "vein_width_mm": 2}, MeshError, "vein_width_mm 2 is too fine"),
        ({"veins": 0.02, "vein_width_mm": 9}, MeshError, "no hand; .*are for hands"),
        ({"knuckle_redness": 0.2}, MeshError, "no hand; .*are for hands"),
    ],
)
def test_what_cannot_be_is_refused(scene, amounts, error, message):
    with pytest.raises(error, match=message):
        textured(scene, SkinTexture(**amounts))


def test_knuckles_need_fingers(scene):
    mitten = scene.replace(mesh=toy_hand(n_around=36, n_along=45))
    with pytest.raises(MeshError, match="fingers"):
        textured(mitten, SkinTexture(knuckle_redness=0.2))
