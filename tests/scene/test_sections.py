"""Sections of shapes whose sections are known."""

import numpy as np
import pytest

from meshes import pose, sphere, toy_hand, tube
from skinviz.scan import topology
from skinviz.scene.sections import narrowest, sections


@pytest.mark.parametrize("height", [-30.0, 0.3, 25.0])
def test_a_spheres_section_is_a_circle(height):
    points, faces = topology.arrays(sphere(40, 5))
    axis = np.array([1.0, 2, 2]) / 3
    (cut,) = sections(points, faces, points @ axis, [height])
    radius = np.sqrt(40**2 - height**2)
    assert cut.area(axis) == pytest.approx(np.pi * radius**2, rel=0.005)
    assert cut.width(np.array([2.0, -2, 1]) / 3) == pytest.approx(2 * radius, rel=0.005)
    np.testing.assert_allclose(cut.centre, height * axis, atol=0.05)


def test_two_fingers_sections_add():
    points, faces = topology.arrays(tube(10, 50))
    twice = np.concatenate([points, points + np.array([50.0, 0, 0])])
    both = np.concatenate([faces, faces + len(points)])
    (cut,) = sections(twice, both, twice[:, 2], [21.0])
    (one,) = sections(points, faces, points[:, 2], [21.0])
    up = np.array([0.0, 0, 1])
    assert cut.area(up) == pytest.approx(2 * one.area(up))
    assert cut.width(np.array([1.0, 0, 0])) == pytest.approx(70, abs=0.1)


def test_a_plane_that_misses_cuts_nothing():
    points, faces = topology.arrays(sphere())
    (cut,) = sections(points, faces, points[:, 2], [100])
    assert len(cut.starts) == len(cut.ends) == 0
    assert cut.area(np.array([0.0, 0, 1])) == 0


def test_an_hourglass_is_narrowest_at_its_waist():
    points, faces = topology.arrays(tube(20, 200, n_along=80))
    points[:, :2] *= 1 + ((points[:, 2:] - 70) / 60) ** 2
    points[:, :2] *= np.sqrt(np.clip((200 - points[:, 2:]) / 40, 1e-6, 1))
    up = np.array([0.0, 0, 1])
    assert narrowest(points, faces, up, 0.0) == pytest.approx(70, abs=4)
    turn = pose((0.4, -1.0, 0.7))[:3, :3]
    turned = narrowest(points @ turn.T, faces, turn @ up, 0.0)
    assert turned == pytest.approx(narrowest(points, faces, up, 0.0))


def test_a_mitten_without_a_wrist_is_narrowest_nowhere():
    points, faces = topology.arrays(toy_hand())
    assert narrowest(points, faces, np.array([0.0, 0, 1]), 0.0) is None
