"""Angles of light and viewer, as scene files have them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshes import toy_hand
from skinviz.scene.hand import hand_frame
from skinviz.view.viewer.state import ViewState
from skinviz.view.viewer.turning import (
    angles_of,
    eye,
    shifted,
    towards,
    turned,
    view_of,
    zoomed,
)

FRAME = hand_frame(toy_hand())
angles = st.floats(-179, 179)
tilts = st.floats(-89, 89)


@pytest.mark.parametrize("degrees", [0, 30, 60, -45])
def test_an_angle_is_that_of_scene_files(degrees):
    expected = FRAME.direction(np.deg2rad(degrees))
    np.testing.assert_allclose(towards(FRAME, degrees, 0), expected, atol=1e-12)
    direction, up = eye(FRAME, (degrees, 0.0, 0.0))
    opposite = FRAME.direction(-np.deg2rad(degrees))
    np.testing.assert_allclose(direction, opposite, atol=1e-12)
    np.testing.assert_allclose(up, FRAME.fingers, atol=1e-12)


@given(angles, tilts)
def test_angles_of_a_direction_lead_to_it(angle, tilt):
    direction = towards(FRAME, angle, tilt)
    assert np.linalg.norm(direction) == pytest.approx(1)
    np.testing.assert_allclose(
        towards(FRAME, *angles_of(FRAME, direction)), direction, atol=1e-6
    )


@given(angles, tilts, angles)
def test_a_view_is_known_by_its_eye(angle, tilt, roll):
    direction, up = eye(FRAME, (angle, tilt, roll))
    assert direction @ up == pytest.approx(0, abs=1e-12)
    again = eye(FRAME, view_of(FRAME, direction, up))
    np.testing.assert_allclose(again[0], direction, atol=1e-6)
    np.testing.assert_allclose(again[1], up, atol=1e-6)


def test_dragging_to_the_right_brings_the_left_into_view():
    direction, _ = eye(FRAME, turned(ViewState(), 0.25, 0.0).view)
    assert direction @ FRAME.side < -0.5


def test_dragging_down_brings_the_fingertips_into_view():
    direction, _ = eye(FRAME, turned(ViewState(), 0.0, 0.25).view)
    assert direction @ FRAME.fingers > 0.5


def test_turning_never_ends():
    state = ViewState()
    for _ in range(40):
        state = turned(state, 0.3, 0.3)
    assert -180 <= state.view[0] <= 180
    assert state.view[1] == 90


def test_zooming_in_and_out_again_is_where_it_was():
    assert zoomed(zoomed(ViewState(), 2), -2).zoom == pytest.approx(1, abs=1e-3)
    assert zoomed(ViewState(), 1000).zoom == 50


def test_the_picture_follows_the_mouse():
    assert shifted(ViewState(), 5.0, -2.0).shift == (-5.0, 2.0)
