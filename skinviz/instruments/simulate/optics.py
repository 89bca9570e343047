"""Polarised light on a bench, by Stokes vectors and Mueller matrices.

Stokes vectors are (I, Q, U) with Q > 0 for s; azimuths are from the plane of incidence.
This is deliberately another way to write what ``instruments.polarisation`` inverts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UNPOLARISED = np.array([1.0, 0.0, 0.0])
"""Light of intensity 1."""


def amplitudes(angle: float, n: float) -> tuple[float, float]:
    """Return Fresnel's amplitudes s and p at an angle of incidence [rad].

    The signs are those of a picture in a mirror: both alike at normal incidence.
    """
    inside = np.arcsin(np.sin(angle) / n)
    cos_out, cos_in = np.cos(angle), np.cos(inside)
    s = (cos_out - n * cos_in) / (cos_out + n * cos_in)
    p = (cos_in - n * cos_out) / (cos_in + n * cos_out)
    return float(s), float(p)


def reflection(angle: float, n: float) -> Array:
    """Return the Mueller matrix (3, 3) of a mirror of this index at an angle [rad]."""
    return _matrix(*amplitudes(angle, n))


def transmission(angle: float, n: float) -> tuple[float, float]:
    """Return what share of s and of p goes through the surface at an angle [rad]."""
    s, p = amplitudes(angle, n)
    return 1 - s * s, 1 - p * p


def polariser(azimuth: float | None, leakage: float) -> Array:
    """Return the Mueller matrix (3, 3) of a polariser [degrees]; None is no polariser.

    ``leakage`` is what share of the other polarisation it lets through.
    """
    if azimuth is None:
        return np.eye(3)
    along = np.deg2rad(azimuth)
    # Q axis of the polariser: s has azimuth 90 degrees.
    cos, sin = -np.cos(2 * along), np.sin(2 * along)
    sharp, rest = (1 - leakage) / 2, np.sqrt(leakage * (1 - leakage))
    turn = np.array([[1, 0, 0], [0, cos, sin], [0, -sin, cos]])
    own = np.array([[0.5, sharp - leakage / 2, 0], [0, 0, 0], [0, 0, 0]])
    own[1, :2] = own[0, 1], own[0, 0]
    own[2, 2] = rest
    return np.asarray(turn.T @ own @ turn)


def _matrix(s: float, p: float) -> Array:
    """Return the Mueller matrix (3, 3) of amplitudes for s and p."""
    total, split = (s * s + p * p) / 2, (s * s - p * p) / 2
    return np.array([[total, split, 0.0], [split, total, 0.0], [0.0, 0.0, s * p]])
