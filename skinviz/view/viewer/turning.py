"""Angles about a hand, as the viewer's controls and the mouse set them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.scene.hand import HandFrame
from skinviz.view.viewer.state import ViewState

Array = NDArray[np.float64]

_DEGREES_A_PICTURE = 180.0  # that dragging over the whole width turns
_STEEPEST = 90.0
_ZOOM_STEP = 1.2


def towards(frame: HandFrame, angle: float, tilt: float) -> Array:
    """Return a direction by its angle to the viewer's left and its tilt up. [°]"""
    tilted = np.deg2rad(tilt)
    level = frame.direction(float(np.deg2rad(angle)))
    return np.asarray(np.cos(tilted) * level + np.sin(tilted) * frame.fingers)


def angles_of(frame: HandFrame, direction: Array) -> tuple[float, float]:
    """Return the angle and tilt of a direction. [°]"""
    tilt = np.arcsin(np.clip(direction @ frame.fingers, -1.0, 1.0))
    angle = np.arctan2(-(direction @ frame.side), direction @ frame.back)
    return _degrees(angle), _degrees(tilt)


def eye(frame: HandFrame, view: tuple[float, ...]) -> tuple[Array, Array]:
    """Return the direction to the viewer, and what is up for them.

    The viewer's angle counts to the right, so that 60/60 has light and viewer on
    opposite sides.
    """
    angle, tilt, roll = view
    direction, up = towards(frame, -angle, tilt), _upwards(frame, angle, tilt)
    right, turned = np.cross(up, direction), np.deg2rad(roll)
    return direction, np.asarray(np.cos(turned) * up + np.sin(turned) * right)


def view_of(frame: HandFrame, direction: Array, up: Array) -> tuple[float, ...]:
    """Return the angle, tilt and roll of a viewer. [°]"""
    angle, tilt = angles_of(frame, direction)
    level = _upwards(frame, -angle, tilt)
    roll = np.arctan2(up @ np.cross(level, direction), up @ level)
    return (-angle, tilt, _degrees(roll))


def turned(state: ViewState, across: float, along: float) -> ViewState:
    """Return the view after a drag, in shares of the picture to the right and down."""
    angle, tilt, roll = state.view
    turned_to = _wrapped(angle - _DEGREES_A_PICTURE * across)
    tilt = float(np.clip(tilt + _DEGREES_A_PICTURE * along, -_STEEPEST, _STEEPEST))
    return state.replace(view=(turned_to, round(tilt, 2), roll))


def shifted(state: ViewState, across: float, along: float) -> ViewState:
    """Return the view after the picture was moved [mm] to the right and up."""
    x, y = state.shift
    return state.replace(shift=(round(x - across, 3), round(y - along, 3)))


def zoomed(state: ViewState, steps: float) -> ViewState:
    """Return the view some steps nearer, or farther."""
    zoom = float(np.clip(state.zoom * _ZOOM_STEP**steps, 0.1, 50.0))
    return state.replace(zoom=round(zoom, 4))


def _upwards(frame: HandFrame, angle: float, tilt: float) -> Array:
    """Return what is up for a viewer without roll."""
    tilted = np.deg2rad(tilt)
    level = frame.direction(-float(np.deg2rad(angle)))
    return np.asarray(np.cos(tilted) * frame.fingers - np.sin(tilted) * level)


def _wrapped(angle: float) -> float:
    """Return an angle within -180° to 180°."""
    return round((angle + 180.0) % 360.0 - 180.0, 2)


def _degrees(angle: Any) -> float:
    """Return an angle in degrees without the last digits' noise or negative zero."""
    return round(float(np.rad2deg(angle)), 6) + 0.0
